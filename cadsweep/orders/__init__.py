"""Meshes of orders above 1: nodes between the corners, and where they must leave the straight line."""
