"""A cell parted by a cutter: pieces, names kept, and the whole part imprinted again.

Place in the flow: the step of the search for cuts on solids of any kind.

Method: OpenCASCADE's splitter, whose word is not taken for it: the volume must be kept, every piece closed and valid,
no piece a sliver and no edge shorter than the model can bear. Neighbours get the pieces of the faces that they share.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from OCP.BOPAlgo import BOPAlgo_Splitter
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Plane
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopTools import TopTools_IndexedMapOfShape

from ...brep import Part, Solid
from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels, numbered_labels_of
from ..heal.validate import check_closed, faults
from ..imprinting.joining import imprint, reach_of, widest_closed
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    Mass,
    SolidShape,
    explore,
    fine_volume,
    index_map,
    listed,
    shapes_of,
    subshapes,
    volume_and_center,
    volume_from_origin,
)
from ..trial import attempted
from .grafting import graft
from .seams import Joined, without_seams

logger = logging.getLogger(__name__)

KEPT = 1e-9
"""Share of the volume that a split of a planar cell may change: rounding alone."""
INTEGRATED = 1e-6
"""The same where faces are curved: OpenCASCADE's integrals differ by as much."""
ROUGHLY = 1e-4
"""Share by which its quick integrals differ where a face has holes in it: these are asked for again, finer."""
THINNEST = 1e-6
"""Volume of a piece, as a share of the cell's, below which it is a sliver."""
ON_CUT = -1
"""Number of a face that is on a cut."""
_SECONDS = 5.0
"""How long OpenCASCADE may take for one cut of the many that are looked at; most take 0.02 s."""
_TOUCHING = 0.999
"""Share of the area in which solids touch that must be left: OpenCASCADE integrates no better."""
SHORTEST = 1e-3
"""Length of a new edge, as a share of the part's size, below which a cut is refused."""


def cut_cell(part: Part, cell: int, tools: Sequence[Any], others: Sequence[int] = ()) -> Part | None:
    """Part one cell; None where the tools do not divide it, or not well.

    Parameters
    ----------
    part : Part
    cell : int
    tools : sequence of TopoDS_Face
    others : sequence of int
        Cells that are parted with it where the tools divide them well.

    Returns
    -------
    Part or None
        The pieces stand where the cell stood; owners and names are kept, faces of the cut have none.
    """
    parted = split_cell(part, cell, tools, others)
    return None if parted is None else parted.imprinted()


def split_cell(part: Part, cell: int, tools: Sequence[Any], others: Sequence[int] = ()) -> Parted | None:
    """Part one cell as :func:`cut_cell` does, the rest of the part as it was still."""
    alone = _split(part, [cell], tools)
    if alone is None:
        return None
    along = [other for other in others if other != cell and _split(part, [other], tools) is not None]
    return (_split(part, [cell, *along], tools) if along else None) or alone


@dataclass(frozen=True, kw_only=True, eq=False)
class Parted:
    """Cells of a part in pieces, before the faces of their neighbours are divided as theirs.

    Attributes
    ----------
    part : Part
    pieces : dict of int to sequence of Joined
        By cell.
    splitters : splitters
        That parted them, all together.
    """

    part: Part
    pieces: Mapping[int, Sequence[Joined]]
    splitters: _Splitters

    @property
    def key(self) -> tuple[tuple[float, ...], ...]:
        """Equal for two parts with the same cells, however they were cut and in whatever order."""
        size = max(solid.size for solid in self.part.solids)
        masses: list[Mass] = []
        for j, solid in enumerate(self.part.solids):
            masses += [piece.mass for piece in self.pieces[j]] if j in self.pieces else [shapes_of(solid).mass]
        return tuple(sorted((round(v / size**3, 9), *(round(float(c) / size, 6) for c in at)) for v, at in masses))

    def imprinted(self) -> Part | None:
        """The part with the pieces in it; None where OpenCASCADE fails at it."""
        before = contact_area(self.part)
        for make in (self.grafted, self.fused):
            try:
                found = make()
            except CadError as error:
                logger.info("a cut of cells %s, %s: %s", list(self.pieces), make.__name__, error)
                continue
            if contact_area(found) >= _TOUCHING * before:
                return found
            logger.info("a cut of cells %s, %s, loses contact between solids", list(self.pieces), make.__name__)
        return None

    def grafted(self) -> Part:
        """The part with the pieces in it, all other cells as they were but for faces that they share with these."""
        size = max(solid.size for solid in self.part.solids)
        pieces = {cell: [(piece.shape, piece.labels) for piece in own] for cell, own in self.pieces.items()}
        return graft(self.part, pieces, self._image, closed=widest_closed(reach_of(size, self.part.touch)))

    def fused(self) -> Part:
        """The part with the pieces in it, by a general fuse of all cells."""
        part, shapes, labels, owners = self.part, list[Any](), list[Labels](), list[int]()
        for j, solid in enumerate(part.solids):
            whole = Joined(shapes_of(solid).shape, numbered_labels_of(solid), shapes_of(solid).mass)
            own = self.pieces.get(j, [whole])
            shapes += [piece.shape for piece in own]
            labels += [piece.labels for piece in own]
            owners += [part.owners[j]] * len(own)
        found = imprint(
            shapes,
            labels=labels,
            models=part.models,
            owners=owners,
            units=part.solids[0].units,
            name=part.name,
            notes=part.notes,
            names=part.names,
            closed=max(solid.closed for solid in part.solids),
        )
        return replace(found, touch=part.touch)

    def _image(self, sub: Any) -> list[Any]:
        """What a face, an edge or a vertex of a cell has become; empty where it is as it was."""
        found = self.splitters.became(sub)
        for piece in itertools.chain.from_iterable(self.pieces.values()):
            found = [new for one in found for new in piece.became(one)]
        return [] if len(found) == 1 and found[0].IsSame(sub) else found


def contact_area(part: Part) -> float:
    """Area of the faces that solids of the model share."""
    if len(part.models) == 1:
        return 0.0
    owner_of: dict[int, int] = {}
    area = 0.0
    for solid, owner in zip(part.solids, part.owners, strict=True):
        for face, key in zip(solid.faces, solid.face_keys.tolist(), strict=True):
            area += face.area if owner_of.setdefault(key, owner) != owner else 0.0
    return area


def _split(part: Part, cells: Sequence[int], tools: Sequence[Any]) -> Parted | None:
    """The pieces of some cells; None where one of them is not parted, or not well.

    Tools of two kinds at once are more than OpenCASCADE's splitter can always do: where a plane, a cylinder and the
    solid's own faces meet in one edge it may lose a piece. Then it is asked again, for the curved ones first.
    """
    parted = _split_in_turn(part, cells, [tools])
    if parted is not None:
        return parted
    flat: list[Any] = []
    curved: list[Any] = []
    for tool in tools:
        (flat if BRepAdaptor_Surface(tool).GetType() == GeomAbs_Plane else curved).append(tool)
    return _split_in_turn(part, cells, [curved, flat]) if flat and curved else None


def _split_in_turn(part: Part, cells: Sequence[int], turns: Sequence[Sequence[Any]]) -> Parted | None:
    """The pieces that several sets of tools make of cells, one set after another; None where they are not sound."""
    splitters = _Splitters()
    found = [shapes_of(part.solids[cell]).shape for cell in cells]
    for tools in turns:
        parted = splitters.part(found, tools)
        if parted is None:
            return None
        found = parted
    pieces: dict[int, list[Joined]] = {}
    for cell in cells:
        own = _pieces(part.solids[cell], splitters, _across(part, cell, cells))
        if own is None:
            return None
        pieces[cell] = own
    return Parted(part=part, pieces=pieces, splitters=splitters)


def _pieces(solid: Solid, splitters: _Splitters, across: Sequence[Hashable]) -> list[Joined] | None:
    """What splitters made of a solid; None where they did not part it, or the pieces are not sound."""
    holder, labels = shapes_of(solid), numbered_labels_of(solid)
    pieces = splitters.became(holder.shape)
    masses = [volume_and_center(piece) for piece in pieces] if len(pieces) > 1 else []
    if not masses or not _sound(solid, holder, pieces, [volume for volume, _ in masses]):
        return None
    faces = _Images(splitters, holder.faces, list(zip(labels.faces, across, strict=True)), FACE)
    edges = _Images(splitters, holder.edges, labels.edges, EDGE)
    joined = []
    for piece, mass in zip(pieces, masses, strict=True):
        own = [faces.label(face) or (FaceLabel(number=ON_CUT), None) for face in subshapes(piece, FACE)]
        lines = [edges.label(edge) or EdgeLabel() for edge in subshapes(piece, EDGE)]
        joined.append(without_seams(piece, Labels([label for label, _ in own], lines), mass, [at for _, at in own]))
    return None if _has_short_edge(solid, holder, [piece.shape for piece in joined]) else joined


def _across(part: Part, cell: int, parted: Sequence[int]) -> list[Hashable]:
    """What is on the other side of a cell's faces: alike where these may be joined, not where that is parted, too."""
    beyond: dict[int, Hashable] = {
        key: (other, face.id if other in parted else face.key)
        for other, solid in enumerate(part.solids)
        if other != cell
        for key, face in zip(solid.face_keys.tolist(), solid.faces, strict=True)
    }
    return [beyond.get(key) for key in part.solids[cell].face_keys.tolist()]


class _Splitters:
    """Splitters that part shapes one after another, with the history of one."""

    def __init__(self) -> None:
        self.own: list[Any] = []

    def part(self, shapes: Sequence[Any], tools: Sequence[Any]) -> list[Any] | None:
        """The solids that tools make of all shapes together; None where OpenCASCADE fails."""
        splitter = BOPAlgo_Splitter()
        for shape in shapes:
            splitter.AddArgument(shape)
        for tool in tools:
            splitter.AddTool(tool)
        splitter.SetNonDestructive(True)
        splitter.SetRunParallel(False)
        what = "parting a cell"
        if not attempted(splitter.Perform, what, on=[*shapes, *tools], seconds=_SECONDS) or splitter.HasErrors():
            return None
        self.own.append(splitter)
        return subshapes(splitter.Shape(), SOLID)

    def became(self, sub: Any) -> list[Any]:
        """What a face, an edge or a vertex of the shape is now; itself where it is as it was."""
        found = [sub]
        for splitter in self.own:
            left = [one for one in found if not splitter.IsDeleted(one)]
            found = [piece for one in left for piece in listed(splitter.Modified(one)) or [one]]
        return found


class _Images:
    """Which face (or edge) of a solid every piece of one comes from."""

    def __init__(self, splitter: _Splitters, old: Sequence[Any], labels: Sequence[Any], kind: Any) -> None:
        self.pieces = TopTools_IndexedMapOfShape()
        self.labels: list[Any] = []
        for shape, label in zip(old, labels, strict=True):
            for became in splitter.became(shape):
                for piece in subshapes(became, kind):
                    self.pieces.Add(piece)
                    self.labels += [label] * (self.pieces.Extent() - len(self.labels))

    def label(self, shape: Any) -> Any:
        """The label of what a shape is a piece of; None where it is new."""
        number = self.pieces.FindIndex(shape)
        return self.labels[number - 1] if number else None


def _sound(solid: Solid, holder: SolidShape, pieces: Sequence[Any], volumes: Sequence[float]) -> bool:
    """Whether pieces of some volumes are the solid, and fit to be meshed."""
    whole = holder.mass[0]
    curved = any(face.kind != "plane" for face in solid.faces)
    change = abs(sum(volumes) / whole - 1.0)
    if any(face.tips for face in solid.faces):  # the surface is open beside them
        change = abs(sum(map(volume_from_origin, pieces)) / holder.from_origin - 1.0)
    if curved and INTEGRATED < change < ROUGHLY:
        change = abs(sum(map(fine_volume, pieces)) / fine_volume(holder.shape) - 1.0)
    if change > (INTEGRATED if curved else KEPT) or min(volumes) < THINNEST * whole:
        return False
    for piece in pieces:
        # What dangles in a piece came of a tool that does not end on the solid's faces.
        if any(face.Orientation() == TopAbs_Orientation.TopAbs_INTERNAL for face in explore(piece, FACE)):
            return False
        try:
            check_closed(piece)
        except CadError:
            return False
        if faults(piece):
            return False
    return True


def _has_short_edge(solid: Solid, holder: SolidShape, pieces: Sequence[Any]) -> bool:
    """Whether a cut left an edge too short to be meshed; asked when seams that it passed by are gone."""
    old = index_map(holder.shape, EDGE)
    new = (edge for piece in pieces for edge in subshapes(piece, EDGE) if not old.Contains(edge))
    return any(_length(edge) < SHORTEST * solid.size for edge in new)


def _length(edge: Any) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(edge, properties)
    return float(np.abs(properties.Mass()))
