"""Metrics of a mesh taken piece by piece: what :func:`check_mesh` and streamed meshes share.

Place in the flow: :func:`cadsweep.quality.check_mesh` adds a whole mesh in chunks; a mesh that is
streamed layer by layer adds each layer when it is made and never exists as a whole.

Memory: a few megabytes, whatever the size of the mesh. The distributions are kept as fine
histograms, so percentiles are exact to a bin (1/4000 of the metric's mapped range).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..compiled import compiled
from ..threads import map_chunks
from . import kernels
from .bernstein import positive_inside, prove
from .kernels import ZERO
from .report import MetricSummary, WorstHex

N_BINS = 4000
"""Fine bins: percentiles are good to 1/4000 of the range whatever the order in which slabs come."""
N_SHOWN = 20
"""Bars of a histogram; a divisor of `N_BINS`."""
PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
"""What the report lists."""

BoolArray = npt.NDArray[np.bool_]

# How a metric is mapped to [0, 1] for its histogram: 0: [-1, 1] linear; 1: [1, inf) by 1 - 1/x;
# 2: [0, 1] linear; 3: [0, inf) by x / (1 + x).
_MAPS = {"scaled_jacobian": 0, "aspect": 1, "skew": 2, "taper": 3, "condition": 1, "warpage": 0}
_KINDS = np.array([_MAPS.get(name, -1) for name in kernels.METRICS[:7]])


@compiled(cache=True, error_model="numpy", nogil=True)
def _count(rows, kinds, counts, stats):  # type: ignore[no-untyped-def]
    """Add `rows` to histograms `counts` and to `stats`: least, largest, sum, number of finite values."""
    n_bins = counts.shape[1]
    for r in range(rows.shape[0]):
        kind = kinds[r]
        least, largest, total, finite = stats[r, 0], stats[r, 1], 0.0, 0
        for i in range(rows.shape[1]):
            x = rows[r, i]
            if np.isfinite(x):
                total += x
                finite += 1
            least = min(least, x)
            largest = max(largest, x)
            if kind >= 0:
                if kind == 0:
                    t = 0.5 * (x + 1.0)
                elif kind == 1:
                    t = 1.0 - 1.0 / x
                elif kind == 2:
                    t = x
                else:
                    t = x / (1.0 + x) if x < np.inf else 1.0
                # A value that is no number goes to the last bin; the worst hexahedra name it anyway.
                b = int(t * n_bins) if t < 1.0 else n_bins - 1
                counts[r, max(b, 0)] += 1
        stats[r, 0] = least
        stats[r, 1] = largest
        stats[r, 2] += total
        stats[r, 3] += finite


@compiled(cache=True, error_model="numpy", nogil=True)
def _choose_worst(jacobians, inverted, chosen):  # type: ignore[no-untyped-def]
    """Fill chosen (k,), worst first: inverted hexahedra before others, those of least Jacobian first."""
    kept = np.full(chosen.shape[0], np.inf)
    count = 0
    for h in range(jacobians.shape[0]):
        value = jacobians[h] - 4.0 if inverted[h] else jacobians[h]  # below every hexahedron that is not inverted
        if count == chosen.shape[0] and value >= kept[count - 1]:
            continue
        at = min(count, chosen.shape[0] - 1)
        while at > 0 and not value >= kept[at - 1]:
            kept[at], chosen[at] = kept[at - 1], chosen[at - 1]
            at -= 1
        kept[at], chosen[at] = value, h
        count = min(count + 1, chosen.shape[0])


def _unmap(kind: int, t: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        return [2 * t - 1, 1 / (1 - t), t, t / (1 - t)][kind]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Piece:
    """What is kept of one chunk of hexahedra."""

    counts: IntArray
    stats: FloatArray
    volume: float
    n_inverted: int
    worst: list[WorstHex]
    jacobians: FloatArray | None


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Where added hexahedra stand in the mesh."""

    first_hex: int = 0
    per_layer: int = 0
    first_layer: int = 0
    start: int = 0


def _rank(one: WorstHex) -> tuple[bool, float, int]:
    return (not one.inverted, one.scaled_jacobian, one.id)


class QualityAccumulator:
    """Running metrics and validity of hexahedra.

    Attributes
    ----------
    n_hexes, n_inverted : int
    worst : tuple of WorstHex
        The worst hexahedra so far, worst first.

    Examples
    --------
    >>> seen = QualityAccumulator()
    >>> for k in range(n_layers):
    ...     seen.add(layer(k), layer(k + 1), quads, first_hex=k * len(quads), layer=k)
    >>> seen.min_scaled_jacobian, seen.n_inverted
    """

    def __init__(self, *, n_worst: int = 10) -> None:
        self.n_hexes = 0
        self.n_inverted = 0
        self.worst: tuple[WorstHex, ...] = ()
        self._n_worst = n_worst
        self._volumes: list[float] = []
        self._jacobians: list[FloatArray] = []
        self._counts = np.zeros((7, N_BINS), dtype=np.int64)
        self._stats = _no_stats()
        self._quads: IntArray | None = None
        self._local: IntArray | None = None

    @property
    def min_scaled_jacobian(self) -> float:
        """Least scaled Jacobian so far (nan before the first hexahedron)."""
        return float(self._stats[0, 0]) if self.n_hexes else float("nan")

    @property
    def mean_scaled_jacobian(self) -> float:
        """Mean scaled Jacobian so far."""
        return float(self._stats[0, 2] / self.n_hexes) if self.n_hexes else float("nan")

    @property
    def volume(self) -> float:
        """Volume so far."""
        return float(np.sum(self._volumes))

    @property
    def least_jacobians(self) -> tuple[float, float] | None:
        """Least ratio and least bound of :class:`~.bernstein.Proof` so far; None of order 1, where nothing bends."""
        if not self._jacobians:
            return None
        ratio, bound = np.min(self._jacobians, axis=0).tolist()
        return ratio, bound

    def add(
        self, lower: FloatArray, upper: FloatArray, quads: IntArray, *, first_hex: int = 0, layer: int | None = None
    ) -> None:
        """Add the layer of hexahedra between two layers of nodes.

        Parameters
        ----------
        lower, upper : (n, 3) float64
            Nodes of layers k and k + 1.
        quads : (q, 4) int64
            Counter-clockwise about the direction from `lower` to `upper`.
        first_hex : int
            Id of the first hexahedron.
        layer : int or None
            Number of the layer, for the list of the worst.
        """
        if self._quads is not quads or self._local is None:
            self._quads, self._local = quads, np.hstack([quads, np.asarray(quads) + len(lower)])
        self.add_hexes(
            np.concatenate([lower, upper]),
            self._local,
            first_hex=first_hex,
            per_layer=0 if layer is None else len(quads),
            layer=layer or 0,
        )

    def add_hexes(
        self, points: FloatArray, hexes: IntArray, *, first_hex: int = 0, per_layer: int = 0, layer: int = 0
    ) -> None:
        """Add any hexahedra, whose indices are known to be in range.

        Parameters
        ----------
        points : (n, 3) float64
        hexes : (m, 8), (m, 20) or (m, 27) int64
        first_hex : int
            Id of the first of them.
        per_layer : int
            Hexahedra in a layer, 0 where there are no layers.
        layer : int
            Layer of the first of them.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        hexes = np.ascontiguousarray(hexes, dtype=np.int64)

        def measure(chunk: slice) -> _Piece:
            place = _Place(first_hex=first_hex, per_layer=per_layer, first_layer=layer, start=chunk.start)
            return self._measure(points, hexes[chunk], place)

        for piece in map_chunks(measure, len(hexes)):
            self._counts += piece.counts
            least, largest = self._stats[:, 0], self._stats[:, 1]
            np.minimum(least, piece.stats[:, 0], out=least)
            np.maximum(largest, piece.stats[:, 1], out=largest)
            self._stats[:, 2:] += piece.stats[:, 2:]
            self._volumes.append(piece.volume)
            self.n_inverted += piece.n_inverted
            self._jacobians += [] if piece.jacobians is None else [piece.jacobians]
            self.worst = tuple(heapq.nsmallest(self._n_worst, (*self.worst, *piece.worst), key=_rank))
        self.n_hexes += len(hexes)

    def merge(self, other: QualityAccumulator) -> None:
        """Add what another accumulator has seen of the same mesh."""
        self._counts += other._counts
        least, largest = self._stats[:, 0], self._stats[:, 1]
        np.minimum(least, other._stats[:, 0], out=least)
        np.maximum(largest, other._stats[:, 1], out=largest)
        self._stats[:, 2:] += other._stats[:, 2:]
        self._volumes += other._volumes
        self._jacobians += other._jacobians
        self.n_inverted += other.n_inverted
        self.n_hexes += other.n_hexes
        self.worst = tuple(heapq.nsmallest(self._n_worst, (*self.worst, *other.worst), key=_rank))

    def _measure(self, points: FloatArray, hexes: IntArray, place: _Place) -> _Piece:
        rows = np.empty((len(kernels.METRICS), len(hexes)))
        kernels.measure_hexes(points, hexes, rows)
        inverted, jacobians = _find_inverted(points, hexes, rows)
        counts = np.zeros((7, N_BINS), dtype=np.int64)
        stats = _no_stats()
        _count(rows[:7], _KINDS, counts, stats)
        return _Piece(
            counts=counts,
            stats=stats,
            volume=float(np.sum(rows[6])),
            n_inverted=int(np.count_nonzero(inverted)),
            worst=self._worst_of(points, hexes, rows, inverted, place),
            jacobians=jacobians,
        )

    def _worst_of(
        self, points: FloatArray, hexes: IntArray, rows: FloatArray, inverted: BoolArray, place: _Place
    ) -> list[WorstHex]:
        chosen = np.empty(min(self._n_worst, len(inverted)), dtype=np.int64)
        _choose_worst(rows[0], inverted, chosen)
        corners = points[hexes[chosen, :8]]
        centers = corners.mean(axis=1)
        radii = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
        return [
            WorstHex(
                id=place.first_hex + place.start + i,
                layer=place.first_layer + (place.start + i) // place.per_layer if place.per_layer else None,
                center=tuple(center),
                radius=radius,
                volume=float(rows[6, i]),
                scaled_jacobian=float(rows[0, i]),
                inverted=bool(inverted[i]),
            )
            for i, center, radius in zip(chosen.tolist(), centers.tolist(), radii.tolist(), strict=True)
        ]

    def summaries(self) -> dict[str, MetricSummary]:
        """Distribution of every metric so far."""
        result = {}
        for name, kind in _MAPS.items():
            row = kernels.METRICS.index(name)
            least, largest, total, finite = self._stats[row]
            limits = _shown_bins(self._counts[row])
            below = np.concatenate([[0], np.cumsum(self._counts[row])])
            result[name] = MetricSummary(
                min=float(least),
                mean=float(total / finite) if finite else float("nan"),
                max=float(largest),
                percentiles=self._percentiles(row, kind),
                edges=_unmap(kind, limits / N_BINS),
                counts=np.diff(below[limits]),
            )
        return result

    def _percentiles(self, row: int, kind: int) -> dict[int, float]:
        sums = np.cumsum(self._counts[row])
        if not sums[-1]:
            return dict.fromkeys(PERCENTILES, float("nan"))
        least, largest = self._stats[row, :2]
        found = {}
        for percent in PERCENTILES:
            b = int(np.searchsorted(sums, percent / 100 * (sums[-1] - 1) + 0.5))
            value = float(_unmap(kind, np.array((b + 0.5) / N_BINS)))
            found[percent] = float(min(max(value, least), largest))
        return found


def _shown_bins(counts: IntArray) -> IntArray:
    """Limits (N_SHOWN + 1,) of the bins that are shown, as limits of the fine ones: alike, from the first used on."""
    used = np.flatnonzero(counts)
    first, last = (int(used[0]), int(used[-1]) + 1) if len(used) else (0, N_BINS)
    width = -(-(last - first) // N_SHOWN)
    start = min(first, N_BINS - width * N_SHOWN)
    return start + width * np.arange(N_SHOWN + 1)


def _no_stats() -> FloatArray:
    return np.tile([np.inf, -np.inf, 0.0, 0.0], (7, 1))


def _find_inverted(points: FloatArray, hexes: IntArray, rows: FloatArray) -> tuple[BoolArray, FloatArray | None]:
    """Which hexahedra have a Jacobian that is not proven positive; of order 2 and above its least ratio and bound.

    Of these the volumes are replaced by those of what is bent.
    """
    if hexes.shape[1] > 8:
        proof = prove(points, hexes)
        rows[6] = proof.volumes
        return ~proof.positive, np.array([proof.ratios.min(initial=1.0), proof.bounds.min(initial=1.0)])
    # A value at a corner or at the centre that is not positive decides; so does a positive bound.
    inverted = ~(rows[7] > ZERO)
    undecided = np.flatnonzero(inverted & (rows[0] > 0))
    if len(undecided):
        inverted[undecided] = ~positive_inside(points, hexes[undecided])[0]
    return inverted, None
