"""Curves and surfaces as numpy: points, derivatives, nearest points, areas and angles, thousands at a time."""
