"""Faces of a prism over the cells of a plane: sides over its rim, bottoms and tops.

Place in the flow: fourth step of :mod:`.prism`.
"""

from __future__ import annotations

import numpy as np

from ...brep import Face, Loop
from ...errors import CadError
from ..geometry.edge_on_face import EdgeOnFace
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure, measure_face
from ..geometry.parametric import Line
from ..geometry.surfaces import Cone, Frame, Plane
from .flat import is_exact, measure_flat
from .prism_numbers import Numbers
from .prism_plane import PlaneCells
from .upright import known_as, limits_of, renumbered, surface_over, turned_round, upright_face

_PANELS, _GAUSS = 8, np.polynomial.legendre.leggauss(8)
_AT = ((np.arange(_PANELS)[:, None] + (_GAUSS[0] + 1.0) / 2.0) / _PANELS).ravel()
_WEIGHTS = np.tile(_GAUSS[1] / (2.0 * _PANELS), _PANELS)
"""Nodes and weights on 0 to 1 for the middle of a line."""
_NO_LIMITS = np.array([[-np.inf, -np.inf], [np.inf, np.inf]])


def faces_of(cells: PlaneCells, numbers: Numbers) -> tuple[Face, ...]:
    """All faces of the prism, by id.

    Raises
    ------
    CadError
        A cell is turned over.
    """
    return (*_sides(cells, numbers), *_caps(cells, numbers))


def _sides(cells: PlaneCells, numbers: Numbers) -> list[Face]:
    found = []
    facing = cells.facing()
    for j in range(cells.n_rim):
        curve, (start, end) = cells.curves[j], cells.shared.ends[j].tolist()
        geometry, hand = surface_over(curve.geometry, cells.up)
        first, last, top = curve.first, curve.last, hand * cells.height
        lower, upper, left, right = numbers.lower[j], numbers.upper[j], numbers.rails[start], numbers.rails[end]
        across, upward = np.array([1.0, 0.0]), np.array([0.0, hand])
        on_side = {
            left: (cells.rail_curve(start), Line(origin=np.array([first, 0.0]), direction=upward)),
            right: (cells.rail_curve(end), Line(origin=np.array([last, 0.0]), direction=upward)),
            lower: (curve, Line(origin=np.zeros(2), direction=across)),
            upper: (cells.lifted[j], Line(origin=np.array([0.0, top]), direction=across)),
        }
        sense = cells.sense(j)
        run = (
            ((left, False), (lower, True), (right, True), (upper, False))
            if sense > 0
            else ((left, True), (upper, True), (right, False), (lower, False))
        )
        area = float(cells.shared.samples.lengths[j]) * cells.height
        middle = _WEIGHTS @ curve.evaluate(_AT)
        surface = FaceSurface(
            geometry=geometry,
            outward=hand * sense,
            box=np.array([[first, min(0.0, top)], [last, max(0.0, top)]]),
            limits=limits_of(geometry, first, last),
            curves={e: EdgeOnFace(curve=own, read=known_as(flat)) for e, (own, flat) in on_side.items()},
        )
        center = middle + cells.along / 2.0
        kind = {Plane: "plane", Cone: "cylinder"}.get(type(geometry), "extrusion")
        loop = Loop(edges=tuple(e for e, _ in run), forward=tuple(way for _, way in run), angles=(np.pi / 2,) * 4)
        # Half way along an arc, as along a line, is what is nearest to the middle.
        normal = surface.normals(surface.project(center[None]))[0] if kind == "extrusion" else facing[j]
        over = cells.overhead
        found.append(upright_face(j, kind, area, center, normal, (loop,), surface, over.units, over.walls[j]))
    return found


def _caps(cells: PlaneCells, numbers: Numbers) -> list[Face]:
    """Bottom and top of every cell."""
    frame = cells.plane.frame
    top_plane = Plane(frame=Frame(origin=frame.origin + cells.along, x=frame.x, y=frame.y, z=frame.z))
    hand = 1.0 if float(frame.z @ cells.up) * frame.handedness > 0 else -1.0
    found = []
    for c, (own, measure) in enumerate(zip(cells.loops, _measured(cells, hand), strict=True)):
        box = cells.box(own)
        for top, f in ((False, numbers.bottoms[c]), (True, numbers.tops[c])):
            ids = numbers.upper if top else numbers.lower
            loops = tuple(renumbered(loop, ids) if top else renumbered(turned_round(loop), ids) for loop in own)
            surface = FaceSurface(
                geometry=top_plane if top else cells.plane,
                outward=hand if top else -hand,
                box=box,
                limits=_NO_LIMITS,
                curves={
                    ids[j]: EdgeOnFace(curve=cells.lifted[j] if top else cells.curves[j], read=cells.dropped(j))
                    for loop in own
                    for j in loop.edges
                },
            )
            center = measure.center + (cells.along if top else 0.0)
            up = cells.up if top else -cells.up
            over = cells.overhead
            found.append(upright_face(f, "plane", measure.area, center, up, loops, surface, over.units, over.caps[c]))
    return found


def _measured(cells: PlaneCells, hand: float) -> list[Measure]:
    """Area and centroid of every cell."""
    exact = [is_exact(curve) for curve in cells.curves]
    plain = [c for c, own in enumerate(cells.loops) if all(exact[j] for loop in own for j in loop.edges)]
    normals = np.broadcast_to(cells.up, (len(plain), 3))
    flat = measure_flat([cells.loops[c] for c in plain], normals, cells.curves, cells.shared.samples)
    found = dict(zip(plain, flat, strict=True))
    measures = []
    for c, own in enumerate(cells.loops):
        measure = found.get(c)
        if c not in found:
            surface = FaceSurface(
                geometry=cells.plane,
                outward=hand,
                box=cells.box(own),
                limits=_NO_LIMITS,
                curves={
                    j: EdgeOnFace(curve=cells.curves[j], read=cells.dropped(j)) for loop in own for j in loop.edges
                },
            )
            measure = measure_face(surface, own)
        if measure is None:
            caps = " under ".join(face.label() for face in cells.overhead.caps[c][:2])
            raise CadError(f"a cell of the arrangement is turned over{f', of {caps}' if caps else ''}")
        measures.append(measure)
    return measures


__all__ = ["faces_of"]
