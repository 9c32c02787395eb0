"""Meshes as pyvista objects: the grid, its skin, its boundaries, and what a clip keeps.

A clip keeps whole hexahedra behind a plane, so that what is seen inside is the mesh and not a cut through it.
Boundaries are the quads that the mesh names, not guessed from angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import CadSweepError, InputError
from ..libraries import explain_import_error
from ..mesh import HexMesh
from ..quality import scaled_jacobians

_VTK_TYPES = {8: 12, 20: 25, 27: 29}

Clip = str | tuple[Sequence[float], Sequence[float]]
"""An axis, ``"x"`` or ``"-x"``, through the middle of the mesh, or (normal, origin) of a plane.
What the normal points at is taken away."""


def import_pyvista() -> Any:
    """Import pyvista, or say how to get it."""
    try:
        import pyvista
    except (ImportError, OSError) as error:
        text = explain_import_error("pyvista, which draws pictures,", error, distribution='"cadsweep[view]"')
        raise CadSweepError(text) from error
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
    pv = import_pyvista()
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
    pv = import_pyvista()
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
        Boundary that each quad belongs to, the smallest of several, as an index into ``mesh.boundaries``; -1 inside
        the mesh.
    """
    pv = import_pyvista()
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

    ids = np.arange(mesh.n_hexes) if kept is None else np.flatnonzero(kept)
    corners = mesh.hexes[ids, :8]
    cells = np.column_stack([np.full(len(ids), 8), corners]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(len(ids), _VTK_TYPES[8], dtype=np.uint8), mesh.points)
    grid.cell_data["hex"] = ids
    grid.cell_data["scaled_jacobian"] = scaled_jacobians(mesh.points, corners)
    grid.point_data["node"] = np.arange(mesh.n_nodes)
    geometry = vtkGeometryFilter()  # pyvista's own name for it changes from version to version
    geometry.SetInputData(grid)
    geometry.Update()
    surface = pv.wrap(geometry.GetOutput())
    seen = np.sort(surface.point_data["node"][surface.regular_faces], axis=1)
    owners = np.full(len(seen), -1, dtype=np.int64)
    if mesh.boundaries:
        named = np.concatenate([quads[:, :4] for quads in mesh.boundaries.values()])
        sizes = np.array([len(quads) for quads in mesh.boundaries.values()])
        names = np.repeat(np.arange(len(sizes)), sizes)
        small_last = np.argsort(-sizes[names], kind="stable")  # of boundaries that overlap the smallest is seen
        named, names = named[small_last], names[small_last]
        _, inverse = np.unique(np.concatenate([np.sort(named, axis=1), seen]), axis=0, return_inverse=True)
        inverse = inverse.reshape(-1)  # numpy 2.0 alone gives it a second axis
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


def boundary_colors(n: int) -> list[str]:
    """Return n colours that differ in hue, and from one turn of the hues to the next in lightness."""
    from colorsys import hls_to_rgb

    golden = 0.618033988749895  # neighbours in the list lie far apart on the circle of hues
    tones = [hls_to_rgb((0.58 + i * golden) % 1, (0.45, 0.6, 0.32)[i // 8 % 3], 0.75) for i in range(n)]
    return ["#" + "".join(f"{round(255 * c):02x}" for c in tone) for tone in tones]


def mesh_colors(mesh: HexMesh) -> list[str]:
    """Return a colour for every boundary: that of its CAD face, or where it has none one unlike those."""
    cad = mesh.info.get("colors", {}).get("boundaries", {})
    given = {_rgb(color) for color in cad.values()}
    n = len(mesh.boundaries)
    # Of more colours than are needed those too near to a colour of the model are left out.
    spare = boundary_colors(n + 8 * len(given))
    apart = [c for c in spare if all(sum(abs(a - b) for a, b in zip(_rgb(c), g, strict=True)) > 90 for g in given)]
    others = iter(apart if len(apart) >= n else spare)
    return [cad[name][:7] if name in cad else next(others) for name in mesh.boundaries]


def part_colors(mesh: HexMesh) -> list[str]:
    """Return a colour for every part: that of its solid, or where it has none one unlike those before."""
    cad = mesh.info.get("colors", {}).get("parts", {})
    spare = boundary_colors(len(mesh.parts))
    return [cad[name][:7] if name in cad else color for name, color in zip(mesh.parts, spare, strict=True)]


def cad_colors(mesh: HexMesh, plain: str) -> list[str]:
    """Return the colours that the CAD model shows: of its faces, else of the part, else `plain`.

    The last one is that of what belongs to no boundary.
    """
    colors = mesh.info.get("colors", {})
    whole = next(iter(colors.get("parts", {}).values()), plain)
    return [colors.get("boundaries", {}).get(name, whole)[:7] for name in mesh.boundaries] + [plain]


def legible(color: str) -> str:
    """A colour that can be read on white: light ones are darkened."""
    red, green, blue = _rgb(color)
    lightness = (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255
    share = min(1.0, 0.65 / lightness) if lightness else 1.0
    return "#" + "".join(f"{round(share * c):02x}" for c in (red, green, blue))


def _rgb(color: str) -> tuple[int, ...]:
    return tuple(int(color[i : i + 2], 16) for i in (1, 3, 5))
