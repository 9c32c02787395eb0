"""Metrics and checks of meshes, on arrays: what every mesh passes before it is handed over."""

from .accumulate import QualityAccumulator
from .check import check_mesh, check_surface, make_report
from .limits import BoundaryLimit, boundary_limit
from .metrics import HexMetrics, measure_hexes, quad_areas, quad_scaled_jacobians, scaled_jacobians
from .report import CadReference, MetricSummary, QualityReport, WorstHex, describe_hex

__all__ = [
    "BoundaryLimit",
    "CadReference",
    "HexMetrics",
    "MetricSummary",
    "QualityAccumulator",
    "QualityReport",
    "WorstHex",
    "boundary_limit",
    "check_mesh",
    "check_surface",
    "describe_hex",
    "make_report",
    "measure_hexes",
    "quad_areas",
    "quad_scaled_jacobians",
    "scaled_jacobians",
]
