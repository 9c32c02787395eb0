"""Meshes of order 2: middle nodes, and where they must leave the straight line."""
