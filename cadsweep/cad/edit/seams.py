"""Pieces of one closed face that a cut left side by side in a cell, joined to one face again.

Place in the flow: :mod:`.cutting` hands over every piece of a cell that it has split. Closed faces were divided when
the part was loaded, at places that have nothing to do with where cells part it: the wall of a quarter of a bore may be
two faces, with corners where no other face has any.

Method: OpenCASCADE's ``ShapeUpgrade_UnifySameDomain``, kept away from every edge but the seams, and from shared ones.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from math import pi
from typing import Any, NamedTuple

from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepTools import BRepTools
from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..heal.validate import check_closed, faults
from ..shapes import EDGE, FACE, SOLID, Mass, explore, index_map, listed, mapped, subshapes, volume_and_center
from ..trial import attempted

MOST_TURN = 1.1 * pi
"""Radians around its axis up to which a joined face goes: beyond that it would have to be divided again."""
SAME_VOLUME = 1e-6
"""Share of a piece's volume that joining its faces may change: OpenCASCADE integrates no better."""


class Joined(NamedTuple):
    """A piece with the seams of its round faces gone.

    Attributes
    ----------
    shape : TopoDS_Solid
    labels : Labels
        Of its faces and edges.
    mass : tuple of float and (3,) float64
        Its volume and centroid.
    history : BRepTools_History or None
        What its faces have become; None where they are as they were.
    """

    shape: Any
    labels: Labels
    mass: Mass
    history: Any = None

    def became(self, sub: Any) -> list[Any]:
        """What a face or an edge is now; itself where it is as it was."""
        return [sub] if self.history is None else listed(self.history.Modified(sub)) or [sub]


def without_seams(piece: Any, labels: Labels, mass: Mass, across: Sequence[Hashable]) -> Joined:
    """A piece with the seams of its round faces gone; the piece itself where it has none, or where joining spoils it.

    Parameters
    ----------
    piece : TopoDS_Solid
    labels : Labels
        Of its faces and edges. Faces of one key are pieces of one face.
    mass : tuple of float and (3,) float64
        Its volume and centroid.
    across : sequence of hashable
        By face: what is on its other side. Only faces with the same there are joined, as they are joined there too.
    """
    faces, edges = index_map(piece, FACE), index_map(piece, EDGE)
    beside: dict[int, list[int]] = {}
    for number, face in enumerate(mapped(faces, FACE)):
        for edge in explore(face, EDGE):
            beside.setdefault(edges.FindIndex(edge) - 1, []).append(number)
    shapes = mapped(faces, FACE)
    seams = {
        e
        for e, (a, *b) in beside.items()
        if len(b) == 1 and across[a] == across[b[0]] and _is_seam(shapes[a], shapes[b[0]], a, b[0], labels)
    }
    unchanged = Joined(piece, labels, mass)
    if not seams:
        return unchanged
    tool = ShapeUpgrade_UnifySameDomain(piece, False, True, False)
    for e, edge in enumerate(mapped(edges, EDGE)):
        if e not in seams:
            tool.KeepShape(edge)
    if not attempted(tool.Build, "taking seams out of a piece", on=[piece]):
        return unchanged
    (found,) = subshapes(tool.Shape(), SOLID)
    try:
        check_closed(found)
    except CadError:
        return unchanged
    after = volume_and_center(found)
    if faults(found) or abs(after[0] - mass[0]) > SAME_VOLUME * mass[0]:
        return unchanged
    history = tool.History()
    own = _followed(shapes, labels.faces, index_map(found, FACE), history, FaceLabel())
    lines = _followed(mapped(edges, EDGE), labels.edges, index_map(found, EDGE), history, EdgeLabel())
    return Joined(found, Labels(own, lines), after, history)


def _is_seam(one: Any, other: Any, a: int, b: int, labels: Labels) -> bool:
    """Whether two faces of a piece are neighbours on one cylinder or cone, of one face, and go not too far around."""
    if a == b or not labels.faces[a].key or labels.faces[a].key != labels.faces[b].key:
        return False
    if labels.faces[a].number == labels.faces[b].number:
        return False  # not two faces since it was loaded: a rounding, divided on purpose
    if BRepAdaptor_Surface(one).GetType() not in (GeomAbs_Cylinder, GeomAbs_Cone):
        return False
    if BRepAdaptor_Surface(one).GetType() != BRepAdaptor_Surface(other).GetType():
        return False
    turn = 0.0
    for face in (one, other):
        low, high, _, _ = BRepTools.UVBounds_s(face)
        turn += high - low
    return turn < MOST_TURN


def _followed(old: Any, labels: Any, found: Any, history: Any, empty: Any) -> list[Any]:
    """The labels of what became of old faces (or edges), in the order of a map."""
    out = [empty] * found.Extent()
    for shape, label in zip(old, labels, strict=True):
        for new in listed(history.Modified(shape)) or [shape]:
            number = found.FindIndex(new)
            if number:
                out[number - 1] = label
    return out


__all__ = ["Joined", "without_seams"]
