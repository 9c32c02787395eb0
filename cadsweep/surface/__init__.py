"""The surface stage: ring nodes on edges and linking sides, quads on the source cap.

Place in the flow: after ``intervals``, before ``projection``. Cells, and the plane of
columns, are meshed through a :class:`Skeleton`.

Method: the counts fix where every vertex stands in a grid of ring nodes times layers (``layout``);
edges divide themselves by layer places and by the affine image of the source loop (``spacing``);
linking sides are filled transfinitely in their parameters (``sides``, ``transfinite``); the source
cap gets quads on exactly the nodes of its loops (``quads``, with gmsh where it has no four sides).
"""

from __future__ import annotations

from .abreast import rails_abreast
from .background import limited as limited_sizes
from .background import triangulated
from .boundary import CellBoundary, boundary_of, mesh_boundary, surface_mesh
from .chains import Chain, ChainPiece, chains_of, divided, say_chains, turned
from .grading import (
    Division,
    fractions_from,
    graded_fractions,
    graded_together,
    turned_round,
)
from .matching import match_quads
from .memory import Memory
from .opposite import opposite_angles
from .partners import Motion, Partners
from .rings import Rings, lay_rings
from .skeleton import FaceMesh, Skeleton, grid_quads, turn_grid
from .stars import lay_star, patches_of
from .wall_columns import column_length
from .walls import Walls

__all__ = [
    "CellBoundary",
    "Chain",
    "ChainPiece",
    "Division",
    "FaceMesh",
    "Memory",
    "Motion",
    "Partners",
    "Rings",
    "Skeleton",
    "Walls",
    "boundary_of",
    "chains_of",
    "column_length",
    "divided",
    "fractions_from",
    "graded_fractions",
    "graded_together",
    "grid_quads",
    "lay_rings",
    "lay_star",
    "limited_sizes",
    "match_quads",
    "mesh_boundary",
    "opposite_angles",
    "patches_of",
    "rails_abreast",
    "say_chains",
    "surface_mesh",
    "triangulated",
    "turn_grid",
    "turned",
    "turned_round",
]
