"""The cells of a part meshed one after another on one skeleton: what is shared exists once.

Follows a :class:`~cadsweep.plan.Plan`: counts of all edges, nodes on edges, grids, then cell by cell in the plan's
order the caps and the inside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from ... import estimate
from ...arrays import IntArray
from ...blocks.cells import CellBlocks, FilledCell, SweptCell, number_blocks
from ...brep import Part
from ...corner_blocks import CornerBlocks
from ...errors import CadSweepError, ProjectionError, SurfaceMeshError
from ...intervals import Wishes, assign_shared_intervals, cell_sizes
from ...options import SweepOptions
from ...plan import Plan
from ...projection import project_layers
from ...projection.caps import PlacedCap, place_target
from ...surface import (
    CellBoundary,
    Division,
    Memory,
    Rings,
    Skeleton,
    boundary_of,
    lay_star,
    match_quads,
    opposite_angles,
    surface_mesh,
    turn_grid,
)
from ...sweep import Intervals, Sweep
from ..nearness.cap_sizes import InsideSizes
from ..nearness.nearer import MOST_HALVINGS
from ..run import Run
from ..wishes.biases import say_graded
from ..wishes.cell_asks import resolve_asks
from ..wishes.wall_heights import between_caps, on_caps, row_tolerance
from .corner_cells import fill_corners
from .laying import cell_sweeps, fractions_of, rails_of, rings_of_cells, sizes_on_sources


def mesh_cells(  # noqa: PLR0917
    part: Part,
    plan: Plan,
    options: SweepOptions,
    run: Run,
    wishes: Wishes,
    model: Part,
    inside: InsideSizes | None = None,
    uneven: Mapping[int, Division] | None = None,
) -> tuple[CellBlocks, list[Intervals], list[str]]:
    """Mesh all cells of a part conformally; `model` is the part before it was cut, as its user knows it.

    `inside`: wanted lengths (m,) at points (m, 3) of caps, and `uneven`: how edges divide themselves, by key, besides
    what the user asks for.

    Returns
    -------
    mesh : CellBlocks
    counts : list of Intervals
        By cell.
    notes : list of str

    Raises
    ------
    InputError
        The sizes ask for more hexahedra than may be made.
    SurfaceMeshError, ProjectionError
        A face or a layer of some cell cannot be meshed.
    """
    cells = cell_sweeps(part, plan)
    asks = resolve_asks(part, model, plan, cells, options, wishes)
    wishes = asks.wishes
    divisions = {**rails_of(part, plan, options, asks), **(uneven or {}), **asks.divisions}
    asked = wishes
    expected = expected_cells(part, plan, wishes, streamed=run.in_blocks)  # a size that is a slip is refused at once
    run.checks(expected, options)
    memory = Memory()
    for halving in range(1 + MOST_HALVINGS):
        with run.stage("intervals"):
            counts = assign_shared_intervals(cells, wishes)
        with run.stage("surface"):
            fractions = fractions_of(part, cells, counts, divisions, wishes.alike)
            rings = rings_of_cells(part, plan, counts, options, divisions, fractions, asks)
            skeleton = Skeleton(
                part.solids,
                counts,
                fractions=fractions,
                rings=rings,
                sizes=sizes_on_sources(plan, asks.field, inside),
                partners=asks.partners,
                walls=asks.walls.layers,
                memory=memory,
            )
            for cell, way in enumerate(plan.ways):
                for side in way.grids.values():
                    skeleton.lay_grid(cell, side)
            sheets = {
                cell: _lay_stars(skeleton, cell, way.fill, counts[cell])
                for cell, way in enumerate(plan.ways)
                if isinstance(way.fill, CornerBlocks)
            }
        builder = _Builder(part, skeleton, options, run, rings)
        shorter: dict[int, float] = {}
        for done, cell in enumerate(plan.order):
            try:
                fill = plan.ways[cell].fill
                if isinstance(fill, CornerBlocks):
                    builder.add_corners(cell, fill, sheets[cell])
                else:
                    builder.add(cell, fill)
            except (SurfaceMeshError, ProjectionError) as error:
                edges = error.edges if isinstance(error, SurfaceMeshError) else ()
                shorter = _halved(part, cell, counts[cell], edges, asked)
                if not shorter or halving == MOST_HALVINGS:
                    raise _of_solid(part, cell, error) from error
                break
            run.on_progress("cells", (done + 1) / len(plan.order))
        if not shorter:
            break
        wishes = replace(wishes, edge_sizes={**wishes.edge_sizes, **shorter})
    n_finer = len(wishes.edge_sizes) - len(asked.edge_sizes)
    finer = [f"{n_finer} edges at narrow places divided finer than their size asks"] if n_finer else []
    single = say_graded(divisions, asks.biased, {key: len(nodes) - 1 for key, nodes in skeleton.edges.items()})
    said = [note for way in plan.ways if isinstance(way.fill, Sweep) for note in way.fill.notes]
    return builder.built(), counts, [*said, *finer, *single, *dict.fromkeys(asks.walls.notes), *skeleton.notes]


def _of_solid(part: Part, cell: int, error: CadSweepError) -> CadSweepError:
    """The same error, with the solid that it is about."""
    name = part.models[part.owners[cell]].name
    found = copy(error)
    found.solids = (name,)
    if len(part.models) > 1:
        found.args = (f"'{name}': {error.what}",)
    return found


def expected_cells(part: Part, plan: Plan, wishes: Wishes, *, streamed: bool = False) -> estimate.Estimate:
    """What the mesh of all cells will be, before anything is made of it."""
    cells = cell_sweeps(part, plan)
    return estimate.estimate_cells(
        [cell.fill for cell in cells],
        cell_sizes(cells, wishes),
        layers=wishes.layers,
        edge_sizes=wishes.edge_sizes,
        edge_counts={own.keys: own.count for own in wishes.demands},
        scale=part.scale,
        streamed=streamed,
    )


def _halved(part: Part, cell: int, counts: Intervals, edges: Sequence[int], asked: Wishes) -> dict[int, float]:
    """Sizes that make the segments of a cell's edges half as long, by key; not of those the user spoke of."""
    solid = part.solids[cell]
    spoken = {key for demand in asked.demands for key in demand.keys} | set(asked.edge_sizes)
    sizes = {int(solid.edge_keys[e]): solid.edges[e].length / (2 * int(counts.counts[e])) for e in edges}
    return {key: size for key, size in sizes.items() if key not in spoken}


def _lay_stars(skeleton: Skeleton, cell: int, blocks: CornerBlocks, counts: Intervals) -> IntArray:
    """Mesh the faces of a cell of corner blocks that are no grids; how thick its sheets are."""
    sheets = blocks.sheets([sum(int(counts.counts[e]) for e, _ in chain) for chain in blocks.chains])
    for face in blocks.stars:
        lay_star(skeleton, cell, blocks, face, sheets)
    return sheets


class _Builder:
    """Collects hexahedra and boundary quads cell by cell."""

    def __init__(
        self,
        part: Part,
        skeleton: Skeleton,
        options: SweepOptions,
        run: Run,
        rings: Mapping[int, Rings],
    ) -> None:
        self.ends = {cell: own.layout.labels()[2][[0, -1]] for cell, own in rings.items()}
        self.part = part
        self.skeleton = skeleton
        self.options = options
        self.run = run
        self.cells: list[SweptCell | FilledCell] = []
        self.quads: list[tuple[int, IntArray, IntArray]] = []
        self.roles: dict[tuple[int, int], str] = {}

    def add(self, cell: int, sweep: Sweep) -> None:
        """Mesh one cell: caps, target, inside."""
        with self.run.stage("surface"):
            ends = self.ends.get(cell)
            self.skeleton.lay_source(cell, sweep, None if ends is None else opposite_angles(sweep, ends))
            boundary = boundary_of(self.skeleton, cell, sweep)
        with self.run.stage("projection"):
            self.fill(cell, sweep, boundary)

    def add_corners(self, cell: int, blocks: CornerBlocks, sheets: IntArray) -> None:
        """Mesh one cell that has a block at every corner."""
        with self.run.stage("projection"):
            hexes, quads, faces = fill_corners(self.skeleton, cell, blocks, sheets)
        self.cells.append(FilledCell(cell=cell, hexes=hexes))
        self.take(cell, "side", quads, faces)

    def fill(self, cell: int, sweep: Sweep, boundary: CellBoundary) -> None:
        """Carry the source to the target and place the layers between them."""
        skeleton, source, rings = self.skeleton, boundary.source, boundary.rings
        keys = self.part.solids[cell].face_keys
        surfaces = surface_mesh(boundary, skeleton, cell, sweep)
        meshed = [int(keys[f]) in skeleton.faces for f in sweep.target]
        if all(meshed):
            ends, faces = self.landed(cell, sweep, boundary)
        elif any(meshed):
            label = sweep.solid.faces[sweep.target[meshed.index(True)]].label()
            raise SurfaceMeshError(f"{label} of the target is meshed before the rest of the cap is")
        else:
            cap = place_target(sweep, surfaces)
            if source.walls:
                surfaces, cap = on_caps(sweep, surfaces, cap)
                source = surfaces.source
                skeleton.move(boundary.nodes, source.points)
            ends, faces = self.carried(cell, sweep, boundary, cap), cap.faces
            skeleton.notes += cap.notes
        place = partial(
            project_layers,
            source.points,
            source.quads,
            surfaces.rings,
            loops=source.loops,
            functional=self.options.functional,
            strategy=self.options.strategy,
            target_points=skeleton.points[ends],
            residual=self.options.residual,
        )
        placed = place()
        known = between_caps(sweep, surfaces, placed) if source.walls else None
        if known is not None:
            placed = place(known=known, residual_tolerance=row_tolerance(surfaces))
        kept = np.concatenate([np.empty(0, dtype=np.int64), *(rows.nodes.ravel() for rows in source.walls)])
        assert rings.shape[1] == len(placed.ring_nodes), "the loops are the ring"
        self.cells.append(
            SweptCell(
                cell=cell,
                sweep=placed,
                bottom=boundary.nodes,
                top=ends,
                rings=rings,
                after=skeleton.n_nodes,
                kept=kept,
            )
        )
        starts = np.cumsum([0, *(len(loop) for loop in source.loops)])
        following = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(starts)])
        sides = np.stack([rings[:-1], rings[:-1, following], rings[1:, following], rings[1:]], axis=-1)
        self.take(cell, "source", boundary.nodes[source.quads][:, ::-1], source.faces)
        self.take(cell, "target", ends[source.quads], faces)
        self.take(cell, "side", sides.reshape(-1, 4), surfaces.side_faces.reshape(-1))

    def take(self, cell: int, role: str, quads: IntArray, faces: IntArray) -> None:
        """Keep boundary quads, outward from their cell."""
        self.quads.append((cell, quads, faces))
        for face in np.unique(faces).tolist():
            self.roles[cell, face] = role

    def carried(self, cell: int, sweep: Sweep, boundary: CellBoundary, cap: PlacedCap) -> IntArray:
        """Number the nodes of a target cap that nobody has meshed, and keep its quads for the neighbours."""
        skeleton, source = self.skeleton, boundary.source
        keys = self.part.solids[cell]
        ends = np.full(len(boundary.nodes), -1, dtype=np.int64)
        for edge, (target, same) in sweep.target_edges.items():
            if edge in source.edge_nodes:
                own = skeleton.edges[int(keys.edge_keys[target])]
                ends[source.edge_nodes[edge]] = own if same else own[::-1]
        ends[np.concatenate(source.loops)] = boundary.rings[-1]
        new = np.flatnonzero(ends < 0)
        ends[new] = skeleton.add(cap.points[new])
        for face in sweep.target:
            skeleton.keep(cell, face, ends[source.quads[cap.faces == face]])
        return ends

    def landed(self, cell: int, sweep: Sweep, boundary: CellBoundary) -> tuple[IntArray, IntArray]:
        """Find the target's nodes under the source's, where both caps are meshed already."""
        skeleton, source = self.skeleton, boundary.source
        straight = self.landed_on_grid(cell, sweep, boundary)
        if straight is not None:
            return straight, np.full(len(source.quads), sweep.target[0], dtype=np.int64)
        quads = [skeleton.quads_of(cell, f) for f in sweep.target]
        known = dict(zip(np.concatenate(source.loops).tolist(), boundary.rings[-1].tolist(), strict=True))
        every = np.concatenate(quads)
        images = match_quads(source.quads, every, known)
        if images is None:
            label = sweep.solid.faces[sweep.target[0]].label()
            raise SurfaceMeshError(
                f"{sweep.solid.faces[sweep.source[0]].label()} and {label} are both meshed from elsewhere, and their "
                "quads do not answer each other"
            )
        ends = np.array([images[j] for j in range(len(boundary.nodes))], dtype=np.int64)
        owner = {tuple(sorted(q)): f for f, qs in zip(sweep.target, quads, strict=True) for q in qs.tolist()}
        faces = np.array([owner[tuple(sorted(q))] for q in ends[source.quads].tolist()], dtype=np.int64)
        return ends, faces

    def landed_on_grid(self, cell: int, sweep: Sweep, boundary: CellBoundary) -> IntArray | None:
        """The target's nodes under the source's where both caps are one grid each; None where not, or they differ."""
        if len(sweep.source) > 1 or len(sweep.target) > 1:
            return None
        keys = self.part.solids[cell].face_keys
        grid, other = (self.skeleton.faces[int(keys[f])].grid for f in (sweep.source[0], sweep.target[0]))
        if grid is None or other is None:
            return None
        below = dict(zip(boundary.rings[0].tolist(), boundary.rings[-1].tolist(), strict=True))
        corners = [below[node] for node in grid[[0, 0, -1, -1], [0, -1, 0, -1]].tolist()]
        images = turn_grid(other, np.array(corners).reshape(2, 2))
        if images is None or images.shape != grid.shape:
            return None
        order = np.argsort(boundary.nodes)
        ends = np.empty_like(boundary.nodes)
        ends[order[np.searchsorted(boundary.nodes, grid.ravel(), sorter=order)]] = images.ravel()
        return ends if np.array_equal(ends[: boundary.rings.shape[1]], boundary.rings[-1]) else None

    def built(self) -> CellBlocks:
        """All cells together."""
        numbers, firsts = number_blocks(self.skeleton.n_nodes, self.cells)
        cells = sorted(self.cells, key=lambda own: own.cell)
        quads = sorted(self.quads, key=lambda piece: piece[0])
        return CellBlocks(
            points=self.skeleton.points,
            cells=tuple(cells),
            firsts=tuple(firsts.get(own.cell, -1) for own in cells),
            numbers=numbers,
            quads=np.concatenate([own for _, own, _ in quads]),
            quad_cells=np.repeat([cell for cell, _, _ in quads], [len(own) for _, own, _ in quads]),
            quad_faces=np.concatenate([faces for _, _, faces in quads]),
            roles=self.roles,
            edge_nodes=self.skeleton.edges,
        )
