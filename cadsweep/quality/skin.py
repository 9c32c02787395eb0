"""Checks of the surface of a mesh: by itself, part by part, and against the CAD model.

Place in the flow: :func:`cadsweep.quality.check_mesh` finds the surface of a mesh in memory from its hexahedra, a
mesh that is never in memory as a whole knows it from its blocks; both have it checked here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..arrays import FloatArray, IntArray, distinct, limits
from ..contacts import separate_contacts
from . import conformity
from .boundary import place
from .cadcheck import cad_problems
from .metrics import quad_areas
from .overlap import BoundaryCrossing, crossing_problems, describe_crossings, find_crossings, nesting_problems
from .report import CadReference
from .several import PartSurface, crossings_apart

COINCIDENT = 1e-10
"""Nodes nearer than this times the mesh's diagonal are the same point."""


@dataclass(kw_only=True, eq=False)
class SurfaceFindings:
    """What the checks of a boundary found.

    Attributes
    ----------
    areas : dict of str to float
    euler : int or None
    problems : list of str
    crossings : tuple of BoundaryCrossing
    overlaps : list of str
        Those of the problems that say where hexahedra overlap.
    """

    areas: dict[str, float] = field(default_factory=dict)
    euler: int | None = None
    problems: list[str] = field(default_factory=list)
    crossings: tuple[BoundaryCrossing, ...] = ()
    overlaps: list[str] = field(default_factory=list)


def check_surface(
    points: FloatArray,
    quads: IntArray,
    boundaries: Mapping[str, IntArray],
    *,
    cad: CadReference | None = None,
    volume: Callable[[], float] | None = None,
    overlap: bool = True,
    numbers: IntArray | None = None,
) -> SurfaceFindings:
    """Check a boundary surface by itself and against the CAD model.

    Parameters
    ----------
    points : (n, 3) float64
    quads : (b, 4) int64
        The whole boundary, outward.
    boundaries : mapping of name to (q, 4 or more) int64
        Its named pieces.
    cad : CadReference or None
    volume : callable or None
        Says the volume of the mesh, to be held against ``cad.volume``; asked last, since it may have to be waited for.
    overlap : bool
        Look for crossing and nested pieces; False for a part of a surface that is looked at as a whole.
    numbers : (n,) int64 or None
        What messages call the points; None: by their places in `points`.
    """
    sound = {
        name: own.astype(np.int64, copy=False)
        for name, own in ((name, np.asarray(own)) for name, own in boundaries.items())
        if own.ndim == 2 and own.shape[1] >= 4 and (not len(own) or (np.min(own) >= 0 and np.max(own) < len(points)))
    }
    # With its own points alone: there are many more inside, or in the other parts.
    own_nodes = distinct(np.concatenate([quads.ravel(), *(own.ravel() for own in sound.values())]))
    number = own_nodes if numbers is None else numbers[own_nodes]
    place_of = np.empty(len(points), dtype=np.int64)
    place_of[own_nodes] = np.arange(len(own_nodes))
    points, quads = points.take(own_nodes, axis=0), place_of.take(quads)
    named = {name: place_of.take(own) for name, own in sound.items()}
    usable = {name: own[:, :4] for name, own in named.items()}
    found = SurfaceFindings()
    shape = conformity.surface_shape(quads)
    found.euler = shape.euler
    if len(shape.open_edges):
        a, b = shape.open_edges[0].tolist()
        found.problems.append(
            f"the boundary is not a closed 2-manifold: {len(shape.open_edges)} edges do not have two quads, "
            f"the first is between nodes {number[a]} and {number[b]} at {place(points[a])}"
        )
    if len(shape.pinched_nodes):
        a = int(shape.pinched_nodes[0])
        found.problems.append(
            f"the boundary is not a 2-manifold: its sheets touch at {len(shape.pinched_nodes)} nodes, "
            f"the first is node {number[a]} at {place(points[a])}"
        )
    nodes = distinct(quads)
    corners = points.take(nodes, axis=0)
    finite = np.isfinite(corners)
    whole = bool(finite.all())
    measured = corners if whole else corners[finite.all(axis=1)]
    size = float(np.linalg.norm(np.subtract(*limits(measured)))) if len(measured) else 0.0
    pairs = conformity.coincident_pairs(corners, COINCIDENT * size)
    if pairs:
        a, b = (int(nodes[i]) for i in pairs[0])
        found.problems.append(
            f"{len(pairs)} pairs of boundary nodes coincide, "
            f"the first are {number[a]} and {number[b]} at {place(points[a])}"
        )
    found.areas = {name: float(np.sum(quad_areas(points, q))) for name, q in usable.items()}
    if overlap:
        full = _with_middles(quads, named)
        crossing, places = find_crossings(points, full)
        found.crossings = describe_crossings(points, full, usable, crossing, places)
        found.overlaps = crossing_problems(found.crossings)
        if not found.crossings and not len(shape.open_edges) and whole:
            found.overlaps = nesting_problems(points, quads)
        found.problems += found.overlaps
    if cad is not None:
        found.problems += cad_problems(
            points, named, found.areas, euler=found.euler, volume=volume, size=size, cad=cad, numbers=number
        )
    return found


def _with_middles(quads: IntArray, boundaries: Mapping[str, IntArray]) -> IntArray:
    """The boundary's quads with their middle nodes, where a mesh of order 2 names them all; else as they are."""
    widths = {np.asarray(q).shape[1:] for q in boundaries.values() if len(q)}
    if widths not in ({(8,)}, {(9,)}):
        return quads
    stacked = np.concatenate([np.asarray(q) for q in boundaries.values() if len(q)])
    _, first = np.unique(np.sort(stacked[:, :4], axis=1), axis=0, return_index=True)
    return stacked[np.sort(first)] if len(first) == len(quads) else quads


@dataclass(frozen=True, kw_only=True, eq=False)
class Skin:
    """The surface of a mesh, and what of it belongs to which part.

    Attributes
    ----------
    points : (n, 3) float64
    quads : (q, 4) int64
        All that have one hexahedron, outward.
    boundaries : mapping of str to (p, 4 or more) int64
    interfaces : collection of str
        Names of what is between parts.
    parts : collection of str
    surfaces : callable
        Makes the surface of every part, those between parts included; none where parts overlap.
    between : callable
        Says what is wrong with the interfaces.
    numbers : (n,) int64 or None
        What messages call the points; None: by their places in `points`.
    """

    points: FloatArray
    quads: IntArray
    boundaries: Mapping[str, IntArray]
    interfaces: Collection[str]
    parts: Collection[str]
    surfaces: Callable[[], Sequence[PartSurface]]
    between: Callable[[], list[str]]
    numbers: IntArray | None = None


def of_whole(
    cad: CadReference | Mapping[str, CadReference] | None, parts: Collection[str], *, every: bool
) -> CadReference | Mapping[str, CadReference] | None:
    """What the CAD model says of a mesh of one part as what it says of the whole, whose surface is looked at once.

    Parameters
    ----------
    cad : CadReference, mapping of part name to CadReference, or None
    parts : collection of str
    every : bool
        Whether all hexahedra belong to the only part, each once.
    """
    if isinstance(cad, Mapping) and every and len(parts) == 1 and set(cad) == set(parts):
        return cad[next(iter(parts))]
    return cad


def check_skin(
    skin: Skin, cad: CadReference | Mapping[str, CadReference] | None, *, volume: Callable[[], float]
) -> SurfaceFindings:
    """Check the surface of a mesh; of several parts each by itself, since these may touch along an edge.

    Parameters
    ----------
    cad : CadReference, mapping of part name to CadReference, or None
    volume : callable
        Says the sum of the volumes of the hexahedra.
    """
    points, quads, numbers = skin.points, skin.quads, skin.numbers
    if not isinstance(cad, Mapping):
        whole = check_surface(points, quads, skin.boundaries, cad=cad, volume=volume, numbers=numbers)
        if len(skin.parts) < 2 or not whole.problems:
            whole.problems += skin.between()
            return whole
    contacts = separate_contacts(skin.boundaries, skin.parts)
    surfaces = skin.surfaces()
    apart = bool(contacts and surfaces)
    found = check_surface(points, quads, skin.boundaries, volume=volume, overlap=not apart, numbers=numbers)
    if not surfaces:
        return found
    if contacts:
        found.crossings = crossings_apart(points, surfaces, skin.boundaries, contacts)
        found.overlaps = crossing_problems(found.crossings)
    # What is wrong with the boundary of all parts together counts only where it is wrong with a part's own.
    found.problems = [*found.overlaps, *skin.between()]
    for own in surfaces:
        reference = cad.get(own.name) if isinstance(cad, Mapping) else None
        alone = check_surface(
            points,
            own.quads,
            own.named,
            cad=reference,
            volume=partial(float, own.volume),
            overlap=bool(contacts),
            numbers=numbers,
        )
        found.problems += [f"part '{own.name}': {problem}" for problem in alone.problems]
        found.areas |= {name: alone.areas[name] for name in own.named if name not in skin.boundaries}
    if isinstance(cad, Mapping):
        found.problems += [f"part '{name}' has no hexahedra" for name in cad if name not in skin.parts]
    return found
