"""Tips of faces bridged: where two edges of a face meet at an angle of nearly nothing, it ends in a short edge.

Place in the flow: called by the pipeline for solids that hang together, before they are meshed.

A chamfer that runs out, a cylinder tangent to a plane, a circle that touches the edge of its face: what lies between
is a face whose angle tends to zero, and so do those of quads in it. Where its edges are a given length apart, a short
edge ab joins them; what lies beyond goes to the neighbour across the flatter of the two::

    V _______________________          V _____b_________________
      ``--..__     face                       |     face
              ``--..__           ->           a`--..__
         neighbour    ``                 neighbour    ``

The mesh is off the model there by that length at most, and says so.

Method: OpenCASCADE's splitter divides the face along the short edge; the neighbour then gets a loop around the tip, and
its new edges a tolerance of their distance to its surface.

What solids share stays shared. A face in contact may get a tip, as that of a plate gets the chamfer's of the nut on it:
the face around the contact then ends where the contact does, and what was open between the two solids is closed.

Not handled: faces that are narrow all along, tips on the seam of a closed face, tips of faces in contact.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_MakeEdge
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.GCE2d import GCE2d_MakeSegment
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.Precision import Precision
from OCP.ShapeFix import ShapeFix_Edge, ShapeFix_Wire
from OCP.TopoDS import TopoDS_Wire

from ...arrays import FloatArray
from ...brep import GainedTip, Part, Solid, Surface
from ...errors import CadError
from ..heal.validate import faults
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    VERTEX,
    SolidShape,
    children,
    compound,
    in_turn,
    index_map,
    shapes_of,
    subshapes,
    typed,
)
from .notes import TIPS_NOTE
from .splitting import faces_in_contact, in_order, read_anew, split
from .tips import Tip, find_tips

log = logging.getLogger(__name__)

_WIDEST = 2.0
"""How far the neighbour of a tip may be off its new edges, over the length: less, as it is no steeper than that."""
_MOST_APART = 16
"""Tips up to which each is tried by itself where all at once cannot be had; one takes tenths of a second."""
_SAMPLES = 65
"""Places along an edge at which its distance to a surface is looked at."""


Tips = dict[int, list[Tip]]
"""Tips by cell of a part."""


def bridge_tips(part: Part, length: float) -> Part:
    """Bridge the tips of a part.

    Parameters
    ----------
    part : Part
    length : float
        How far the edges of a tip are apart where it is bridged, model units.

    Returns
    -------
    Part
        The same solids, their faces under the ids that they had; the part itself where it has no tips, or OpenCASCADE
        can bridge none.
    """
    if not all(isinstance(solid.kernel, SolidShape) for solid in part.solids):
        return part
    tips: Tips = {}
    for cell, (solid, kept) in enumerate(zip(part.solids, faces_in_contact(part), strict=True)):
        found = find_tips(solid, length / part.scale, kept)
        if found:
            tips[cell] = found
    bridged = _bridged_if_sound(part, tips, length / part.scale) if tips else None
    if tips and bridged is None:
        tips = _sound_ones(part, tips, length / part.scale)
        bridged = _bridged_if_sound(part, tips, length / part.scale) if tips else None
    if bridged is None:
        return part
    faces = [part.solids[cell].faces[tip.face].label() for cell, own in tips.items() for tip in own]
    note = (
        f"{TIPS_NOTE}: {len(faces)} sharp corners end in edges of {length:.3g}, by which the mesh may be off the CAD "
        f"there, as on {', '.join(dict.fromkeys(faces[:2]))}"
    )
    return replace(bridged, notes=(*part.notes, note))


def _sound_ones(part: Part, tips: Tips, length: float) -> Tips:
    """The tips of each solid that can be bridged by themselves; of one solid each tip that can, unless it has many."""
    if len(tips) > 1:
        return {cell: own for cell, own in tips.items() if _bridged_if_sound(part, {cell: own}, length) is not None}
    ((cell, found),) = tips.items()
    if len(found) > _MOST_APART:
        return {}
    own = [tip for tip in found if _bridged_if_sound(part, {cell: [tip]}, length) is not None]
    return {cell: own} if own else {}


def _bridged_if_sound(part: Part, tips: Tips, length: float) -> Part | None:
    """The part with tips bridged; None where OpenCASCADE cannot do that."""
    try:
        return _bridged(part, tips, length)
    except (CadError, ValueError, RuntimeError) as error:
        log.info("tips of %d solids cannot be bridged: %s", len(tips), error)
        return None


def _bridged(part: Part, tips: Tips, length: float) -> Part:
    """The part with tips divided off and given to their neighbours.

    Raises
    ------
    CadError
        OpenCASCADE divides more or less than that, or a solid is not sound.
    """
    holders = _copied([shapes_of(solid) for solid in part.solids])
    ends = {part.solids[cell].edge_keys[edge] for cell, own in tips.items() for tip in own for edge, _ in tip.ends}
    cells = [cell for cell, solid in enumerate(part.solids) if not ends.isdisjoint(solid.edge_keys.tolist())]
    cuts = [_short_edge(part.solids[cell], holders[cell], tip) for cell, own in tips.items() for tip in own]
    found = split([holders[cell] for cell in cells], cuts)
    faces = {cell: pieces for cell, (_, pieces, _) in zip(cells, found, strict=True)}
    became = {cell: traced for cell, (_, _, traced) in zip(cells, found, strict=True)}
    given = [at for cell, own in tips.items() for tip in own for at in _give(part, faces, cell, tip)]
    if any(len(pieces) != 1 for own in faces.values() for pieces in own):
        raise CadError("faces were divided elsewhere, too")
    shapes = [in_order(faces[cell]) if cell in faces else holder.shape for cell, holder in enumerate(holders)]
    for cell in cells:
        damage = faults(shapes[cell])
        if damage:
            raise CadError(damage[0])
    for cell, traced in became.items():
        traced.faces = faces[cell]
    made = {cell: (shapes[cell], traced) for cell, traced in became.items()}
    for cell, face, tip in given:
        part = _with_tip(part, cell, face, tip)
    read = read_anew(part, holders, made, closed=_WIDEST * length)
    pairs = enumerate(zip(part.solids, read.solids, strict=True))
    return replace(part, solids=tuple(_as_measured(old, new) if cell in made else new for cell, (old, new) in pairs))


def _give(part: Part, faces: dict[int, list[list[Any]]], cell: int, tip: Tip) -> list[tuple[int, int, GainedTip]]:
    """Give a tip that is divided off to its neighbour: the cells and faces that end elsewhere by it.

    Raises
    ------
    CadError
        It is no single piece, or something else than two faces and a contact ends at it.
    """
    solid = part.solids[cell]
    off = [piece for piece in faces[cell][tip.face] if _touches(piece, solid.vertices[tip.corner])]
    if len(off) != 1 or len(faces[cell][tip.face]) == 1:
        raise CadError(f"the tip of {solid.faces[tip.face].label()} cannot be divided off")
    faces[cell][tip.face].remove(off[0])
    beside = [j for j, piece in enumerate(faces[cell][tip.neighbour]) if _shared(piece, off[0])]
    if len(beside) != 1:
        raise CadError(f"the tip of {solid.faces[tip.face].label()} has no one neighbour")
    border = compound(_shared(faces[cell][tip.neighbour][beside[0]], off[0]))
    grown = _grown(faces[cell][tip.neighbour][beside[0]], off[0], border, solid.faces[tip.neighbour].surface)
    faces[cell][tip.neighbour][beside[0]] = grown
    to = [(cell, tip.neighbour)]
    key = solid.face_keys[tip.neighbour]
    for other in faces.keys() - {cell}:
        around = [f for f, pieces in enumerate(faces[other]) if any(_shared(piece, border) for piece in pieces)]
        if not around:
            continue
        contact = [f for f in around if part.solids[other].face_keys[f] == key]
        rest = [f for f in around if f not in contact]
        if len(contact) != 1 or len(rest) != 1 or len(faces[other][rest[0]]) != 1 or len(faces[other][contact[0]]) != 1:
            raise CadError(f"the tip of {solid.faces[tip.face].label()} ends at another solid")
        ((open_,), at) = faces[other][rest[0]], part.solids[other].faces[rest[0]].surface
        faces[other][rest[0]] = [_grown(open_, off[0], border, at)]
        faces[other][contact[0]] = [grown.Reversed()]
        to += [(other, contact[0]), (other, rest[0])]
    corner = solid.vertices[tip.corner]
    ends = np.concatenate([solid.edges[e].curve.evaluate(np.array([f])) for e, f in tip.ends])
    radius = 1.01 * float(np.linalg.norm(ends - corner, axis=1).max())
    gained = GainedTip(solid.faces[tip.face].surface, corner, radius)
    return [(other, face, gained) for other, face in to]


def _with_tip(part: Part, cell: int, face: int, tip: GainedTip) -> Part:
    """A part one of whose faces got a tip."""
    solids = list(part.solids)
    faces = list(solids[cell].faces)
    faces[face] = replace(faces[face], tips=(*faces[face].tips, tip))
    solids[cell] = replace(solids[cell], faces=tuple(faces))
    return replace(part, solids=tuple(solids))


def _as_measured(solid: Solid, read: Solid) -> Solid:
    """A solid with the figures of another: what its edges are off the tips' neighbours says nothing of the model."""
    widest = max((edge.gap for edge in solid.edges), default=0.0)
    return replace(
        read,
        edges=tuple(replace(edge, gap=min(edge.gap, widest)) for edge in read.edges),
        tolerance=solid.tolerance,
        volume=solid.volume,
    )


def _copied(holders: Sequence[SolidShape]) -> list[SolidShape]:
    """The same shapes once more, shared where they were: what is mended on some of them stays theirs."""
    copy = BRepBuilderAPI_Copy(compound([holder.shape for holder in holders]))

    def own(shapes: Sequence[Any], kind: Any) -> list[Any]:
        return [typed(copy.ModifiedShape(shape), kind) for shape in shapes]

    return [
        SolidShape(
            shape=typed(copy.ModifiedShape(holder.shape), SOLID),
            faces=own(holder.faces, FACE),
            edges=own(holder.edges, EDGE),
            vertices=own(holder.vertices, VERTEX),
        )
        for holder in holders
    ]


def _short_edge(solid: Solid, holder: SolidShape, tip: Tip) -> Any:
    """An edge across the face of a tip, straight in its parameters."""
    ends = np.concatenate([solid.edges[e].curve.evaluate(np.array([f])) for e, f in tip.ends])
    first, last = (gp_Pnt2d(*uv) for uv in solid.faces[tip.face].surface.project(ends).tolist())
    surface = BRep_Tool.Surface_s(holder.faces[tip.face])
    edge = BRepBuilderAPI_MakeEdge(GCE2d_MakeSegment(first, last).Value(), surface).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return edge


def _touches(piece: Any, corner: FloatArray) -> bool:
    """Whether a face has a vertex at a place."""
    places = [(BRep_Tool.Pnt_s(vertex), BRep_Tool.Tolerance_s(vertex)) for vertex in subshapes(piece, VERTEX)]
    return any(place.Distance(gp_Pnt(*corner.tolist())) <= tolerance for place, tolerance in places)


def _shared(piece: Any, other: Any) -> list[Any]:
    """The edges that two faces share."""
    known = index_map(other, EDGE)
    return [edge for edge in subshapes(piece, EDGE) if known.Contains(edge)]


def _grown(receiver: Any, off: Any, border: Any, surface: Surface) -> Any:
    """A face that ended at the border of a tip, and ends at the tip's other edges now.

    Raises
    ------
    CadError
        The border is no single chain of edges.
    """
    shared = index_map(border, EDGE)
    builder, face = BRep_Builder(), typed(receiver.EmptyCopied(), FACE)
    (rim,) = children(off)
    around = _from_shared([*in_turn(rim, off)], shared)
    for old in children(receiver):
        edges = [*in_turn(old, receiver)]
        if not any(shared.Contains(edge) for edge in edges):
            builder.Add(face, old)
            continue
        for edge in around:
            _lay(edge, face, surface)
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for edge in [*_from_shared(edges, shared), *around]:
            builder.Add(wire, edge)
        wire.Closed(True)
        builder.Add(face, wire)
        if not BRepCheck_Analyzer(face).IsValid():  # a new edge may lie a period off the others
            ShapeFix_Wire(wire, face, Precision.Confusion_s()).FixShifted()
    return face


def _from_shared(edges: Sequence[Any], shared: Any) -> list[Any]:
    """The edges of a loop that are not shared, from the one after those that are.

    Raises
    ------
    CadError
        They are no single chain.
    """
    inside = [shared.Contains(edge) for edge in edges]
    firsts = [j for j in range(len(edges)) if inside[j - 1] and not inside[j]]
    if len(firsts) != 1:
        raise CadError("a tip and its neighbour share no single chain of edges")
    turned = [*edges[firsts[0] :], *edges[: firsts[0]]]
    return [edge for edge in turned if not shared.Contains(edge)]


def _lay(edge: Any, face: Any, surface: Surface) -> None:
    """Give an edge a place on a surface that it is off by some distance, which becomes its tolerance."""
    curve = BRepAdaptor_Curve(edge)
    places = [curve.Value(t) for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), _SAMPLES)]
    off = float(np.max(surface.distance(np.array([place.Coord() for place in places]))))
    builder = BRep_Builder()
    builder.UpdateEdge(edge, max(1.1 * off, BRep_Tool.Tolerance_s(edge)))
    for vertex in subshapes(edge, VERTEX):
        builder.UpdateVertex(vertex, BRep_Tool.Tolerance_s(edge))
    ShapeFix_Edge().FixAddPCurve(edge, face, False, BRep_Tool.Tolerance_s(edge))


__all__ = ["bridge_tips"]
