"""Meshes as pictures: a pyvista grid, a window, or a PNG without a display.

Place in the flow: after ``quality``; called by ``HexMesh.plot``, ``cadsweep view`` and the report.

Method: the grid holds the hexahedra with their scaled Jacobian; a clip shows whole hexahedra behind a
plane, so that what is seen inside is the mesh and not a cut through it. Boundaries are drawn from the
quads that the mesh names, not guessed from angles.

Not handled: pictures draw hexahedra of order 2 straight between their corners.
"""

from __future__ import annotations

import io
import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .errors import CadSweepError, InputError
from .mesh import HexMesh
from .topology import FloatArray, IntArray

log = logging.getLogger(__name__)

_VTK_TYPES = {8: 12, 20: 25, 27: 29}
_COLORMAP = "viridis"
_PLAIN = "#d6dbe2"
_SCALE = {
    "title": "scaled Jacobian",
    "n_labels": 5,
    "fmt": "%.2g",
    "color": "black",
    "vertical": True,
    "title_font_size": 16,
    "label_font_size": 14,
    "position_x": 0.86,
    "position_y": 0.2,
    "height": 0.6,
    "width": 0.06,
}
_LONGEST_LEGEND = 24

Clip = str | tuple[Sequence[float], Sequence[float]]
"""An axis, ``"x"`` or ``"-x"``, through the middle of the mesh, or (normal, origin) of a plane.
What the normal points at is taken away."""


def _pyvista() -> Any:
    """Import pyvista, or say how to get it."""
    try:
        import pyvista
    except ImportError as error:
        raise CadSweepError(f'pictures need the extra "view": pip install "cadsweep[view]" ({error})') from error
    return pyvista


def to_pyvista(mesh: HexMesh) -> Any:
    """Return the mesh as a ``pyvista.UnstructuredGrid``.

    Parameters
    ----------
    mesh : HexMesh

    Returns
    -------
    pyvista.UnstructuredGrid
        Cell data: ``scaled_jacobian`` (of order 2: of the corners) and ``part``, an index into the field
        data ``part_names``. Field data ``boundary_names``; the quads of a boundary are what
        :func:`boundaries_to_pyvista` gives.

    Raises
    ------
    CadSweepError
        pyvista is not installed.
    """
    pv = _pyvista()
    from .quality import scaled_jacobians

    n_cell_nodes = mesh.hexes.shape[1]
    cells = np.column_stack([np.full(mesh.n_hexes, n_cell_nodes), mesh.hexes]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(mesh.n_hexes, _VTK_TYPES[n_cell_nodes], dtype=np.uint8), mesh.points)
    grid.cell_data["scaled_jacobian"] = scaled_jacobians(mesh.points, mesh.hexes[:, :8])
    owners = np.full(mesh.n_hexes, -1, dtype=np.int64)
    for i, ids in enumerate(mesh.parts.values()):
        owners[ids] = i
    grid.cell_data["part"] = owners
    for key, names in (("part_names", list(mesh.parts)), ("boundary_names", list(mesh.boundaries))):
        if names:
            grid.field_data[key] = names
    grid.set_active_scalars("scaled_jacobian")
    return grid


def boundaries_to_pyvista(mesh: HexMesh) -> Any:
    """Return the boundary quads as a ``pyvista.PolyData``.

    Returns
    -------
    pyvista.PolyData
        Corner quads of all boundaries, on the nodes of the mesh; cell data ``boundary`` is an index into
        the field data ``boundary_names``.

    Raises
    ------
    CadSweepError
        pyvista is not installed.
    """
    pv = _pyvista()
    quads = [boundary[:, :4] for boundary in mesh.boundaries.values()]
    surface = pv.PolyData.from_regular_faces(mesh.points, np.concatenate(quads) if quads else np.empty((0, 4), int))
    surface.cell_data["boundary"] = np.repeat(np.arange(len(quads)), [len(q) for q in quads])
    if quads:
        surface.field_data["boundary_names"] = list(mesh.boundaries)
    return surface


def skin(mesh: HexMesh, kept: np.ndarray | None = None) -> tuple[Any, IntArray]:
    """Return what is seen of the hexahedra, or of those `kept`.

    Returns
    -------
    pyvista.PolyData
        Quads with the cell data ``scaled_jacobian`` and ``hex`` of the hexahedron behind them.
    (m,) int64
        Boundary that each quad belongs to, as an index into ``mesh.boundaries``; -1 inside the mesh.
    """
    pv = _pyvista()
    from .quality import scaled_jacobians

    ids = np.arange(mesh.n_hexes) if kept is None else np.flatnonzero(kept)
    corners = mesh.hexes[ids, :8]
    cells = np.column_stack([np.full(len(ids), 8), corners]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(len(ids), _VTK_TYPES[8], dtype=np.uint8), mesh.points)
    grid.cell_data["hex"] = ids
    grid.cell_data["scaled_jacobian"] = scaled_jacobians(mesh.points, corners)
    grid.point_data["node"] = np.arange(mesh.n_nodes)
    surface = grid.extract_surface(algorithm=None)
    seen = np.sort(surface.point_data["node"][surface.regular_faces], axis=1)
    owners = np.full(len(seen), -1, dtype=np.int64)
    if mesh.boundaries:
        named = np.concatenate([quads[:, :4] for quads in mesh.boundaries.values()])
        names = np.repeat(np.arange(len(mesh.boundaries)), [len(quads) for quads in mesh.boundaries.values()])
        _, inverse = np.unique(np.concatenate([np.sort(named, axis=1), seen]), axis=0, return_inverse=True)
        table = np.full(len(inverse), -1, dtype=np.int64)
        table[inverse[: len(named)]] = names
        owners = table[inverse[len(named) :]]
    return surface, owners


def outline(quads: IntArray) -> IntArray:
    """Edges (m, 2) that belong to one quad alone: the rim of a patch of quads (q, 4)."""
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, counts = np.unique(edges, axis=0, return_counts=True)
    return unique[counts == 1]


def kept_by_clip(mesh: HexMesh, clip: Clip) -> np.ndarray:
    """Which hexahedra (n_hexes,) lie behind a plane, judged by their middles.

    Raises
    ------
    InputError
        The clip is no axis and no plane.
    """
    normal, origin = _plane(mesh, clip)
    return (mesh.points[mesh.hexes[:, :8]].mean(axis=1) - origin) @ normal <= 0


def _plane(mesh: HexMesh, clip: Clip) -> tuple[FloatArray, FloatArray]:
    if isinstance(clip, str):
        axis = clip.removeprefix("-").lower()
        if axis not in ("x", "y", "z"):
            raise InputError(f"clip must be an axis such as 'x' or '-x', or (normal, origin), not {clip!r}")
        normal = np.eye(3)["xyz".index(axis)] * (-1 if clip.startswith("-") else 1)
        return normal, (mesh.points.min(axis=0) + mesh.points.max(axis=0)) / 2
    try:
        normal, origin = (np.asarray(v, dtype=np.float64) for v in clip)
    except (TypeError, ValueError) as error:
        raise InputError(f"clip must be an axis, or (normal, origin) with three numbers each, not {clip!r}") from error
    length = np.linalg.norm(normal)
    if normal.shape != (3,) or origin.shape != (3,) or not np.isfinite(origin).all() or not 0 < length < np.inf:
        raise InputError(f"clip needs a normal of some length and an origin, three numbers each, not {clip!r}")
    return normal / length, origin


def add_mesh(
    plotter: Any,
    mesh: HexMesh,
    *,
    scalars: str | None = "scaled_jacobian",
    clip: Clip | None = None,
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
    if scalars not in (None, "scaled_jacobian", "boundary"):
        raise InputError(f"scalars must be 'scaled_jacobian', 'boundary' or None, not {scalars!r}")
    kept = None if clip is None else kept_by_clip(mesh, clip)
    hexes = mesh.hexes if kept is None else mesh.hexes[kept]
    if not len(hexes):
        raise InputError(f"clip = {clip!r} takes every hexahedron away; turn its normal round or move its origin")
    names = list(mesh.boundaries)
    colors = boundary_colors(len(names))
    edge_width = 1.0 if mesh.n_hexes < 50_000 else 0.3
    style = {"show_edges": True, "edge_color": "#303030", "line_width": edge_width, "ambient": 0.35, "diffuse": 0.75}
    surface, owners = skin(mesh, kept)
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
    elif scalars == "boundary" and names:
        for i, color in enumerate([*colors, _PLAIN]):  # the index -1 of what the clip laid open comes last
            patch = np.flatnonzero(owners == (i if i < len(names) else -1))
            if len(patch):
                plotter.add_mesh(surface.extract_cells(patch), color=color, **style)
    else:
        plotter.add_mesh(surface, color=_PLAIN, **style)
    if show_boundaries and names:
        _add_boundaries(plotter, mesh, colors)


def _add_boundaries(plotter: Any, mesh: HexMesh, colors: list[str]) -> None:
    """Draw the rim of every boundary in its colour, and a legend of the names."""
    pv = _pyvista()
    for quads, color in zip(mesh.boundaries.values(), colors, strict=True):
        rim = outline(quads[:, :4])
        if len(rim):
            lines = pv.PolyData(mesh.points, lines=np.column_stack([np.full(len(rim), 2), rim]).ravel())
            plotter.add_mesh(lines, color=color, line_width=4)
    entries = [[name, color] for name, color in zip(mesh.boundaries, colors, strict=True)][:_LONGEST_LEGEND]
    if len(mesh.boundaries) > _LONGEST_LEGEND:
        entries.append([f"and {len(mesh.boundaries) - _LONGEST_LEGEND} more", "white"])
    height = min(0.9, 0.035 * len(entries) + 0.02)
    plotter.add_legend(entries, bcolor=None, face="rectangle", size=(0.2, height), loc="upper left")


def boundary_colors(n: int) -> list[str]:
    """Return n colours that differ in hue, and from one turn of the hues to the next in lightness."""
    from colorsys import hls_to_rgb

    golden = 0.618033988749895  # neighbours in the list lie far apart on the circle of hues
    tones = [hls_to_rgb((0.02 + i * golden) % 1, (0.45, 0.6, 0.32)[i // 8 % 3], 0.75) for i in range(n)]
    return ["#" + "".join(f"{round(255 * c):02x}" for c in tone) for tone in tones]


def plot(
    mesh: HexMesh,
    *,
    screenshot: str | PathLike[str] | None = None,
    scalars: str | None = "scaled_jacobian",
    clip: Clip | None = None,
    show_boundaries: bool = True,
    limits: tuple[float, float] = (0.0, 1.0),
    window_size: tuple[int, int] = (1200, 900),
    camera: Any = None,
) -> Any:
    """Show a mesh in a window, or write a picture of it.

    Parameters
    ----------
    screenshot : path, optional
        Write a PNG instead of opening a window; needs no display.
    scalars : "scaled_jacobian", "boundary" or None
        What the faces are coloured by.
    clip : str or (normal, origin), optional
        Take away what lies on the side of the normal: ``"x"``, ``"-z"`` through the middle, or any plane.
    show_boundaries : bool
        Draw the rims of the named boundaries, with a legend.
    limits : (float, float)
        Ends of the colour scale; what lies below is red.
    window_size : (int, int)
        Pixels.
    camera : optional
        Any pyvista camera position.

    Returns
    -------
    Path or None
        Where the picture was written; None after a window was closed.

    Raises
    ------
    InputError
        An unknown option, or a clip that leaves nothing.
    CadSweepError
        pyvista is not installed, or the machine can draw nothing.
    """
    pv = _pyvista()
    if screenshot is None and not can_open_window():
        raise CadSweepError("there is no display to open a window on; ask for a picture with screenshot='mesh.png'")
    if screenshot is not None and Path(screenshot).suffix.lower() != ".png":
        raise InputError(f"screenshot must end in .png, not '{screenshot}'")
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=screenshot is not None, window_size=window_size)
        try:
            plotter.set_background("white")
            add_mesh(plotter, mesh, scalars=scalars, clip=clip, show_boundaries=show_boundaries, limits=limits)
            plotter.add_axes(color="black")
            if camera is not None:
                plotter.camera_position = camera
            if screenshot is None:
                plotter.show()
                return None
            return save_screenshot(plotter, Path(screenshot))
        finally:
            plotter.close()


def save_screenshot(plotter: Any, path: Path) -> Path:
    """Write what a plotter shows as a PNG, whole or not at all."""
    from PIL import Image

    image = io.BytesIO()
    Image.fromarray(plotter.screenshot(None)).save(image, format="png", optimize=True)
    return write_whole(path, image.getvalue())


def write_whole(path: Path, data: bytes) -> Path:
    """Put a file in place in one step.

    Raises
    ------
    CadSweepError
        The folder is missing or not writable, or the disk is full. Nothing is left behind.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        try:
            with temporary.open("wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise CadSweepError(f"cannot write {path}: {error.strerror or error}; choose another place") from error
    return path


def can_open_window() -> bool:
    """Whether there is a display; away from X11 and Wayland there always is."""
    return os.name == "nt" or os.uname().sysname == "Darwin" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


@contextmanager
def quiet_vtk() -> Iterator[None]:
    """Keep from stderr what VTK says while it looks for a way to draw without a display."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)
