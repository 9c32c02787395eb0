"""A mesh drawn: in somebody's pyvista plotter, in a window, or as a PNG without a display.

Not handled: hexahedra of order 2 are drawn straight between their corners.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import CadSweepError, InputError
from ..mesh import HexMesh
from .clipping import Clip, cut_skin, kept_by_clip, left_of_rim
from .display import can_open_window, check_drawing, has_trame, in_notebook, quiet_vtk, write_whole
from .exploded import explode as explode_parts
from .grid import cad_colors, import_pyvista, legible, mesh_colors, outline, part_colors, skin

_COLORMAP = "viridis"
_PLAIN = "#d6dbe2"
_LONGEST_LEGEND = 24
"""Names in a legend: what fits beside a picture of 800 pixels."""
_LEGEND_WIDTH = 0.2
"""Of a picture's width: what a name of twenty letters takes."""
_BUTTONS = 0.14
"""Of a picture's height: buttons over a view of 400 pixels, which is what a notebook gives it."""
_SCALE_LEFT = 0.86
"""Where the colour scale begins, of a picture's width."""
_SCALE = {
    "title": "scaled Jacobian",
    "n_labels": 5,
    "fmt": "%.2g",
    "color": "black",
    "vertical": True,
    "title_font_size": 16,
    "label_font_size": 14,
    "position_x": _SCALE_LEFT,
    "position_y": 0.2,
    "height": 0.6,
    "width": 0.06,
}


def add_mesh(
    plotter: Any,
    mesh: HexMesh,
    *,
    scalars: str | None = "scaled_jacobian",
    clip: Clip | None = None,
    crinkle: bool = False,
    show_boundaries: bool = True,
    limits: tuple[float, float] = (0.0, 1.0),
    scale: bool | dict[str, Any] = True,
) -> None:
    """Draw a mesh in a ``pyvista.Plotter``; the options are those of :func:`plot`.

    Parameters
    ----------
    limits : (float, float)
        Ends of the colour scale. What lies below is red: with the default, hexahedra that are inverted.
    scale : bool or dict
        Draw the colour scale, or not; a dict overrides how pyvista draws it.
    """
    if scalars not in (None, "scaled_jacobian", "boundary", "part", "cad"):
        raise InputError(f"scalars must be 'scaled_jacobian', 'boundary', 'part', 'cad' or None, not {scalars!r}")
    kept = kept_by_clip(mesh, clip) if clip is not None and crinkle else None
    surface, owners = skin(mesh, kept) if clip is None or kept is not None else cut_skin(mesh, clip)
    if not surface.n_cells:
        raise InputError(f"clip = {clip!r} takes every hexahedron away; turn its normal round or move its origin")
    names = list(mesh.boundaries)
    colors = mesh_colors(mesh)
    edge_width = 1.0 if mesh.n_hexes < 50_000 else 0.3
    style = {"show_edges": True, "edge_color": "#303030", "line_width": edge_width, "ambient": 0.35, "diffuse": 0.75}
    any_below = bool(surface.cell_data["scaled_jacobian"].min() < limits[0])
    below = {"below_label": "inverted"} if any_below and limits[0] == 0 else {}
    if scalars == "scaled_jacobian":
        plotter.add_mesh(
            surface,
            scalars="scaled_jacobian",
            cmap=_COLORMAP,
            clim=limits,
            below_color="red" if any_below else None,
            show_scalar_bar=bool(scale),
            scalar_bar_args=_SCALE | below | (scale if isinstance(scale, dict) else {}),
            **style,
        )
    elif scalars is not None:
        groups, colored = _colored_groups(mesh, surface, owners, scalars)
        for i, color in enumerate(colored):
            patch = np.flatnonzero(groups == i)
            if len(patch):
                plotter.add_mesh(surface.extract_cells(patch), color=color, **style)
    else:
        plotter.add_mesh(surface, color=_PLAIN, **style)
    if scalars == "part" and mesh.parts:
        _add_legend(plotter, list(mesh.parts), [legible(color) for color in part_colors(mesh)])
    elif show_boundaries and names:
        _add_boundaries(plotter, mesh, [legible(color) for color in colors], clip, kept)


def _colored_groups(mesh: HexMesh, surface: Any, owners: IntArray, scalars: str) -> tuple[IntArray, list[str]]:
    """Which colour each quad of the skin has, and the colours: of parts, or of boundaries."""
    if scalars == "part":
        part_of = np.full(mesh.n_hexes, len(mesh.parts), dtype=np.int64)
        for i, ids in enumerate(mesh.parts.values()):
            part_of[ids] = i
        return part_of[surface.cell_data["hex"]], [*part_colors(mesh), _PLAIN]
    colors = cad_colors(mesh, _PLAIN) if scalars == "cad" else [*mesh_colors(mesh), _PLAIN]
    # What the clip laid open has no boundary, and the last colour.
    return np.where(owners < 0, len(mesh.boundaries), owners), colors


def _add_boundaries(plotter: Any, mesh: HexMesh, colors: list[str], clip: Clip | None, kept: np.ndarray | None) -> None:
    """Draw what the clip leaves of the rim of every boundary in its colour, and a legend of the names."""
    left: list[tuple[str, str]] = []
    for (name, quads), color in zip(mesh.boundaries.items(), colors, strict=True):
        rim = outline(quads[:, :4])
        lines = left_of_rim(mesh, rim, clip=clip, kept=kept)
        if lines is not None:
            plotter.add_mesh(lines, color=color, line_width=4)
        if lines is not None or not len(rim):  # a closed boundary has no rim, and is in the legend
            left.append((name, color))
    if left:
        _add_legend(plotter, [name for name, _ in left], [color for _, color in left])


def _add_legend(plotter: Any, names: list[str], colors: list[str]) -> None:
    entries = [[name, color] for name, color in zip(names, colors, strict=True)][:_LONGEST_LEGEND]
    if len(names) > _LONGEST_LEGEND:
        entries.append([f"and {len(names) - _LONGEST_LEGEND} more", "white"])
    height = min(0.9, 0.028 * len(entries) + 0.02)
    plotter.add_legend(entries, bcolor=None, face="rectangle", size=(_LEGEND_WIDTH, height), loc="upper left")


def _make_room(plotter: Any, width: float) -> None:
    """Draw the model beside the legend and the colour scale, so that it is under neither.

    Parameters
    ----------
    width : float
        Width of the picture over its height. The view as it is fills the smaller of both.
    """
    left, right = _LEGEND_WIDTH, _SCALE_LEFT
    plotter.camera_position = plotter.renderer.get_default_cam_pos()
    plotter.reset_camera()
    plotter.camera.zoom(min(1.0, (right - left) * max(1.0, width)))
    plotter.camera.SetWindowCenter(1.0 - (left + right), 0.0)


def _lower_legend(plotter: Any) -> None:
    """Make room for the buttons that a view in a notebook has along its upper edge."""
    if plotter.renderer.legend is not None:
        x, y = plotter.renderer.legend.GetPosition()
        plotter.renderer.legend.SetPosition(x, y - _BUTTONS)


def plot(
    mesh: HexMesh,
    *,
    screenshot: str | PathLike[str] | None = None,
    scalars: str | None = "scaled_jacobian",
    clip: Clip | None = None,
    crinkle: bool = False,
    show_boundaries: bool = True,
    limits: tuple[float, float] = (0.0, 1.0),
    explode: float = 0.0,
    window_size: tuple[int, int] = (1200, 900),
    camera: Any = None,
) -> Any:
    """Show a mesh in a window or a notebook, or write a picture of it.

    Parameters
    ----------
    screenshot : path, optional
        Write a PNG instead of opening a window; needs no display. A notebook needs none either.
    scalars : "scaled_jacobian", "boundary", "part", "cad" or None
        What the faces are coloured by. Parts and boundaries have the colours of their CAD solids and faces, where
        they have any, and others elsewhere; with "cad" all is as the CAD model shows it.
    clip : str or (normal, origin), optional
        Take away what lies on the side of the normal: ``"x"``, ``"-z"`` through the middle, or any plane.
    crinkle : bool
        Keep whole hexahedra behind the plane, instead of cutting them smoothly.
    show_boundaries : bool
        Draw the rims of the named boundaries, with a legend.
    limits : (float, float)
        Ends of the colour scale; what lies below is red.
    explode : float
        Draw the parts of an assembly apart (:func:`cadsweep.view.exploded.explode`); 0 draws them in their places.
    window_size : (int, int)
        Pixels.
    camera : optional
        Any pyvista camera position.

    Returns
    -------
    Path, PIL.Image.Image, widget or None
        Where the picture was written; in a notebook the picture itself, which the cell shows, or where trame is
        installed a view to turn; None after a window was closed.

    Raises
    ------
    InputError
        An unknown option, or a clip that leaves nothing.
    CadSweepError
        pyvista is not installed, or the machine can draw nothing.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.sweep_mesh(box, size=1.0).plot(screenshot="box.png", clip="x").name
    'box.png'
    """
    pv = import_pyvista()
    inline = screenshot is None and in_notebook()
    if screenshot is None and not inline and not can_open_window():
        raise CadSweepError("there is no display to open a window on; ask for a picture with screenshot='mesh.png'")
    if screenshot is not None and Path(screenshot).suffix.lower() != ".png":
        raise InputError(f"screenshot must end in .png, not '{screenshot}'")
    check_drawing()
    turning = False
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=inline or screenshot is not None, window_size=window_size)
        try:
            plotter.set_background("white")
            looks: dict[str, Any] = {"scalars": scalars, "clip": clip, "crinkle": crinkle, "limits": limits}
            shown = explode_parts(mesh, explode) if explode else mesh
            add_mesh(plotter, shown, show_boundaries=show_boundaries, **looks)
            plotter.add_axes(color="black")
            if camera is not None:
                plotter.camera_position = camera
            elif plotter.renderer.legend is not None:
                _make_room(plotter, window_size[0] / window_size[1])
            if screenshot is not None:
                return save_screenshot(plotter, Path(screenshot))
            if inline and has_trame():
                turning = True
                _lower_legend(plotter)
                return plotter.show(jupyter_backend="trame", return_viewer=True, auto_close=False)
            if inline:
                return take_picture(plotter)
            plotter.show()
            return None
        finally:
            if not turning:  # the view is drawn from the plotter for as long as it is looked at
                plotter.close()


def mesh_picture(mesh: HexMesh, *, size: tuple[int, int] = (640, 480)) -> Any:
    """A small picture of a mesh, as a ``PIL.Image.Image``: for cards."""
    with _small_plotter(size) as (plotter, _):
        add_mesh(plotter, mesh, show_boundaries=False)
        return take_picture(plotter)


def part_picture(
    faces: Sequence[tuple[FloatArray, IntArray, str]],
    edges: Sequence[FloatArray],
    *,
    size: tuple[int, int] = (640, 480),
) -> Any:
    """A small picture of a part: faces as points (n, 3), triangles (t, 3) and a colour each, edges as chains (m, 3)."""
    with _small_plotter(size) as (plotter, pv):
        for points, triangles, color in faces:
            surface = pv.PolyData(points, np.column_stack([np.full(len(triangles), 3), triangles]).ravel())
            plotter.add_mesh(surface, color=color, ambient=0.35, diffuse=0.75)
        for chain in edges:
            plotter.add_mesh(pv.lines_from_points(chain), color="#303030", line_width=2)
        return take_picture(plotter)


@contextmanager
def _small_plotter(size: tuple[int, int]) -> Iterator[tuple[Any, Any]]:
    """An empty plotter of a few pixels off the screen, and pyvista; it is closed in the end."""
    pv = import_pyvista()
    check_drawing()
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=True, window_size=size)
        try:
            plotter.set_background("white")
            yield plotter, pv
        finally:
            plotter.close()


def take_picture(plotter: Any) -> Any:
    """What a plotter shows, as a ``PIL.Image.Image``."""
    from PIL import Image

    return Image.fromarray(plotter.screenshot(None))


def save_screenshot(plotter: Any, path: Path) -> Path:
    """Write what a plotter shows as a PNG, whole or not at all."""
    image = io.BytesIO()
    take_picture(plotter).save(image, format="png", optimize=True)
    return write_whole(path, image.getvalue())
