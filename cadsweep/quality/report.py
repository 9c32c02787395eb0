"""What the checks found, as data: :class:`QualityReport`, readable by ``str()`` and by ``to_dict()``.

Place in the flow: filled by :mod:`cadsweep.quality.accumulate` and :mod:`cadsweep.quality.check`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..verbs import do
from .limits import BoundaryLimit
from .overlap import BoundaryCrossing


@dataclass(frozen=True, kw_only=True, eq=False)
class CadReference:
    """What the CAD model says a mesh should be; everything is optional.

    Attributes
    ----------
    volume : float or None
        Volume of the solid, model units.
    areas : mapping of boundary name to float
        Area of the faces of each boundary.
    joint_areas : mapping of boundary names to float
        Area that several boundaries have together, where the mesh does not follow the lines between them.
    euler : int or None
        Euler characteristic of the solid's surface: 2 for a ball, 0 for a ring.
    distance : callable or None
        ``distance(points, name, close)`` gives the distances (m,) of points (m, 3) from the faces of a
        boundary. What comes out larger than `close` has been made sure of by slower ways.
    rim_distance : callable or None
        ``rim_distance(points, blocks)`` gives the distances (m,) of points where several blocks of quads meet:
        from the edges that two of them share, from the vertices where three or more do. A block is all quads
        with the same set of names, and known by it.
    tolerance : float
        Largest distance of a boundary node from its face, over the part's size.
    relative : float or None
        Largest relative deviation of the volume and of the areas. None: four times what faceting
        can do, judged from the angles between neighbouring quads, and at least 1e-6.
    volume_doubt : float
        How uncertain the volume itself is, where the model's faces miss each other.
    area_doubts, joint_doubts : mapping
        How uncertain the areas are, by the keys of `areas` and `joint_areas`.
    """

    volume: float | None = None
    areas: Mapping[str, float] = field(default_factory=dict)
    joint_areas: Mapping[tuple[str, ...], float] = field(default_factory=dict)
    euler: int | None = None
    distance: Callable[[FloatArray, str, float], FloatArray] | None = None
    rim_distance: Callable[[FloatArray, frozenset[frozenset[str]]], FloatArray] | None = None
    tolerance: float = 1e-6
    relative: float | None = None
    volume_doubt: float = 0.0
    area_doubts: Mapping[str, float] = field(default_factory=dict)
    joint_doubts: Mapping[tuple[str, ...], float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class MetricSummary:
    """Distribution of one metric over all hexahedra.

    Attributes
    ----------
    min, mean, max : float
        Exact; the mean is over the finite values.
    percentiles : dict of int to float
        1, 5, 25, 50, 75, 95, 99; exact to a quarter of a thousandth of the metric's scale.
    edges : (21,) float64
        Limits of the histogram's bins, which begin at the data's least value and end at or beyond its largest.
    counts : (20,) int64
        Hexahedra in each bin.
    """

    min: float
    mean: float
    max: float
    percentiles: dict[int, float]
    edges: FloatArray
    counts: IntArray


@dataclass(frozen=True, kw_only=True)
class WorstHex:
    """One of the worst hexahedra.

    Attributes
    ----------
    id : int
        Row of ``HexMesh.hexes``.
    layer : int or None
        Layer of hexahedra, 0 on the source, where the mesh is one sweep.
    center : (float, float, float)
    radius : float
        Distance of its farthest corner from there.
    volume, scaled_jacobian : float
    inverted : bool
        The Jacobian is not positive everywhere inside.
    """

    id: int
    layer: int | None
    center: tuple[float, float, float]
    radius: float
    volume: float
    scaled_jacobian: float
    inverted: bool

    def __str__(self) -> str:
        place = ", ".join(f"{c:.5g}" for c in self.center)
        layer = "" if self.layer is None else f" in layer {self.layer}"
        mark = ", inverted" if self.inverted else ""
        return (
            f"hex {self.id}{layer} at ({place}): scaled Jacobian {self.scaled_jacobian:.4g}, "
            f"volume {self.volume:.4g}{mark}"
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QualityReport:
    """Metrics and findings of a whole mesh.

    Attributes
    ----------
    n_nodes, n_hexes, order : int
    n_inverted : int
        Hexahedra whose Jacobian is not proven positive at every point inside.
    min_scaled_jacobian, mean_scaled_jacobian : float
    metrics : dict of str to MetricSummary
        ``scaled_jacobian``, ``aspect``, ``skew``, ``taper``, ``condition``, ``warpage``
        (:class:`cadsweep.quality.HexMetrics`).
    worst : tuple of WorstHex
        Ten at most, the inverted ones first, then by scaled Jacobian.
    volume : float
        Sum of the hexahedra's volumes, model units.
    areas : dict of str to float
        Area of the bilinear quads of each boundary.
    jacobian_ratio, jacobian_bound : float or None
        Of order 2 and above: the least ratio of the Jacobian determinant's least to its greatest value in a hexahedron,
        and the least Bernstein coefficient over that greatest value, below which it is nowhere; 1 for a brick.
    euler : int or None
        Euler characteristic of the boundary surface.
    problems : tuple of str
        What is wrong, a sentence each; empty for a valid mesh.
    limit : BoundaryLimit or None
        The worst corner of boundary nodes alone, which no smoothing can mend and nothing can exceed. None for
        a mesh without structure, and where no hexahedron is poor (0.5).
    crossings : tuple of BoundaryCrossing
        Where the boundary crosses itself, the most frequent first; empty for a valid mesh.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> report = cs.sweep_mesh(box, size=1.0, layers=2).quality()
    >>> report
    QualityReport: 24 hexes of order 1, 60 nodes, valid
      scaled Jacobian: worst 1, mean 1, inverted 0
    >>> round(report.volume, 9), round(report.areas["source"], 9), report.euler
    (24.0, 12.0, 2)
    >>> report.metrics["aspect"].max
    1.0
    """

    n_nodes: int
    n_hexes: int
    order: int
    n_inverted: int
    min_scaled_jacobian: float
    mean_scaled_jacobian: float
    metrics: dict[str, MetricSummary]
    worst: tuple[WorstHex, ...]
    volume: float
    areas: dict[str, float]
    jacobian_ratio: float | None = None
    jacobian_bound: float | None = None
    euler: int | None = None
    problems: tuple[str, ...] = ()
    limit: BoundaryLimit | None = None
    crossings: tuple[BoundaryCrossing, ...] = ()

    def __repr__(self) -> str:
        verdict = "valid" if self.valid else f"NOT VALID ({len(self.problems)} problems): {self.problems[0][:160]}"
        return (
            f"QualityReport: {self.n_hexes:,} hexes of order {self.order}, {self.n_nodes:,} nodes, {verdict}\n"
            f"  scaled Jacobian: worst {self.min_scaled_jacobian:.4g}, mean {self.mean_scaled_jacobian:.4g}, "
            f"inverted {self.n_inverted:,}"
        )

    @property
    def valid(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems

    @property
    def percentiles(self) -> dict[int, float]:
        """Percentiles of the scaled Jacobian."""
        return self.metrics["scaled_jacobian"].percentiles

    @property
    def histogram(self) -> tuple[FloatArray, IntArray]:
        """Bin limits and counts of the scaled Jacobian."""
        summary = self.metrics["scaled_jacobian"]
        return summary.edges, summary.counts

    def to_dict(self) -> dict[str, Any]:
        """The report as plain lists and numbers, fit for JSON (what is not finite becomes None)."""
        data = asdict(self)
        data["valid"] = self.valid
        plain = _plain(data)
        assert isinstance(plain, dict)
        return plain

    def plot(self, **options: Any) -> Any:
        """Draw the histogram of a metric over the range of its data (:func:`cadsweep.view.plot_report`)."""
        return do("plot_report", self, **options)

    def _repr_html_(self) -> str:
        return str(do("report_card", self))

    def __str__(self) -> str:
        lines = [
            f"{self.n_nodes:,} nodes, {self.n_hexes:,} hexahedra of order {self.order}: "
            + ("valid" if self.valid else "NOT VALID"),
            f"scaled Jacobian: worst {self.min_scaled_jacobian:.4g}, mean {self.mean_scaled_jacobian:.4g}, "
            f"{self.n_inverted:,} inverted",
            f"volume {self.volume:.8g}"
            + "".join(f"\n  area of {name}: {area:.8g}" for name, area in self.areas.items()),
        ]
        if self.jacobian_ratio is not None:
            lines.append(
                f"Jacobian: least over greatest in a hexahedron {self.jacobian_ratio:.4g}, nowhere below "
                f"{self.jacobian_bound:.4g}"
            )
        if self.limit is not None and self.limit.hex >= 0:
            lines.append(
                f"limit: node {self.limit.node} of hex {self.limit.hex} in layer {self.limit.layer} has a scaled "
                f"Jacobian of {self.limit.value:.4g} by boundary nodes alone"
            )
        if self.euler is not None:
            lines.append(f"Euler characteristic of the boundary: {self.euler}")
        lines.append(f"{'':17}{'least':>10}{'5 %':>10}{'median':>10}{'95 %':>10}{'largest':>10}")
        for name, m in self.metrics.items():
            values = (m.min, m.percentiles[5], m.percentiles[50], m.percentiles[95], m.max)
            lines.append(f"  {name:15}" + "".join(f"{v:10.4g}" for v in values))
        lines += self._bars()
        if self.worst:
            lines.append("worst hexahedra:")
            lines += ["  " + str(h) for h in self.worst]
        lines += [f"problem: {p}" for p in self.problems]
        return "\n".join(lines)

    def _bars(self) -> list[str]:
        edges, counts = self.histogram
        most = max(int(np.max(counts)), 1) if len(counts) else 1
        used = np.flatnonzero(counts)
        if not len(used):
            return []
        rows = range(int(used[0]), int(used[-1]) + 1)
        return [
            f"  {edges[i]:7.4f} .. {edges[i + 1]:7.4f} {counts[i]:>12,} {'#' * int(np.ceil(40 * counts[i] / most))}"
            for i in rows
        ]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
