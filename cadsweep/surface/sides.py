"""Ring nodes on edges and linking sides.

Place in the flow: after ``layout`` and ``spacing``; gives the rings of ``mesh.SurfaceMesh``.

Method: rails first, by the layers' places; then the edges along the loops, which divide themselves
as the affine image of the source loop does (the map is fitted to the ring, the edge divided anew,
a few times); then the sides by transfinite interpolation. Last, the nodes of every row slide within
the row to where the image of the source's nodes wants them, their order kept.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..errors import SurfaceMeshError
from ..sweep import Sweep
from .spacing import Fit, divide_lengths, finer, image_lengths, rescaled
from .sweep_grid import PlacedEdge, PlacedSide, SweepGrid
from .transfinite import chain_fractions, fill, join_chains, worst_corner

_N_CHORDS = 16
"""Chords that stand for a curved edge's segment at most."""
_N_SAMPLES = 256
"""Chords a source segment is measured by at most, and about how many an edge needs: the image of an
ellipse is then divided to 1e-5 of a segment."""
_N_FITS = 3
"""Fits of a side's rows to its edges, each from where the last one ended."""
_SAME = 1e-12
"""Fraction of an edge by which none of its nodes moves, and it is not placed anew."""
_SLIDE_TOLERANCE = 1e-3
"""Part of a segment below which nodes of a row are left where they are."""


class RingBuilder:
    """Fills ``rings`` (n_layers + 1, b, 3) step by step."""

    def __init__(
        self,
        sweep: Sweep,
        layout: SweepGrid,
        places: FloatArray,
        fit: Fit,
        *,
        graded: Mapping[int, FloatArray] | None = None,
        fixed: Mapping[int, FloatArray] | None = None,
    ) -> None:
        """`graded`: fractions of edges of the source; `fixed`: of edges anywhere, which have them and no others."""
        self.sweep = sweep
        self.solid = sweep.solid
        self.layout = layout
        self.places = places
        self.fit = fit
        self.rings: FloatArray = np.full((layout.n_layers + 1, layout.n_ring, 3), np.nan)
        self.fractions: dict[int, FloatArray] = {}  # by edge, from the edge's start to its end
        self.chords = np.zeros((layout.n_ring, _N_CHORDS, 3))  # unused ones stay nought
        self.lengths = np.zeros(layout.n_ring)  # of the source loop's segments
        self.notes: list[str] = []
        self.fixed = fixed or {}
        self.graded = {**(graded or {}), **self.fixed}

    def build(self) -> None:
        """Place every ring node."""
        for placed in self.layout.edges.values():
            if placed.edge in self.fixed:
                self._set_graded(placed)
                if placed.along_loop and placed.layer == 0:
                    self._measure_chords(placed)
            elif not placed.along_loop:
                places = self.places[placed.loop, placed.layer : placed.layer + placed.n_segments + 1]
                self._set_edge(placed, rescaled(places))
            elif placed.layer == 0:
                if placed.edge in self.graded:
                    self._set_graded(placed)
                else:
                    self._set_edge(placed, np.linspace(0.0, 1.0, placed.n_segments + 1))
                self._measure_chords(placed)
        moving = [p for p in self.layout.edges.values() if p.along_loop and p.layer > 0]
        self.lengths = image_lengths(self.chords, np.eye(3)[None])[0]
        self._divide(moving, {})
        self._place_vertices()
        n_edges = self._divide_complete_rings(moving)
        blocks = [self._fill_side(placed) for placed in self.layout.sides]
        if n_edges < len(moving):
            # Edges of columns that share no closed ring of edges: their layers are known only now.
            self._divide_as_images(moving)
            blocks = [self._fill_side(placed) for placed in self.layout.sides]
        self._slide_rows(blocks)

    def _set_graded(self, placed: PlacedEdge) -> None:
        fractions = self.graded[placed.edge]
        self._set_edge(placed, fractions if placed.forward else 1.0 - fractions[::-1])

    def _set_edge(self, placed: PlacedEdge, along: FloatArray) -> None:
        """Place an edge's nodes at arc-length fractions given in its placed direction."""
        fractions = along if placed.forward else (1.0 - along)[::-1]
        self.fractions[placed.edge] = fractions
        edge = self.solid.edges[placed.edge]
        points = np.array(edge.curve.evaluate(fractions))
        points[0], points[-1] = self.solid.vertices[edge.start], self.solid.vertices[edge.end]
        self.rings[self.layout.nodes(placed)] = points if placed.forward else points[::-1]

    def _measure_chords(self, placed: PlacedEdge) -> None:
        n = placed.n_segments
        edge = self.solid.edges[placed.edge]
        m = 1 if edge.kind == "line" else int(np.clip(np.ceil(_N_SAMPLES / n), 1, _N_CHORDS))
        points = edge.curve.evaluate(finer(self.fractions[placed.edge], m))
        chords = np.diff(points if placed.forward else points[::-1], axis=0)
        self.chords[self.layout.columns(placed.loop, placed.column, n), :m] = chords.reshape(n, m, 3)

    def _divide_as_images(self, edges: list[PlacedEdge]) -> None:
        """Divide edges as the images of the source loop's segments on their layers divide themselves."""
        layers = sorted({placed.layer for placed in edges})
        linear = self.fit(self.rings[0], self.rings[layers])
        self._divide(edges, dict(zip(layers, image_lengths(self.chords, linear), strict=True)))
        self._place_vertices()

    def _divide(self, edges: list[PlacedEdge], images: Mapping[int, FloatArray]) -> None:
        """Divide edges as lengths of images (n_ring,) go, by layer; as the source loop's own where none are given."""
        by_count: dict[int, list[PlacedEdge]] = {}
        for placed in edges:
            if placed.edge not in self.fixed:
                by_count.setdefault(placed.n_segments, []).append(placed)
        for n, own in by_count.items():  # of one count all at once: a gear has hundreds of edges
            columns = np.array([self.layout.columns(placed.loop, placed.column, n) for placed in own])
            wanted = np.array([images.get(p.layer, self.lengths)[c] for p, c in zip(own, columns, strict=True)])
            for placed, along in zip(own, divide_lengths(self.lengths[columns], wanted), strict=True):
                fractions = along if placed.forward else (1.0 - along)[::-1]
                known = self.fractions.get(placed.edge)
                if known is None or np.abs(fractions - known).max() >= _SAME:
                    self._set_edge(placed, along)

    def _place_vertices(self) -> None:
        for vertex, (column, layer) in self.layout.vertices.items():
            self.rings[layer, column] = self.solid.vertices[vertex]

    def _divide_complete_rings(self, moving: list[PlacedEdge]) -> int:
        """Divide the edges of rings that consist of edges alone; returns how many edges these are."""
        by_layer: dict[int, list[PlacedEdge]] = {}
        for placed in moving:
            by_layer.setdefault(placed.layer, []).append(placed)
        n_ring = self.layout.n_ring
        complete = {k: edges for k, edges in by_layer.items() if sum(p.n_segments for p in edges) == n_ring}
        found = [placed for edges in complete.values() for placed in edges]
        for _ in range(_N_FITS if found else 0):
            self._divide_as_images(found)
        return len(found)

    def _fill_side(self, placed: PlacedSide) -> FloatArray:
        """Fill a side; returns its parameters (h + 1, w + 1, 2)."""
        side, face = placed.side, self.solid.faces[placed.side.face]
        block = self.layout.block(placed)
        grid = self.rings[block]
        chains = (grid[0], grid[:, -1], grid[-1], grid[:, 0])
        chains_uv = tuple(
            join_chains([face.surface.edge_uv(e, self.fractions[e])[:: 1 if forward else -1] for e, forward in chain])
            for chain in (side.bottom, side.right, side.top, side.left)
        )
        points, uv, worst = fill(face.surface, chains_uv, chains)
        if worst <= 0:
            self.notes.append(f"{face.label()}: its quads are folded at the worst corner (sine {worst:.2g})")
        if not np.isfinite(points).all():
            raise SurfaceMeshError(f"{face.label()} could not be filled: its surface gives no finite points")
        self.rings[block] = points
        return uv

    def _slide_rows(self, blocks: list[FloatArray]) -> None:
        """Slide nodes within the rows of every side towards the image of the source's nodes."""
        if self.layout.n_layers < 2:
            return
        linear = self.fit(self.rings[0], self.rings)
        successors = np.concatenate([self.layout.columns(j, 1, n) for j, n in enumerate(self.layout.loop_sizes)])
        chords = (self.rings[0, successors] - self.rings[0])[:, None]
        lengths = image_lengths(chords, np.eye(3)[None])[0]
        images = image_lengths(chords, linear)
        for placed, uv in zip(self.layout.sides, blocks, strict=True):
            if placed.height < 2 or placed.width < 2:
                continue
            block = self.layout.block(placed)
            columns = block[1][0, :-1]
            wanted = divide_lengths(lengths[columns], images[block[0], columns[None]])
            grid = self.rings[block]
            slid = slide_rows(grid, wanted)
            if slid is None:
                continue
            self._accept_slide(placed, grid, uv, _interpolate_rows(uv, *slid))

    def _accept_slide(self, placed: PlacedSide, grid: FloatArray, before: FloatArray, uv: FloatArray) -> None:
        surface = self.solid.faces[placed.side.face].surface
        new = grid.copy()
        inside = uv[1:-1, 1:-1]
        new[1:-1, 1:-1] = surface.evaluate(inside.reshape(-1, 2)).reshape(*inside.shape[:2], 3)
        normals = surface.normals(uv.reshape(-1, 2)).reshape(grid.shape)
        # A slide that hurts the side itself is not worth what it brings inside.
        if worst_corner(new, normals, uv) >= min(0.3, 0.9 * worst_corner(grid, normals, before)):
            self.rings[self.layout.block(placed)] = new


def slide_rows(grid: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Where along its row each node of a grid should stand.

    The borders stay: what bottom and top differ from their `wanted` fractions fades into the rows
    between them.

    Parameters
    ----------
    grid : (h + 1, w + 1, 3) float64
    wanted : (h + 1, w + 1) float64
        Fractions along each row, as the source's image divides it.

    Returns
    -------
    present, new : (h + 1, w + 1) float64, or None where no node has to move
    """
    steps = np.linalg.norm(np.diff(grid, axis=1), axis=2)
    total = steps.sum(axis=1, keepdims=True)
    if (total == 0).any():
        return None
    present = np.concatenate([np.zeros((len(grid), 1)), np.cumsum(steps, axis=1)], axis=1) / total
    present[:, -1] = 1.0
    height = chain_fractions(grid[:, grid.shape[1] // 2])[:, None]
    new = wanted + (1 - height) * (present[0] - wanted[0]) + height * (present[-1] - wanted[-1])
    new[0], new[-1] = present[0], present[-1]
    # Order kept: no segment of the row falls below a quarter of what the source's image gives it.
    least = 0.25 * np.minimum(np.diff(wanted, axis=1), np.diff(present, axis=1))
    widths = np.maximum(np.diff(new, axis=1), least)
    new[:, 1:] = np.cumsum(widths, axis=1) / widths.sum(axis=1, keepdims=True)
    new[:, 0], new[:, -1] = 0.0, 1.0
    if np.abs(new - present).max() <= _SLIDE_TOLERANCE / steps.shape[1]:
        return None
    return present, new


def _interpolate_rows(values: FloatArray, present: FloatArray, new: FloatArray) -> FloatArray:
    """Cubic interpolation of rows (h + 1, w + 1, d) from their fractions `present` to `new`."""
    h, w = present.shape
    shift = 2.0 * np.arange(h)[:, None]
    flat = (present + shift).ravel()
    index = np.searchsorted(flat, (new + shift).ravel(), side="right").reshape(h, w) - 1
    index = np.clip(index - np.arange(h)[:, None] * w, 0, w - 2)
    slopes = _row_slopes(values, present)
    rows = np.arange(h)[:, None]
    start, end = present[rows, index], present[rows, index + 1]
    step = np.where(end > start, end - start, 1.0)
    t = ((new - start) / step)[..., None]
    step = step[..., None]
    a, b = values[rows, index], values[rows, index + 1]
    da, db = slopes[rows, index] * step, slopes[rows, index + 1] * step
    out = (1 + 2 * t) * (1 - t) ** 2 * a + t * (1 - t) ** 2 * da + t**2 * (3 - 2 * t) * b + t**2 * (t - 1) * db
    out[:, 0], out[:, -1] = values[:, 0], values[:, -1]
    return out


def _row_slopes(values: FloatArray, present: FloatArray) -> FloatArray:
    """Slopes at the nodes of rows: of the parabola through three nodes, one-sided at the ends."""
    step = np.diff(present, axis=1)[..., None]
    step = np.where(step > 0, step, 1e-300)
    chord = np.diff(values, axis=1) / step
    slopes = np.empty_like(values)
    before, after = step[:, :-1], step[:, 1:]
    slopes[:, 1:-1] = (after * chord[:, :-1] + before * chord[:, 1:]) / (before + after)
    slopes[:, 0], slopes[:, -1] = chord[:, 0], chord[:, -1]
    return slopes
