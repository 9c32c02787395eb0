"""What a mesh will cost, from lengths and areas of the CAD alone, before any of it is made.

Place in the flow: before and after ``intervals``. A wanted size of 1e-9 would keep the integer programme
or gmsh busy for hours before it fails; here it is refused in microseconds, with the figures and the size
that would fit.

Method: a cap of area A meshed at size h has about A / h^2 quads; layers times quads are the hexes. Bytes
and seconds are measured rates per hex, stated below; they are estimates within a factor of two or so.

Not handled: quads that the mesher makes smaller than asked for, next to small edges.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from .corner_blocks import CornerBlocks
from .machine import GIGABYTE
from .sweep import Intervals, Sweep

BYTES_PER_HEX = 400
"""Peak memory for a hexahedron: points, connectivity, boundaries, checks, the written bytes."""

BYTES_PER_QUAD = 3000
"""Peak memory for a quad of the source cap: gmsh's own structures and the sparse factorisation."""

BASE_BYTES = 600e6
"""Python with OpenCASCADE, gmsh and numba, before any mesh."""

SECONDS_PER_HEX = 1.5e-6
"""About what placing, connecting and checking take on one core."""
SECONDS_PER_QUAD = 1e-4
"""About what gmsh's quads take."""

LARGEST_COUNT = 10**60
"""Counts beyond are all the same: too many."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a mesh is expected to be and to cost.

    Attributes
    ----------
    n_quads : int
        Quads on the source cap.
    n_layers : int
    n_hexes : int
    n_bytes : int
        Memory at the peak of the work.
    seconds : float
        Time on one ordinary core.
    size : float
        The edge length that the figures are for, model units.
    largest : float
        Size of the whole part, model units: no edge length beyond makes sense.
    layers_follow : bool
        The number of layers comes from the size, and falls where that grows.
    streamed : bool
        The mesh is written slab by slab; only the cap and one slab are in memory.
    """

    n_quads: int
    n_layers: int
    n_hexes: int
    n_bytes: int
    seconds: float
    size: float
    largest: float = math.inf
    layers_follow: bool = False
    streamed: bool = False

    @property
    def told(self) -> str:
        """What a user wants to know of it."""
        seconds = max(1, round(self.seconds))
        return f"about {say_count(self.n_hexes)} hexahedra, {self.n_bytes / GIGABYTE:.1f} GB, {_time(seconds)}"

    def __str__(self) -> str:
        made_of = f"{say_count(self.n_quads)} quads x {say_count(self.n_layers)} layers"
        cost = f"{say_memory(self.n_bytes)}, {_time(self.seconds)}"
        return f"about {say_count(self.n_hexes)} hexes ({made_of}), {cost}"


def estimate(sweep: Sweep, intervals: Intervals, *, scale: float = 1.0, streamed: bool = False) -> Estimate:
    """Estimate the cost of a sweep whose intervals are known.

    Parameters
    ----------
    scale : float
        Model units per working unit.
    streamed : bool
        See `Estimate.streamed`.
    """
    n_edges = sum(int(intervals.counts[edge]) for loop in sweep.source_loops for edge, _ in loop)
    return _from_counts(sweep, intervals.size, intervals.n_layers, n_edges, scale=scale, streamed=streamed)


def estimate_counted(expected: Estimate, n_quads: int, n_hexes: int, *, streamed: bool = False) -> Estimate:
    """The same estimate of a mesh whose quads on caps and hexahedra are counted."""
    return replace(
        expected,
        n_quads=n_quads,
        n_layers=max(1, n_hexes // max(1, n_quads)),
        n_hexes=n_hexes,
        n_bytes=int(peak_bytes(n_quads, n_hexes, streamed)),
        seconds=1.0 + SECONDS_PER_QUAD * n_quads + SECONDS_PER_HEX * n_hexes,
    )


def estimate_size(
    sweep: Sweep,
    *,
    size: float | None = None,
    layers: int | None = None,
    edge_sizes: Mapping[int, float] | None = None,
    edge_counts: Mapping[tuple[int, ...], int] | None = None,
    scale: float = 1.0,
    streamed: bool = False,
) -> Estimate | None:
    """Estimate the cost of a sweep from what the user asks for, before intervals are assigned.

    Parameters
    ----------
    size : float or None
        Wanted edge length, working units.
    layers : int or None
    edge_sizes : mapping of int to float, optional
        Wanted edge length of single edges, working units.
    edge_counts : mapping of tuple of int to int, optional
        Demanded segments of edges together.

    Returns
    -------
    Estimate or None
        None where nothing was asked for: the defaults are always modest.
    """
    if size is None and layers is None and not edge_sizes and not edge_counts:
        return None
    area = _cap_area(sweep)
    if size is None:
        size = math.sqrt(area / 100.0)
    n_edges, n_rail = _asked_of_edges(sweep, edge_sizes or {}, edge_counts or {})
    by_size = max(1, _bounded(_sweep_length(sweep) / size))
    follow = layers is None and n_rail < by_size
    if layers is None:
        layers = max(n_rail, by_size)
    expected = _from_counts(sweep, size, layers, n_edges, scale=scale, streamed=streamed)
    return replace(expected, layers_follow=follow)


def estimate_cells(
    fills: Sequence[Sweep | CornerBlocks],
    sizes: Sequence[float],
    *,
    layers: int | None = None,
    edge_sizes: Mapping[int, float] | None = None,
    edge_counts: Mapping[tuple[int, ...], int] | None = None,
    scale: float = 1.0,
    streamed: bool = False,
) -> Estimate:
    """Estimate the cost of a part of several cells, before their intervals are assigned.

    Parameters
    ----------
    fills : sequence of Sweep or CornerBlocks
        By cell.
    sizes : sequence of float
        Edge length wanted in each, working units.
    layers : int or None
        Layers of every cell; None: as its size asks for.
    edge_sizes, edge_counts : mapping
        As of :func:`estimate_size`, by keys of edges.
    scale : float
        Model units per working unit.
    streamed : bool
        See `Estimate.streamed`.
    """
    cells = [
        _of_corners(fill, size, scale=scale)
        if isinstance(fill, CornerBlocks)
        else _of_sweep(fill, size, layers, edge_sizes or {}, edge_counts or {}, scale=scale, streamed=streamed)
        for fill, size in zip(fills, sizes, strict=True)
    ]
    largest = max(cells, key=lambda cell: cell.n_hexes)
    n_quads, n_hexes = (sum(getattr(cell, what) for cell in cells) for what in ("n_quads", "n_hexes"))
    return replace(
        estimate_counted(largest, n_quads, n_hexes, streamed=streamed),
        largest=max(cell.largest for cell in cells),
        layers_follow=layers is None,
        streamed=streamed,
    )


def _of_sweep(
    sweep: Sweep,
    size: float,
    layers: int | None,
    edge_sizes: Mapping[int, float],
    edge_counts: Mapping[tuple[int, ...], int],
    *,
    scale: float,
    streamed: bool,
) -> Estimate:
    """Of a cell that is swept; edges by key."""
    ids = {key: e for e, key in enumerate(sweep.solid.edge_keys.tolist())}
    found = estimate_size(
        sweep,
        size=size,
        layers=layers,
        edge_sizes={ids[key]: own for key, own in edge_sizes.items() if key in ids},
        edge_counts={(ids[key],): -(-n // len(keys)) for keys, n in edge_counts.items() for key in keys if key in ids},
        scale=scale,
        streamed=streamed,
    )
    assert found is not None, "it has a size"
    return found


def _asked_of_edges(
    sweep: Sweep, edge_sizes: Mapping[int, float], edge_counts: Mapping[tuple[int, ...], int]
) -> tuple[int, int]:
    """Least segments of the source loops, and least layers, that wishes for single edges lead to."""
    rails = set(sweep.rails)
    asked = {e: sweep.solid.edges[e].length / size for e, size in edge_sizes.items()}
    for edges, count in edge_counts.items():
        asked |= dict.fromkeys(edges, count / len(edges))
    n_rail = max([n for e, n in asked.items() if e in rails], default=0.0)
    # Segments of one edge stand in every ring, on the source as well.
    rings = [[e for loop in loops for e, _ in loop] for loops in (sweep.source_loops, sweep.target_loops)]
    rings += [[e] for e in asked if e not in rails]
    return _bounded(max(sum(asked.get(e, 0.0) for e in ring) for ring in rings)), _bounded(n_rail)


def _from_counts(sweep: Sweep, size: float, n_layers: int, n_edges: int, *, scale: float, streamed: bool) -> Estimate:
    n_edges = max(n_edges, _bounded(_loops_length(sweep) / size))
    # The boundary has its own count: a cap with many short edges holds more quads than its area says.
    n_quads = max(1, _bounded(_cap_area(sweep) / size**2 if size > 1e-150 else math.inf), n_edges // 4)
    unknown = Estimate(
        n_quads=0, n_layers=0, n_hexes=0, n_bytes=0, seconds=0.0,
        size=size * scale, largest=sweep.solid.size * scale, streamed=streamed,
    )  # fmt: skip
    return _with_counts(unknown, n_quads, n_layers)


def _of_corners(blocks: CornerBlocks, size: float, *, scale: float) -> Estimate:
    """Of a cell of blocks at its corners: cubes that fill its volume, two along its edges at least."""
    shortest = min(edge.length for edge in blocks.solid.edges)
    n_layers = max(2, _bounded(max(blocks.solid.volume ** (1.0 / 3.0), shortest) / size))
    unknown = Estimate(
        n_quads=0, n_layers=0, n_hexes=0, n_bytes=0, seconds=0.0, size=size * scale, largest=blocks.solid.size * scale
    )
    return _with_counts(unknown, min(LARGEST_COUNT, max(len(blocks.corners), n_layers**2)), n_layers)


def _with_counts(expected: Estimate, n_quads: int, n_layers: int) -> Estimate:
    return estimate_counted(expected, n_quads, n_quads * n_layers, streamed=expected.streamed)


def peak_bytes(n_quads: float, n_hexes: float, streamed: bool) -> float:
    """Memory at the peak of the work."""
    resident = min(n_hexes, 1e6) if streamed else n_hexes
    return BASE_BYTES + BYTES_PER_QUAD * n_quads + BYTES_PER_HEX * resident


def _cap_area(sweep: Sweep) -> float:
    return sum(sweep.solid.faces[face].area for face in sweep.source)


def _loops_length(sweep: Sweep) -> float:
    return sum(sweep.solid.edges[edge].length for loop in sweep.source_loops for edge, _ in loop)


def _sweep_length(sweep: Sweep) -> float:
    """Length from source to target: the mean of the linking sides' area over the loops' length, or the rails'."""
    loops = _loops_length(sweep)
    sides = sum(sweep.solid.faces[side].area for side in {s.face for s in sweep.linking_sides})
    return sides / loops if loops > 0 else sweep.solid.size


def _bounded(count: float) -> int:
    return LARGEST_COUNT if not count < LARGEST_COUNT else math.ceil(count)


def say_count(n: int) -> str:
    return f"{n:,}" if n < 10**6 else f"{n:.1e}"


def say_memory(n_bytes: float) -> str:
    return f"{n_bytes / GIGABYTE:.3g} GB" if n_bytes < 1e15 else f"{n_bytes / GIGABYTE:.0e} GB"


def _time(seconds: float) -> str:
    for limit, unit, name in ((120, 1, "s"), (7200, 60, "min"), (172800, 3600, "h"), (math.inf, 86400, "days")):
        if seconds < limit:
            return f"{seconds / unit:.3g} {name}"
    raise AssertionError("seconds are finite")
