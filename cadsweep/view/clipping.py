"""Half of a mesh: cut smoothly by a plane, or whole hexahedra behind it.

Place in the flow: between :mod:`.grid` and :mod:`.picture`.

A smooth cut is a polygon a hexahedron, so its lines are those of the mesh; whole hexahedra show their shapes. Neither
leaves anything of the half that is taken away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import HEX_EDGES
from ..errors import InputError
from ..mesh import HexMesh
from .grid import import_pyvista, skin, to_pyvista

Clip = str | tuple[Sequence[float], Sequence[float]]
"""An axis, ``"x"`` or ``"-x"``, through the middle of the mesh, or (normal, origin) of a plane.
What the normal points at is taken away."""


def kept_by_clip(mesh: HexMesh, clip: Clip) -> np.ndarray:
    """Which hexahedra (n_hexes,) lie behind a plane, judged by their middles.

    Raises
    ------
    InputError
        The clip is no axis and no plane.
    """
    normal, origin = clip_plane(mesh, clip)
    return (mesh.points[mesh.hexes[:, :8]].mean(axis=1) - origin) @ normal <= 0


def clip_plane(mesh: HexMesh, clip: Clip) -> tuple[FloatArray, FloatArray]:
    """The unit normal and a point of the plane that a clip means."""
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


def cut_skin(mesh: HexMesh, clip: Clip) -> tuple[Any, IntArray]:
    """Return what is seen of a mesh that a plane has cut: as :func:`.grid.skin` does, with polygons along the cut.

    Raises
    ------
    InputError
        The clip is no axis and no plane.
    """
    pv = import_pyvista()
    normal, origin = clip_plane(mesh, clip)
    outside, owners = skin(mesh)
    outside.cell_data["owner"] = owners
    outside = outside.clip(normal=normal, origin=origin)
    grid = to_pyvista(_first_order(mesh))
    grid.cell_data["owner"] = np.full(mesh.n_hexes, -1)
    grid.cell_data["hex"] = np.arange(mesh.n_hexes)
    inside = grid.slice(normal=normal, origin=origin, generate_triangles=False)
    for surface in (outside, inside):
        for name in set(surface.cell_data.keys()) - {"scaled_jacobian", "owner", "hex"}:
            del surface.cell_data[name]
        surface.point_data.clear()
        surface.field_data.clear()
    cut = pv.merge([outside, inside], merge_points=False) if inside.n_cells and outside.n_cells else outside
    cut = cut if isinstance(cut, pv.PolyData) else cut.extract_surface()
    return cut, np.asarray(cut.cell_data["owner"], dtype=np.int64)


def _first_order(mesh: HexMesh) -> HexMesh:
    return HexMesh(points=mesh.points, hexes=mesh.hexes[:, :8], boundaries={})


def left_of_rim(mesh: HexMesh, rim: IntArray, *, clip: Clip | None, kept: np.ndarray | None) -> Any:
    """The segments (m, 2) of a rim that the clip leaves, as lines; None where nothing is left.

    Parameters
    ----------
    kept : (n_hexes,) bool or None
        The hexahedra that are shown, whole; None: the plane cuts the lines.
    """
    pv = import_pyvista()
    if kept is not None:
        shown = np.sort(mesh.hexes[kept][:, HEX_EDGES].reshape(-1, 2), axis=1)
        ordered = np.sort(rim, axis=1)
        rim = rim[np.isin(ordered[:, 0] * mesh.n_nodes + ordered[:, 1], shown[:, 0] * mesh.n_nodes + shown[:, 1])]
    if not len(rim):
        return None
    lines = pv.PolyData(mesh.points, lines=np.column_stack([np.full(len(rim), 2), rim]).ravel())
    if clip is not None and kept is None:
        normal, origin = clip_plane(mesh, clip)
        lines = lines.clip(normal=normal, origin=origin)
    return lines if lines.n_cells else None
