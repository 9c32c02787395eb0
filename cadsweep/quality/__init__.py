"""Metrics and checks of meshes, on arrays: what every mesh passes before it is handed over."""

from .accumulate import QualityAccumulator
from .bernstein import positive_inside
from .block_faces import block_problems
from .check import check_mesh, make_report
from .limits import HEX_CORNERS, BoundaryLimit, Ways, boundary_limit, corner_limits
from .metrics import (
    HexMetrics,
    measure_hexes,
    quad_areas,
    quad_scaled_jacobians,
    scaled_jacobians,
    volume_and_area,
)
from .overlap import BoundaryCrossing, find_crossings
from .report import CadReference, MetricSummary, QualityReport, WorstHex
from .several import PartSurface, fit_surfaces, name_quads, part_surfaces, shared_problems
from .skin import Skin, SurfaceFindings, check_skin, check_surface, of_whole
from .structure import structure_problems

__all__ = [
    "HEX_CORNERS",
    "BoundaryCrossing",
    "BoundaryLimit",
    "CadReference",
    "HexMetrics",
    "MetricSummary",
    "PartSurface",
    "QualityAccumulator",
    "QualityReport",
    "Skin",
    "SurfaceFindings",
    "Ways",
    "WorstHex",
    "block_problems",
    "boundary_limit",
    "check_mesh",
    "check_skin",
    "check_surface",
    "corner_limits",
    "find_crossings",
    "fit_surfaces",
    "make_report",
    "measure_hexes",
    "name_quads",
    "of_whole",
    "part_surfaces",
    "positive_inside",
    "quad_areas",
    "quad_scaled_jacobians",
    "scaled_jacobians",
    "shared_problems",
    "structure_problems",
    "volume_and_area",
]
