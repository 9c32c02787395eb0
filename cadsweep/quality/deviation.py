"""How far the boundary of a sweep lies off the CAD faces, and which way it sags there.

Place in the flow: ``pipeline`` measures a boundary mesh before the inside is placed, and divides finer what is too
coarse.

Method: nodes lie on their faces, so a mesh is off where its quads sag: at the middles of their sides and inside. Plane
faces are left out; how far the chords on their rims are off is asked of the edges (:mod:`.rims`). A chord that cuts a
thin tip off may be near both walls while the tip is far from the chord: where a free-form side turns much along a
chord, what lies between its ends on the face is held against the chord, too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..brep import Surface
from ..mesh import SurfaceMesh
from ..sweep import Sweep
from .metrics import volume_and_area
from .rims import rim_deviations

_TURNS = 0.05
"""Sag of a chord over its length from which on the face may reach farther than that beyond it: an arc of 23 degrees."""
_BETWEEN = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Places between the ends of a chord at which the face is looked at."""
_SINGULAR = 1e-3
"""Length of a partial derivative over its greatest, below which a parameter means nothing."""
_EXACT = ("plane", "cylinder", "cone", "sphere", "torus")
"""Kinds of faces that bulge evenly: they are as far from a chord as the chord is from them."""
_INSIDE = ((0.5, 0.5), (0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8))
"""Places inside a quad of a cap: a bump may be smaller than it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SideDeviation:
    """What a linking side sags, working units.

    Attributes
    ----------
    around, along : float
        Greatest distance of the middles of segments around the sweep, and along it.
    inside : float
        Greatest distance of the middles of quads.
    """

    around: float
    along: float
    inside: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Deviation:
    """How far a boundary mesh is off, working units.

    Attributes
    ----------
    distance : float
        Greatest distance that was measured.
    faces : dict of int to float
        Greatest distance of each curved face.
    sides : dict of int to SideDeviation
        Of each curved linking side, by face.
    rims : dict of int to float
        Of each curved edge at which faces meet at an angle.
    cap_middles : (m, 3) float64
        Middles of the source's quads, where one of its faces or of the target's is curved.
    cap_sags : (m,) float64
        Greatest distance of each, on either cap.
    cap_lengths : (m,) float64
        Mean length of its sides on the source.
    volume, area : float
        Of the mesh over the CAD's, less one.
    """

    distance: float
    faces: dict[int, float]
    sides: dict[int, SideDeviation]
    rims: dict[int, float] = field(default_factory=dict)
    cap_middles: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    cap_sags: FloatArray = field(default_factory=lambda: np.empty(0))
    cap_lengths: FloatArray = field(default_factory=lambda: np.empty(0))
    volume: float = 0.0
    area: float = 0.0


def measure_deviation(
    sweep: Sweep, surfaces: SurfaceMesh, target_points: FloatArray, target_faces: IntArray
) -> Deviation:
    """Measure a boundary mesh against its faces.

    Parameters
    ----------
    sweep : Sweep
    surfaces : SurfaceMesh
    target_points : (n, 3) float64
        The source's nodes on the target cap.
    target_faces : (q,) int64
        Target face of every quad.
    """
    solid, source, rings = sweep.solid, surfaces.source, surfaces.rings
    after = np.concatenate([np.roll(loop, -1) for loop in _loops(source.loops)])
    sides: dict[int, SideDeviation] = {}
    faces: dict[int, float] = {}
    for f in distinct(surfaces.side_faces):
        if solid.faces[f].kind == "plane":
            continue
        surface = solid.faces[f].surface
        layer, column = np.nonzero(surfaces.side_faces == f)
        corners = np.stack(
            [
                rings[layer, column],
                rings[layer, after[column]],
                rings[layer + 1, after[column]],
                rings[layer + 1, column],
            ]
        )
        # All that is asked of a face at once: of hundreds of faces, most of the time would be that of the calls.
        begin, end = (np.concatenate([corners[i] for i in ids]) for ids in ((0, 3, 0, 1), (1, 2, 3, 2)))
        sags = surface.distance(np.concatenate([0.5 * (begin + end), corners.mean(axis=0)]))
        if solid.faces[f].kind not in _EXACT:
            _add_cut_off(surface, begin, end, sags[: len(begin)])
        around, along, inside = (float(part.max()) for part in np.split(sags, [len(sags) * 2 // 5, len(sags) * 4 // 5]))
        sides[int(f)] = SideDeviation(around=around, along=along, inside=inside)
        faces[int(f)] = max(around, along, inside)
    caps = [(source.faces, source.points[source.quads])]
    if not sweep.closed:
        caps.append((target_faces, target_points[source.quads]))
    sags = np.zeros(len(source.quads))
    curved = np.zeros(len(source.quads), dtype=bool)
    for owners, corners in caps if not sweep.closed else ():
        for f in distinct(owners):
            if solid.faces[f].kind == "plane":
                continue
            mine = np.flatnonzero(owners == f)
            off = quad_sags(solid.faces[f].surface, corners[mine])
            sags[mine] = np.maximum(sags[mine], off)
            curved[mine] = True
            faces[int(f)] = max(faces.get(int(f), 0.0), float(off.max()))
    corners = source.points[source.quads[curved]]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
    quads = [
        np.stack([rings[:-1], rings[:-1, after], rings[1:, after], rings[1:]], axis=2).reshape(-1, 4, 3),
        *(() if sweep.closed else (source.points[source.quads][:, ::-1], target_points[source.quads])),
    ]
    every = np.concatenate(quads).reshape(-1, 3)
    volume, area = volume_and_area(every, np.arange(len(every)).reshape(-1, 4))
    rims = rim_deviations(sweep, surfaces, target_points)
    closed_caps = (*sweep.source, *sweep.target) if sweep.closed else ()
    cad_area = sum(face.area for face in solid.faces if face.id not in closed_caps)
    return Deviation(
        distance=max([*faces.values(), *rims.values()], default=0.0),
        faces=faces,
        sides=sides,
        rims=rims,
        cap_middles=corners.mean(axis=1),
        cap_sags=sags[curved],
        cap_lengths=lengths,
        volume=volume / solid.volume - 1.0,
        area=area / cad_area - 1.0,
    )


def _add_cut_off(surface: Surface, begin: FloatArray, end: FloatArray, sags: FloatArray) -> None:
    """Raise the distances (m,) of chords, from (m, 3) to (m, 3), where they cut more off than their middles say."""
    turning = np.flatnonzero(sags > _TURNS * np.linalg.norm(end - begin, axis=1))
    if len(turning):
        sags[turning] = np.maximum(sags[turning], _cut_off(surface, begin[turning], end[turning]))


def _cut_off(surface: Surface, begin: FloatArray, end: FloatArray) -> FloatArray:
    """Greatest distance (m,) from chords of what lies between their ends in the parameters of the face."""
    one, other = surface.project(begin), surface.project(end)
    for axis, period in enumerate(surface.periods):
        if period is not None:
            other[:, axis] -= period * np.round((other[:, axis] - one[:, axis]) / period)
    sizes = [np.linalg.norm(by, axis=1) for at in (one, other) for by in surface.derivatives(at)]
    sound = np.all([size > _SINGULAR * size.max() for size in sizes], axis=0)
    steps = end - begin
    squares = np.einsum("md,md->m", steps, steps)
    far = np.zeros(len(begin))
    for share in _BETWEEN:
        off = surface.evaluate(one + share * (other - one)) - begin
        along = np.clip(np.einsum("md,md->m", off, steps) / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
        far = np.maximum(far, np.linalg.norm(off - along[:, None] * steps, axis=1))
    return np.where(sound, far, 0.0)


def _loops(loops: tuple[IntArray, ...]) -> list[IntArray]:
    """Places of each loop's nodes in the ring."""
    ends = np.cumsum([len(loop) for loop in loops])
    return list(np.split(np.arange(ends[-1]), ends[:-1]))


def quad_sags(surface: Surface, corners: FloatArray) -> FloatArray:
    """Greatest distance (m,) of quads (m, 4, 3) from their surface."""
    places = [
        (1 - u) * (1 - v) * corners[:, 0]
        + u * (1 - v) * corners[:, 1]
        + u * v * corners[:, 2]
        + (1 - u) * v * corners[:, 3]
        for u, v in _INSIDE
    ]
    places += [(corners[:, j] + corners[:, (j + 1) % 4]) / 2 for j in range(4)]
    distances: FloatArray = surface.distance(np.concatenate(places)).reshape(len(places), len(corners)).max(axis=0)
    return distances
