"""A solid of an assembly that shares nothing with others: by itself, with the outlines of its contacts or without."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ... import cad
from ...brep import Part
from ...errors import CadError, CadSweepError, InputError
from ...intervals.sizes import WANTED_HEXES
from ...options import SweepOptions
from ..candidates import POOR
from ..origin import AnyMesh, worst_of
from ..run import Run
from ..wishes.shared_hints import meant_here

log = logging.getLogger(__name__)

CLOSE = 0.5
"""Distance between the outline of a contact and other edges, in edges of a hexahedron, that takes finer ones."""

_SMOOTH = 1e-6
"""Angle by which an outline within a face may differ from pi."""

_ALONG = np.linspace(0.0, 1.0, 9)
"""Where it is looked how close an outline is to other edges."""

MeshOne = Callable[[Part, SweepOptions, Run], AnyMesh]
"""Meshes a part of one solid by whatever way applies."""


def mesh_separate(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """One solid by itself, with the outlines of its contacts or, where a mesh with these is refused or poor, without.

    Outlines close to other edges, which take very fine quads, come last, but for cuts: a solid is not cut for an
    outline that nothing needs.
    """
    first: CadSweepError | None = None
    made: list[AnyMesh] = []
    without_first = _has_close_outlines(part)
    for decompose in (False, True) if options.decompose else (False,):
        own = replace(options, decompose=decompose)
        for outlined in (not without_first, without_first):
            version = None if not _is_poor(made, run) else part if outlined else _without_outlines(part)
            if version is None:
                continue
            try:
                made.append(mesh_alone(version, own, run, mesh_one))
            except CadSweepError as error:
                if isinstance(error, InputError | CadError) and outlined:
                    raise
                log.info("%s outlines of contacts: %s", "with" if outlined else "without", error)
                first = first or error
    if made:
        return max(made, key=worst_of)
    assert first is not None
    raise first


def _without_outlines(part: Part) -> Part | None:
    """The part without the outlines of its contacts; None where it has none."""
    original = cad.part_apart(part)
    if original is None or len(original.solids[0].faces) == len(part.solids[0].faces):
        return None
    return original


def _has_close_outlines(part: Part) -> bool:
    """Whether an outline that a contact of the one cell of a part has in a face lies close to other edges."""
    (solid,) = part.solids
    close = CLOSE * float(np.cbrt(solid.volume / WANTED_HEXES))
    for edge in solid.edges:
        if sum(solid.faces[f].name in part.contacts for f in edge.faces) != 1 or abs(edge.dihedral - np.pi) > _SMOOTH:
            continue
        points = edge.curve.evaluate(_ALONG)
        ends = {edge.start, edge.end}
        others = (other for other in solid.edges if not ends & {other.start, other.end})
        if any(float(other.curve.distance(points).min()) < close for other in others):
            return True
    return False


def _is_poor(made: Sequence[AnyMesh], run: Run) -> bool:
    """Whether there is no mesh yet, or time for one that is not poor."""
    return not made or (max(map(worst_of, made)) < POOR and not run.is_over())


def mesh_alone(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """One solid by itself, with what is asked of it."""
    name = part.models[0].name
    own = replace(meant_here(part, options), interfaces="shared", only=None, skip=None)
    if options.sizes and name in options.sizes:
        own = replace(own, size=options.sizes[name])
    return mesh_one(part, own, run)


__all__ = ["MeshOne", "mesh_alone", "mesh_separate"]
