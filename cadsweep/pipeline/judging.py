"""Whether the mesh of one way is good enough, by what the part itself allows: what others may do better.

Place in the flow: asked by :mod:`.routes` between the ways.
"""

from __future__ import annotations

import math

import numpy as np

from ..brep import Solid
from ..options import SweepOptions
from ..quality import QualityReport
from .candidates import GOOD_ENOUGH, POINTED, POOR
from .origin import AnyMesh, quality_of, worst_of

GOOD_STACK = 0.3
"""Worst scaled Jacobian of columns at which no cells are tried, where their outlines and the lean of their caps let
them have it: outlines seen along one direction may cross sharply, and the flank of a boss with draft, if it is a cap,
gets quads as long as the boss is high, however well they are smoothed."""
FAIR_STACK = 0.5
"""The same where something round lies across them."""
FAR_WORSE = 1.5
"""How many times as good as a poor mesh a fitted grid must be to be taken: it has no layers, and no caps."""
_EXPLAINED = 0.5
"""Share of the sine of the part's sharpest corner above which a worst scaled Jacobian is the part's own."""
_SPLIT = 0.45
"""The same of a fitted grid, in whose rims two quads share a corner."""
_AT = 2.0
"""Radii of a hexahedron within which of a corner or an edge it lies at that."""
_OF_PLACING = ("functional", "strategy", "residual", "smoothing", "allow_inverted")
"""Options whose user wants to see what becomes of a sweep, poor or not."""


def is_poor(mesh: AnyMesh, solid: Solid, options: SweepOptions) -> bool:
    """Whether quite another mesh is tried: neither a sharp corner of the solid nor its user's choice is to blame."""
    worst = worst_of(mesh)
    if worst >= POOR or is_of_placing(options):
        return False
    return worst < _EXPLAINED * _sharpest(solid, quality_of(mesh), beyond=POINTED)


def is_pointed(solid: Solid, report: QualityReport) -> bool:
    """Whether the worst hexahedron lies at a corner or an edge of the solid that no mesh has a good one at."""
    return _sharpest(solid, report) <= math.sin(GOOD_ENOUGH)


def is_limited(mesh: AnyMesh, solid: Solid) -> bool:
    """Whether the worst hexahedron of a fitted grid lies at a corner or an edge that no grid has a better one at."""
    return worst_of(mesh) >= _SPLIT * _sharpest(solid, quality_of(mesh))


def is_of_placing(options: SweepOptions) -> bool:
    """Whether the user wants to see what becomes of one sweep, poor or not."""
    usual = SweepOptions()
    return any(getattr(options, name) != getattr(usual, name) for name in _OF_PLACING)


def reached_by(mesh: AnyMesh, solid: Solid) -> float:
    """Worst scaled Jacobian; that of its columns upright, if lower, where no sharp corner of the solid is to blame."""
    upright = _limit(mesh, "upright_limit") if _sharpest(solid, quality_of(mesh)) >= GOOD_STACK else 1.0
    return min(worst_of(mesh), upright)


def is_as_good(mesh: AnyMesh, solid: Solid) -> bool:
    """Whether a sweep or columns are as good as cells are likely to be.

    Those have the solid's own sharp corners, too, as where a lever's arm runs out beside its boss. A mesh that is fair
    and no more has cells tried where the part itself allows more and something round lies across the columns, as the
    end of a keyway across a shaft.
    """
    worst = worst_of(mesh)
    sharpest = _sharpest(solid, quality_of(mesh))
    if sharpest < GOOD_STACK:
        return worst >= min(POOR, _EXPLAINED * sharpest)
    if reached_by(mesh, solid) < GOOD_STACK:
        return False
    across = any(sweep.get("round_across", False) for sweep in mesh.info["sweeps"])
    return worst >= FAIR_STACK or not across or _limit(mesh, "limit") < FAIR_STACK


def _limit(mesh: AnyMesh, which: str) -> float:
    """A limit of columns, as :class:`cadsweep.stack.Stack` has it; 1 of other meshes."""
    return min((sweep.get(which, 1.0) for sweep in mesh.info["sweeps"]), default=1.0)


def _sharpest(solid: Solid, report: QualityReport, beyond: float = 0.0) -> float:
    """Sine of the sharpest corner of a face, or angle at an edge, at the worst hexahedron, of those beyond an angle.

    A sharp corner elsewhere does not make that one poor. It is 1 where there is none.
    """
    corners = {
        (angle, solid.edges[e].start if forward else solid.edges[e].end)
        for face in solid.faces
        for loop in face.loops
        for (e, forward), angle in zip(loop.directed, loop.angles, strict=True)
        if beyond <= angle <= math.pi / 2
    }
    edges = [edge for edge in solid.edges if beyond <= edge.dihedral <= math.pi / 2]
    units = solid.edges[0].units
    worst = report.worst[0]
    center = (np.array([worst.center]) - units.offset) / units.scale
    reach = _AT * worst.radius / units.scale
    angles = [a for a, v in corners if np.linalg.norm(solid.vertices[v] - center[0]) <= reach]
    angles += [edge.dihedral for edge in edges if edge.curve.distance(center)[0] <= reach]
    return math.sin(min(angles, default=math.pi / 2))
