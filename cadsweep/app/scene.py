"""What the browser draws, as VTK's objects: the part with what is picked, or a mesh as it is looked at.

Place in the flow: :mod:`.control` changes it, trame sends what has changed. Nothing is drawn here: the objects are
described to vtk.js, which has a camera for every page.

The part is one surface whose facets carry colours, so that a pick sends colours and no geometry; edges are tubes, for a
browser draws lines of one pixel alone.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..view import quiet_vtk
from .entities import PartData

Color = tuple[int, int, int]
PLAIN: Color = (196, 205, 216)
PICKED: Color = (255, 152, 0)
HOVERED: Color = (255, 213, 128)
QUESTIONED: Color = (224, 36, 27)
EDGE: Color = (38, 44, 54)
BACKGROUND = {"light": (0.965, 0.972, 0.98), "dark": (0.09, 0.105, 0.125)}
_TUBE = 0.0035
"""Radius of a highlighted edge over the part's size."""
_NEARER = 0.9
"""Of the way to the whole part's middle, that its nearest corner stays clear of the window's rim."""


def rgb(text: str) -> Color:
    """A colour ``#rrggbb``."""
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


class Scene:
    """A render window that is never drawn here, with the actors of the part and of the mesh.

    Attributes
    ----------
    window : vtkRenderWindow
    """

    def __init__(self) -> None:
        with quiet_vtk():
            import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (the factory of all of them)
            from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

            self.window = vtkRenderWindow()
            self.window.SetOffScreenRendering(1)
            self.renderer = vtkRenderer()
            self.window.AddRenderer(self.renderer)
        self._actors: dict[str, Any] = {}
        self.part: PartData | None = None
        self.set_theme("light")

    def set_theme(self, theme: str) -> None:
        """Light or dark behind the part."""
        self.renderer.SetBackground(*BACKGROUND[theme])

    def set_part(self, part: PartData) -> None:
        """Show another part."""
        self.part = part
        for name in list(self._actors):
            self._remove(name)
        surface = surface_of(part.points, part.triangles, normals=part.normals)
        self._facets = surface
        actor = self._add("part", surface)
        actor.GetMapper().SetScalarModeToUseCellData()
        actor.GetMapper().SetColorModeToDirectScalars()
        actor.GetProperty().SetAmbient(0.25)
        actor.GetProperty().SetDiffuse(0.8)
        edges = self._add("edges", lines_of(list(part.chains.values())))
        edges.GetProperty().SetColor(*(c / 255 for c in EDGE))
        edges.PickableOff()
        self.color_part((), None, {})
        self.look_at(part.points)

    def look_at(self, points: FloatArray) -> None:
        """Put the camera where the whole is seen from a corner."""
        low, high = points.min(axis=0), points.max(axis=0)
        middle, size = (low + high) / 2, float(np.linalg.norm(high - low))
        camera = self.renderer.GetActiveCamera()
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(middle + np.array([1.0, -1.4, 0.9]) * size))
        camera.SetViewUp(0.0, 0.0, 1.0)
        self.renderer.ResetCamera(*(float(v) for pair in zip(low, high, strict=True) for v in pair))
        camera.Dolly(_NEARER)

    def color_part(self, picked: Collection[str], hovered: str | None, questioned: Mapping[str, Any] | None) -> None:
        """Colour faces and edges by what is picked, under the pointer, or in question."""
        part = self.part
        if part is None:
            return
        colors = np.array(
            [_color(part, key, picked, hovered, questioned or {}) for key in part.face_keys], dtype=np.uint8
        )
        _set_colors(self._facets, colors.reshape(-1, 3)[part.owners])
        for name, color, keys in (
            ("picked edges", PICKED, [key for key in picked if key in part.chains]),
            ("hovered edge", HOVERED, [hovered] if hovered in part.chains else []),
        ):
            self._set_tubes(name, color, [part.chains[key] for key in keys])

    def _set_tubes(self, name: str, color: Color, chains: list[FloatArray]) -> None:
        if not chains:
            if name in self._actors:
                self._actors[name].VisibilityOff()
            return
        assert self.part is not None
        tubes = tubes_of(chains, _TUBE * self.part.size)
        if name in self._actors:
            self._actors[name].GetMapper().SetInputData(tubes)
        else:
            actor = self._add(name, tubes)
            actor.GetProperty().SetColor(*(c / 255 for c in color))
            actor.GetProperty().SetAmbient(0.6)
            actor.PickableOff()
        self._actors[name].VisibilityOn()

    def mark_cell(self, chains: list[FloatArray]) -> None:
        """Show the edges (m, 3) of a cell in question; none: take them away."""
        if "cell in question" in self._actors:
            self._remove("cell in question")
        self._set_tubes("cell in question", QUESTIONED, chains)

    def show_part(self, shown: bool) -> None:
        """Show the part, or leave the place to a mesh."""
        for name in ("part", "edges", "picked edges", "hovered edge", "cell in question"):
            if name in self._actors:
                self._actors[name].SetVisibility(shown)

    def set_surface(self, name: str, surface: Any | None, *, edges: bool = False, pickable: bool = True) -> None:
        """Show a surface whose cells carry colours under a name, in the place of the one before; None hides it."""
        if surface is None:
            if name in self._actors:
                self._actors[name].VisibilityOff()
            return
        if name in self._actors:
            self._actors[name].GetMapper().SetInputData(surface)
        else:
            actor = self._add(name, surface)
            actor.GetMapper().SetScalarModeToUseCellData()
            actor.GetMapper().SetColorModeToDirectScalars()
            actor.GetProperty().SetAmbient(0.35)
            actor.GetProperty().SetDiffuse(0.75)
            actor.GetProperty().SetInterpolationToFlat()
            actor.SetPickable(pickable)
        self._actors[name].GetProperty().SetEdgeVisibility(edges)
        self._actors[name].GetProperty().SetEdgeColor(*(c / 255 for c in EDGE))
        self._actors[name].VisibilityOn()

    def set_lines(self, name: str, lines: Any | None, color: Color) -> None:
        """Show lines under a name; None hides them."""
        if lines is None:
            if name in self._actors:
                self._actors[name].VisibilityOff()
            return
        if name in self._actors:
            self._actors[name].GetMapper().SetInputData(lines)
        else:
            self._add(name, lines).PickableOff()
        self._actors[name].GetProperty().SetColor(*(c / 255 for c in color))
        self._actors[name].VisibilityOn()

    def _add(self, name: str, surface: Any) -> Any:
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        mapper = vtkPolyDataMapper()
        mapper.SetInputData(surface)
        actor = vtkActor()
        actor.SetMapper(mapper)
        self.renderer.AddActor(actor)
        self._actors[name] = actor
        return actor

    def _remove(self, name: str) -> None:
        self.renderer.RemoveActor(self._actors.pop(name))


def _color(
    part: PartData, key: str, picked: Collection[str], hovered: str | None, questioned: Mapping[str, Any]
) -> Color:
    entity = part.entities[key]
    solid = f"solid:{entity.solid}"
    if hovered in (key, solid):
        return HOVERED
    if key in picked or solid in picked:
        return PICKED
    if key in questioned:
        return QUESTIONED
    color = entity.color or part.entities[solid].color
    return rgb(color) if color else PLAIN


def surface_of(points: FloatArray, cells: IntArray, *, normals: FloatArray | None = None) -> Any:
    """Triangles (t, 3) or quads (q, 4) as vtkPolyData, in single precision: it is looked at and nothing else."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    surface = vtkPolyData()
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float32), deep=True))
    surface.SetPoints(places)
    polygons = vtkCellArray()
    offsets = np.arange(0, cells.size + 1, cells.shape[1], dtype=np.int64)
    polygons.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells, dtype=np.int64).ravel(), deep=True),
    )
    surface.SetPolys(polygons)
    if normals is not None:
        array = numpy_to_vtk(np.ascontiguousarray(normals, dtype=np.float32), deep=True)
        array.SetName("Normals")
        surface.GetPointData().SetNormals(array)
    return surface


def _set_colors(surface: Any, colors: np.ndarray) -> None:
    """Give every cell a colour, (cells, 3) uint8."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    array = numpy_to_vtk(np.ascontiguousarray(colors, dtype=np.uint8), deep=True)
    array.SetName("colors")
    surface.GetCellData().SetScalars(array)
    surface.Modified()


def colored(surface: Any, colors: np.ndarray) -> Any:
    """The surface with a colour for every cell, (cells, 3) uint8."""
    _set_colors(surface, colors)
    return surface


def lines_of(chains: list[FloatArray]) -> Any:
    """Chains of points (m, 3) as vtkPolyData."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    lines = vtkPolyData()
    points = vtkPoints()
    joined = np.concatenate(chains) if chains else np.empty((0, 3))
    points.SetData(numpy_to_vtk(np.ascontiguousarray(joined, dtype=np.float32), deep=True))
    lines.SetPoints(points)
    cells = vtkCellArray()
    offsets = np.cumsum([0, *(len(chain) for chain in chains)]).astype(np.int64)
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.arange(len(joined), dtype=np.int64), deep=True),
    )
    lines.SetLines(cells)
    return lines


def tubes_of(chains: list[FloatArray], radius: float) -> Any:
    """Tubes around chains of points."""
    from vtkmodules.vtkFiltersCore import vtkTubeFilter

    tube = vtkTubeFilter()
    tube.SetInputData(lines_of(chains))
    tube.SetRadius(radius)
    tube.SetNumberOfSides(8)
    tube.CappingOn()
    tube.Update()
    return tube.GetOutput()
