"""The heights of wall layers kept from the source to the target, through bends, lofts and tapers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import FloatArray, IntArray
from ...mesh import SurfaceMesh, WallRows
from ...projection import FactoredSweep
from ...projection.caps import PlacedCap
from ...projection.residual import TOLERANCE, shortest_segment
from ...projection.wall_rows import carry_inwards, rows_at_heights
from ...sweep import Sweep

_CARRIED = 1e-3
"""Part of a first height that may be missed by the layers' factors."""
_SAME = 1e-4
"""Part of a first height below which nodes stay where they are."""


def on_caps(sweep: Sweep, surfaces: SurfaceMesh, target: PlacedCap) -> tuple[SurfaceMesh, PlacedCap]:
    """Put the rows on both caps at their heights; the rest of the caps follows."""
    source = surfaces.source
    points = _on_cap(sweep, surfaces, source.points, source.faces, 0)
    surfaces = replace(surfaces, source=replace(source, points=points))
    last = len(surfaces.rings) - 1
    return surfaces, replace(target, points=_on_cap(sweep, surfaces, target.points, target.faces, last))


def between_caps(sweep: Sweep, surfaces: SurfaceMesh, placed: FactoredSweep) -> tuple[IntArray, FloatArray] | None:
    """Row nodes (m,) and where they should be in every layer (n_layers + 1, m, 3); None where they are there."""
    source = surfaces.source
    nodes, places = [], []
    off = 0.0
    for rows in source.walls:
        present = np.asarray(placed.basis[rows.nodes.ravel()] @ placed.coefficients)
        present = present.reshape(len(placed.rings), *rows.nodes.shape, 3)
        present[0] = source.points[rows.nodes]
        if placed.target_points is not None:
            present[-1] = placed.target_points[rows.nodes]
        base = surfaces.rings[:, rows.ring]
        beside, normals = beside_columns(surfaces, rows), wall_normals(sweep, surfaces, rows)
        wanted = rows_at_heights(present, (base, beside, normals), rows, _lengths(present[0], base[0]))
        wanted[0], wanted[-1] = present[0], present[-1]
        off = max(off, float((np.linalg.norm(wanted - present, axis=-1) / rows.first[None, :, None]).max()))
        nodes.append(rows.nodes.ravel())
        places.append(wanted.reshape(len(wanted), -1, 3))
    if off <= _SAME:
        return None
    return np.concatenate(nodes), np.concatenate(places, axis=1)


def beside_columns(surfaces: SurfaceMesh, rows: WallRows, layers: IntArray | None = None) -> FloatArray:
    """Ring nodes (k, c, 2, 3) before and behind those at which columns begin."""
    rings = surfaces.rings if layers is None else surfaces.rings[layers]
    return np.stack(
        [rings[:, _neighbours(surfaces, 1)[rows.ring]], rings[:, _neighbours(surfaces, -1)[rows.ring]]], axis=2
    )


def wall_normals(sweep: Sweep, surfaces: SurfaceMesh, rows: WallRows, layers: IntArray | None = None) -> FloatArray:
    """Normals of the walls into the solid at the ring nodes of columns, (k, c, 2, 3): of the faces on both sides."""
    n_layers = len(surfaces.side_faces)
    chosen = np.arange(n_layers + 1) if layers is None else layers
    before = _neighbours(surfaces, 1)
    above, below = np.minimum(chosen, n_layers - 1), np.maximum(chosen - 1, 0)
    walls = np.array(sorted(rows.faces))
    out = np.full((len(chosen), len(rows.ring), 2, 3), np.nan)
    points = surfaces.rings[chosen][:, rows.ring]
    for side, segments in enumerate((before[rows.ring], rows.ring)):
        upper = surfaces.side_faces[above][:, segments]
        faces = np.where(np.isin(upper, walls), upper, surfaces.side_faces[below][:, segments])
        for f in walls.tolist():
            here = faces == f
            if here.any():
                surface = sweep.solid.faces[f].surface
                out[..., side, :][here] = -surface.normals(surface.project(points[here]))
    return out


def _on_cap(sweep: Sweep, surfaces: SurfaceMesh, points: FloatArray, faces: IntArray, layer: int) -> FloatArray:
    source = surfaces.source
    nodes, places, off = [], [], 0.0
    for rows in source.walls:
        own = _lengths(source.points[rows.nodes], surfaces.rings[0, rows.ring])
        present, base = points[rows.nodes][None], surfaces.rings[layer, rows.ring][None]
        only = np.array([layer])
        beside, normals = beside_columns(surfaces, rows, only), wall_normals(sweep, surfaces, rows, only)
        wanted = rows_at_heights(present, (base, beside, normals), rows, own)
        off = max(off, float((np.linalg.norm(wanted - present, axis=-1) / rows.first[None, :, None]).max()))
        nodes.append(rows.nodes.ravel())
        places.append(wanted[0].reshape(-1, 3))
    if off <= _SAME:
        return points
    moved, where = np.concatenate(nodes), np.concatenate(places)
    edges = list(source.edge_nodes.values())
    fixed = np.setdiff1d(np.unique(np.concatenate([_ring(surfaces), *edges])), moved)
    out = carry_inwards(points, source.quads, fixed, moved, where)
    for f in np.unique(faces).tolist():
        own_nodes = np.setdiff1d(np.unique(source.quads[faces == f]), fixed)
        surface = sweep.solid.faces[f].surface
        out[own_nodes] = surface.evaluate(surface.project(out[own_nodes]))
    return out


def row_tolerance(surfaces: SurfaceMesh) -> float:
    """What need not be carried of rows, as a fraction of the shortest ring segment: a little of a first height."""
    rings, loops = surfaces.rings, surfaces.source.loops
    first = min(float(rows.first.min()) for rows in surfaces.source.walls)
    return min(TOLERANCE, _CARRIED * first / shortest_segment(rings, loops))


def _ring(surfaces: SurfaceMesh) -> IntArray:
    return np.concatenate(surfaces.source.loops)


def _neighbours(surfaces: SurfaceMesh, turn: int) -> IntArray:
    """Place on the ring of the node before each (`turn` 1), or behind it (-1), in its loop."""
    sizes = [len(loop) for loop in surfaces.source.loops]
    starts = np.cumsum([0, *sizes[:-1]])
    return np.concatenate([np.roll(np.arange(n), turn) + start for n, start in zip(sizes, starts, strict=True)])


def _lengths(rows: FloatArray, base: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(rows[:, -1] - base, axis=-1))
