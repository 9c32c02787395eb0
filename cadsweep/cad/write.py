"""Cells of a part written as solids of a STEP file, with their names and colours.

Place in the flow: the other end of ``load``: what was cut can be looked at in any CAD program, and read again, where
touching solids are imprinted on each other as they were.

Method: a cell that OpenCASCADE has made is written as it is; one that was cut without it is made of its vertices,
straight edges and plane faces, each once for the whole part. Colours are those of the model; where it has none, solids
get one each, so that cells can be told apart.

Not handled: names of edges, and of a face's names all but the first.
"""

from __future__ import annotations

import colorsys
import os
from pathlib import Path
from typing import Any

from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeSolid,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_Transform,
)
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Quantity import Quantity_ColorRGBA
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from ..brep import Part, Solid, Units
from ..errors import CadError, InputError
from .names.unique import number_repeated
from .quiet import kernel_setting, quiet_opencascade
from .shapes import FACE, SOLID, SolidShape, children, compound, subshapes, typed

_HUE = 0.61803398875
"""Step of the colour circle from one solid to the next: the golden ratio never comes back to where it was."""


def write_step(part: Part, path: Path) -> list[str]:
    """Write the cells of a part as named, coloured solids in model units; returns their names.

    Parameters
    ----------
    part : Part
    path : Path
        A ``.step`` or ``.stp`` file, which is replaced.

    Raises
    ------
    InputError
        The file's suffix is none of STEP's.
    CadError
        OpenCASCADE cannot write it, or a cell is known by its numbers alone and not plane.
    """
    if path.suffix.lower() not in (".step", ".stp"):
        raise InputError(f"{path}: the pieces are written as STEP (.step), not '{path.suffix}'")
    shapes = [_moved_inside(shape) for shape in _in_model_units(cell_shapes(part), Units(part.scale, part.offset))]
    names, _ = number_repeated([part.models[owner].name for owner in part.owners], what="solid")
    document = TDocStd_Document(TCollection_ExtendedString("cadsweep"))
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    for k, (solid, shape, name) in enumerate(zip(part.solids, shapes, names, strict=True)):
        label = tool.AddShape(shape, False)
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        colors.SetColor(label, _color(solid.color or _own_color(k)), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
        for face, face_shape in zip(solid.faces, subshapes(shape, FACE), strict=True):
            if face.name is None and face.color is None:
                continue
            sub = tool.AddSubShape(label, face_shape)
            if face.name is not None:
                TDataStd_Name.Set_s(sub, TCollection_ExtendedString(face.name))
            if face.color is not None:
                colors.SetColor(sub, _color(face.color), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    _write(document, path)
    return names


def _write(document: Any, path: Path) -> None:
    """Write to a file beside, and put it in place when it is whole: on a full disk OpenCASCADE says nothing."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.step")
    try:
        with quiet_opencascade(), kernel_setting("write.stepcaf.subshapes.name", 1):
            writer = STEPCAFControl_Writer()
            writer.SetNameMode(True)
            writer.SetColorMode(True)
            done = writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
            done = done and writer.Write(str(beside)) == IFSelect_ReturnStatus.IFSelect_RetDone
        if not done or b"END-ISO-10303-21" not in beside.read_bytes()[-100:]:
            raise CadError(f"OpenCASCADE could not write {path}: is the folder there, writable and not full?")
        beside.replace(path)
    except OSError as error:
        raise CadError(f"{path} cannot be written: {error.strerror or error}.") from error
    finally:
        beside.unlink(missing_ok=True)


def cell_shapes(part: Part) -> list[Any]:
    """The solids of all cells, their faces in the order of their ids; working units."""
    built = _Built()
    shapes = []
    for solid in part.solids:
        holder = solid.kernel
        shapes.append(holder.shape if isinstance(holder, SolidShape) else built.solid(solid))
    return shapes


class _Built:
    """Shapes made of numbers, each vertex, edge and face once, by its key in the part."""

    def __init__(self) -> None:
        self._vertices: dict[int, Any] = {}
        self._edges: dict[int, Any] = {}
        self._faces: dict[int, Any] = {}

    def solid(self, solid: Solid) -> Any:
        """A solid of plane faces with straight edges."""
        curved = next((f for f in solid.faces if f.kind != "plane"), None)
        bent = next((e for e in solid.edges if e.kind != "line"), None)
        if curved is not None or bent is not None:
            raise CadError(f"the cell '{solid.name}' has no shape to write, and is not plane")
        builder, shell = BRep_Builder(), TopoDS_Shell()
        builder.MakeShell(shell)
        for number in range(len(solid.faces)):
            builder.Add(shell, self._face(solid, number))
        shell.Closed(True)
        return BRepBuilderAPI_MakeSolid(shell).Solid()

    def _vertex(self, solid: Solid, number: int) -> Any:
        key = int(solid.vertex_keys[number])
        if key not in self._vertices:
            self._vertices[key] = BRepBuilderAPI_MakeVertex(gp_Pnt(*solid.vertices[number])).Vertex()
        return self._vertices[key]

    def _edge(self, solid: Solid, number: int, forward: bool) -> Any:
        key, edge = int(solid.edge_keys[number]), solid.edges[number]
        if key not in self._edges:
            ends = self._vertex(solid, edge.start), self._vertex(solid, edge.end)
            self._edges[key] = BRepBuilderAPI_MakeEdge(*ends).Edge()
        return self._edges[key] if forward else typed(self._edges[key].Reversed(), self._edges[key].ShapeType())

    def _face(self, solid: Solid, number: int) -> Any:
        """A face as its cell has it: the second of two that share it gets it reversed."""
        key, face = int(solid.face_keys[number]), solid.faces[number]
        if key in self._faces:
            return self._faces[key].Reversed()
        plane = gp_Pln(gp_Pnt(*face.center), gp_Dir(*face.normal))
        wires = []
        for loop in face.loops:
            wire = BRepBuilderAPI_MakeWire()
            for edge, forward in loop.directed:
                wire.Add(self._edge(solid, edge, forward))
            wires.append(wire.Wire())
        made = BRepBuilderAPI_MakeFace(plane, wires[0])
        for wire in wires[1:]:
            made.Add(wire)
        self._faces[key] = made.Face()
        return self._faces[key]


def _in_model_units(shapes: list[Any], units: Units) -> list[Any]:
    if units.scale == 1.0 and not units.offset.any():
        return shapes
    stretch, shift = gp_Trsf(), gp_Trsf()
    stretch.SetScaleFactor(units.scale)
    shift.SetTranslation(gp_Vec(*units.offset))
    tool = BRepBuilderAPI_Transform(compound(shapes), shift.Multiplied(stretch), True)
    return [typed(tool.ModifiedShape(shape), SOLID) for shape in shapes]


def _moved_inside(solid: Any) -> Any:
    """A solid that has no place of its own, its shells have it: what is placed as a whole has no faces to be named."""
    if solid.Location().IsIdentity():
        return solid
    builder, made = BRep_Builder(), TopoDS_Solid()
    builder.MakeSolid(made)
    for shell in children(solid):
        builder.Add(made, shell)
    return made


def _own_color(number: int) -> str:
    """A colour for a solid that has none, as unlike that of the one before as can be."""
    red, green, blue = colorsys.hsv_to_rgb((0.58 + number * _HUE) % 1.0, 0.45, 0.9)
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in (red, green, blue))


def _color(text: str) -> Any:
    found = Quantity_ColorRGBA()
    if not Quantity_ColorRGBA.ColorFromHex_s(text, found):
        raise CadError(f"the colour {text!r} is none of the form #rrggbb")
    return found


__all__ = ["cell_shapes", "write_step"]
