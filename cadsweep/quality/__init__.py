"""Metrics and checks of meshes, on arrays: what every mesh passes before it is handed over."""

from .metrics import HexMetrics, measure_hexes, quad_areas, quad_scaled_jacobians, scaled_jacobians

__all__ = [
    "HexMetrics",
    "measure_hexes",
    "quad_areas",
    "quad_scaled_jacobians",
    "scaled_jacobians",
]
