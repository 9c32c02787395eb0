"""The target cap: the source mesh carried over to the target surface.

Place in the flow: after ``surface`` has placed the last ring, before :func:`project_layers`.

Method (the paper's reference [4]): the nodes go from the plane of the source to the parameters of the target by the
least-squares affine map between the two images of the loops (functional H, n = 2), the residual is carried inwards, and
the surface's own parametrisation lifts them: no root finding per node. Where that gives poor quads (a parametrisation
that winds round a pole, or is stretched unevenly) the 3-D image of the source is projected orthogonally to the surface.
Both are judged by their worst quad, and the better one is kept. Where that is folded or poor, its nodes are moved along
the surface until it is not (:mod:`.injective`).

Not handled: a target ring that is not on the surface; the ring is taken as it is.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..brep import Surface
from ..errors import InputError, ProjectionError
from .corner_kernels import area_along, least_sine
from .injective import WANTED, rectangles, relax_plane
from .inputs import checked_ids, checked_loops, checked_points, loop_slices
from .layers import project_layers
from .normals import pseudo_normal

log = logging.getLogger(__name__)

_RELAXATIONS = 3
"""Relaxations at most, each in the surface's metric at the last one."""
_STEEP = 0.2
"""Cosine to the mean normal below which a surface is too steep for its plane view."""

POOR = 0.7
"""A cap with a worse corner, and worse than the source's by `GOOD_ENOUGH`, is relaxed: free quads have as much."""
SHEARED = 0.59
"""The same where the cap is the source's affine image, which is exact: a disc of rings stretched to twice its width has
just 0.6, and stays so."""
_RELAXED = 0.75
"""Worst corner that a relaxed cap is led to, where it can have it: layers between the caps have a little less."""
_AFFINE = 1e-6
"""Greatest distance, in sizes of the ring, between it and the affine image of the source's loops."""
GOOD_ENOUGH = 0.9
"""A method whose worst quad reaches this fraction of the source's worst quad is taken without trying the next."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TargetCap:
    """Nodes of the target cap.

    Attributes
    ----------
    points : (n, 3) float64
        Boundary nodes are the ring, bit for bit; all others lie on the surface.
    method : str
        ``"parametric"`` or ``"projected"``, with ``"+relaxed"`` where the nodes were moved along the surface.
    min_quality : float
        Worst scaled Jacobian of the quads' corners, against the surface's normal; below zero where a quad is folded.
    qualities : dict of str to float
        The same for every method that was tried.
    """

    points: FloatArray
    method: str
    min_quality: float
    qualities: dict[str, float] = field(default_factory=dict)


def project_target(
    source_points: npt.ArrayLike,
    quads: npt.ArrayLike,
    loops: Sequence[npt.ArrayLike],
    ring: npt.ArrayLike,
    *,
    surface: Surface,
    boundary_uv: npt.ArrayLike | None = None,
    source_uv: npt.ArrayLike | None = None,
) -> TargetCap:
    """Place the nodes of the target cap, or of one face of it, on its surface.

    Parameters
    ----------
    source_points : (n, 3) array
        Source nodes; for one face of a cap of several faces, the nodes that belong to it.
    quads : (q, 4) int array
        Their quads, counter-clockwise about the sweep direction.
    loops : sequence of int arrays
        Nodes whose targets are known, as closed cycles, outer first.
    ring : (b, 3) array
        Where they go, in the order of ``np.concatenate(loops)``; on the surface.
    surface : Surface
        Target surface: ``evaluate``, ``derivatives``, ``project`` and ``periods`` are used.
    boundary_uv : (b, 2) array, optional
        Parameters of `ring` on the surface; found by ``surface.project`` where not given. Jumps of a period are mended.
    source_uv : (n, 2) array, optional
        Plane image of the source; its projection along the pseudo-normal where not given.

    Returns
    -------
    TargetCap

    Raises
    ------
    InputError
        Arrays that do not fit each other.
    ProjectionError
        No method gave finite points.

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep.projection import project_target
    >>> class Plane:  # z = 5, all that is asked of a surface
    ...     periods = (None, None)
    ...     def evaluate(self, uv):
    ...         return np.column_stack([uv, np.full(len(uv), 5.0)])
    ...     def derivatives(self, uv):
    ...         return np.tile([1.0, 0, 0], (len(uv), 1)), np.tile([0.0, 1, 0], (len(uv), 1))
    ...     def project(self, points):
    ...         return points[:, :2]
    >>> source = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0]])
    >>> quads = [[0, 1, 4, 3], [1, 2, 3, 4]]
    >>> cap = project_target(source, quads, [[0, 1, 2, 3]], source[:4] + [0, 0, 5], surface=Plane())
    >>> cap.points[4].round(9).tolist()
    [1.0, 1.0, 5.0]
    """
    source, cap_ring = checked_points(source_points, "source_points"), checked_points(ring, "ring")
    cap_loops, cap_quads = checked_loops(loops, len(source)), checked_ids(quads, "quads", len(source))
    nodes = np.concatenate(cap_loops)
    if cap_ring.shape != (len(nodes), 3) or source.shape[1] != 3:
        raise InputError(f"`ring` has shape {cap_ring.shape}; the loops want ({len(nodes)}, 3)")
    given = surface.project(cap_ring) if boundary_uv is None else checked_points(boundary_uv, "boundary_uv")
    if given.shape != (len(nodes), 2):
        raise InputError(f"`boundary_uv` has shape {given.shape}; wanted ({len(nodes)}, 2)")
    plane = _plane_image(source, cap_loops) if source_uv is None else checked_points(source_uv, "source_uv")
    uv_ring, winds = unwrapped(given, cap_loops, surface.periods)

    methods: dict[str, Callable[[], FloatArray]] = {}
    if not winds:
        methods["parametric"] = lambda: _parametric_uv(plane, cap_quads, cap_loops, uv_ring, surface)
    methods["projected"] = lambda: _projected_uv(source, cap_quads, cap_loops, cap_ring, surface)
    wanted = GOOD_ENOUGH * worst_corner(source, cap_quads, None)
    found: dict[str, tuple[float, FloatArray]] = {}
    for name, place in methods.items():
        uv = place()
        points = surface.evaluate(uv)
        points[nodes] = cap_ring
        if not np.isfinite(points).all():
            log.info("target cap by the %s way: not finite", name)
            continue
        quality = worst_corner(points, cap_quads, sweep_normals(points, cap_quads, surface, uv))
        found[name] = quality, points
        if quality >= wanted:
            break
    if not found:
        raise ProjectionError("the target cap cannot be placed: its surface gives no finite points inside the ring")
    method = max(found, key=lambda name: round(found[name][0], 6))  # of two that differ by rounding, the first
    quality, points = found[method]
    movable = ~np.isin(cap_quads, nodes)
    movable |= np.roll(movable, 1, axis=1) | np.roll(movable, -1, axis=1)
    # Corners between three boundary nodes are what they are; only the others ask to be moved.
    movable_worst = worst_corner(points, cap_quads, sweep_normals(points, cap_quads, surface), movable)
    is_poor = movable_worst < min(POOR, wanted)
    if is_poor and (movable_worst < SHEARED or not _is_affine(source[nodes], cap_ring)):
        relaxed = relaxed_cap(points, source, cap_quads, cap_loops, surface, wanted=_RELAXED)
        if relaxed is not None:
            better = worst_corner(relaxed, cap_quads, sweep_normals(relaxed, cap_quads, surface))
            found[method + "+relaxed"] = better, relaxed
            if better > quality:
                method, quality, points = method + "+relaxed", better, relaxed
    return TargetCap(
        points=points, method=method, min_quality=quality, qualities={name: pair[0] for name, pair in found.items()}
    )


def unwrapped(
    uv: FloatArray, loops: Sequence[IntArray], periods: tuple[float | None, float | None]
) -> tuple[FloatArray, bool]:
    """Bring the parameters of all loops into one branch; also tell whether a loop winds round the surface.

    Along a loop neighbours differ by less than half a period; holes come as near to the middle of the outer loop as a
    multiple of the period allows.
    """
    result, winds = uv.copy(), False
    for axis, period in enumerate(periods):
        if not period:
            continue
        middle = 0.0
        for j, s in enumerate(loop_slices(loops)):
            values = result[s, axis]
            steps = np.diff(values, append=values[:1])
            steps -= period * np.round(steps / period)
            winds = winds or abs(steps.sum()) > 0.5 * period
            values = values[0] + np.concatenate([[0.0], np.cumsum(steps[:-1])])
            center = 0.5 * (values.min() + values.max())
            if j == 0:
                middle = center
            result[s, axis] = values - period * np.round((center - middle) / period)
    return result, winds


def worst_corner(
    points: FloatArray, quads: IntArray, normals: FloatArray | None, counted: np.ndarray | None = None
) -> float:
    """Worst sine of the quads' corners about the `normals` (n, 3) at the nodes, or about each quad's own normal.

    `counted` (q, 4) says which corners count; all where not given.
    """
    about = np.empty((0, 3)) if normals is None else np.ascontiguousarray(normals)
    every = np.ones(quads.shape, dtype=np.bool_) if counted is None else counted
    return float(least_sine(np.ascontiguousarray(points), np.ascontiguousarray(quads), about, every))


def _is_affine(source: FloatArray, ring: FloatArray) -> bool:
    """Whether one affine map takes the source's loops (b, 3) to the ring's nodes."""
    off = source - source.mean(axis=0)
    image = ring - ring.mean(axis=0)
    matrix = np.linalg.lstsq(off, image, rcond=1e-9)[0]
    return float(np.abs(off @ matrix - image).max()) < _AFFINE * float(np.abs(image).max())


def _unit(vectors: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))


def sweep_normals(points: FloatArray, quads: IntArray, surface: Surface, uv: FloatArray | None = None) -> FloatArray:
    """Normals of the surface at its `points`, on the side that most of the quads' area turns to."""
    across_u, across_v = surface.derivatives(surface.project(points) if uv is None else uv)
    normals = _unit(np.cross(across_u, across_v))
    side = area_along(np.ascontiguousarray(points), np.ascontiguousarray(quads), normals)
    return normals if side >= 0.0 else -normals


def _plane_image(points: FloatArray, loops: Sequence[IntArray]) -> FloatArray:
    """Coordinates (n, 2) in the plane across the pseudo-normal."""
    nodes = np.concatenate(loops)
    return np.asarray((points - points[nodes].mean(axis=0)) @ _plane_frame(points[nodes], loops)[:2].T)


def _plane_frame(ring: FloatArray, loops: Sequence[IntArray]) -> FloatArray:
    """Two unit vectors across the pseudo-normal of the ring, and it: the rows of a right-handed frame."""
    normal = pseudo_normal(ring, [np.arange(s.start, s.stop) for s in loop_slices(loops)])
    axis = np.linalg.svd(ring - ring.mean(axis=0), full_matrices=False)[2][0]
    axis = _unit(axis - (axis @ normal) * normal)
    return np.stack([axis, np.cross(normal, axis), normal])


def relaxed_cap(
    points: FloatArray,
    source: FloatArray,
    quads: IntArray,
    loops: Sequence[IntArray],
    surface: Surface,
    *,
    fixed: IntArray | None = None,
    wanted: float = WANTED,
) -> FloatArray | None:
    """The cap with its inner nodes moved along the surface, in its ring's plane or, where that sees it edge-on, in the
    surface's parameters; None where these wind round it.

    Nodes that are `fixed` stay, those of the loops where it is None; a worst corner whose sine is `wanted` is enough.
    """
    kept = np.concatenate(loops) if fixed is None else fixed
    nodes = np.concatenate(loops)
    frame = _plane_frame(points[nodes], loops)
    center = points[nodes].mean(axis=0)
    lengths = rectangles(source, quads)
    for _ in range(_RELAXATIONS):
        normals = sweep_normals(points, quads, surface) @ frame.T
        if float(np.min(normals[:, 2])) < _STEEP:
            return _relaxed_in_parameters(points, quads, loops, surface, kept=kept, lengths=lengths, wanted=wanted)
        slopes = -normals[:, :2] / normals[:, 2:]
        y = (points - center) @ frame[:2].T
        moved = relax_plane(
            y, quads, kept, lengths=lengths, metric=_graph_metric(slopes[quads].mean(axis=1)), wanted=wanted
        )
        steps = moved - y
        lifted = np.c_[steps, np.einsum("ij,ij->i", steps, slopes)]
        placed = surface.evaluate(surface.project(points + lifted @ frame))
        if not np.isfinite(placed).all():
            return None
        placed[kept] = points[kept]
        points = placed
        if not slopes.any():
            break
    return points


def _relaxed_in_parameters(
    points: FloatArray,
    quads: IntArray,
    loops: Sequence[IntArray],
    surface: Surface,
    *,
    kept: IntArray,
    lengths: FloatArray,
    wanted: float,
) -> FloatArray | None:
    """What :func:`relaxed_cap` does, for a cap that turns too far to be seen in one plane: half of a bore."""
    nodes = np.concatenate(loops)
    uv = surface.project(points)
    ring, winds = unwrapped(uv[nodes], loops, surface.periods)
    if winds:
        return None
    for axis, period in enumerate(surface.periods):
        if period:
            middle = 0.5 * (ring[:, axis].min() + ring[:, axis].max())
            uv[:, axis] -= period * np.round((uv[:, axis] - middle) / period)
    uv[nodes] = ring
    corners = uv[quads]
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    turned = float((diagonals[0][:, 0] * diagonals[1][:, 1] - diagonals[0][:, 1] * diagonals[1][:, 0]).sum()) < 0.0
    handed = np.array([1.0, -1.0 if turned else 1.0])
    for _ in range(_RELAXATIONS):
        metric = _parameter_metric(uv, quads, surface)
        if metric is None:
            return None
        y = uv * handed
        uv = (
            relax_plane(y, quads, kept, lengths=lengths, metric=metric * handed[:, None] * handed, wanted=wanted)
            * handed
        )
    placed = surface.evaluate(uv)
    if not np.isfinite(placed).all():
        return None
    placed[kept] = points[kept]
    return placed


def _parameter_metric(uv: FloatArray, quads: IntArray, surface: Surface) -> FloatArray | None:
    """Matrices (q, 2, 2) that take steps in the parameters to steps on the surface; None where one has no inverse.

    They are the roots of the first fundamental form, in the mean over a quad's corners.
    """
    along = np.stack(surface.derivatives(uv), axis=1)
    form = np.einsum("nik,njk->nij", along, along)[quads].mean(axis=1)
    root = np.sqrt(np.maximum(np.linalg.det(form), 0.0))
    trace = np.trace(form, axis1=1, axis2=2)
    if not np.isfinite(form).all() or (root < 1e-9 * trace).any():
        return None
    return np.asarray((form + root[:, None, None] * np.eye(2)) / np.sqrt(trace + 2.0 * root)[:, None, None])


def _graph_metric(slopes: FloatArray) -> FloatArray:
    """Matrices (q, 2, 2) that take steps in the plane to steps on a graph with the given slopes (q, 2)."""
    squares = np.einsum("qi,qi->q", slopes, slopes)
    stretch = (np.sqrt(1.0 + squares) - 1.0) / np.where(squares > 0.0, squares, 1.0)
    return np.eye(2) + stretch[:, None, None] * slopes[:, :, None] * slopes[:, None, :]


def _parametric_uv(
    plane: FloatArray, quads: IntArray, loops: Sequence[IntArray], uv_ring: FloatArray, surface: Surface
) -> FloatArray:
    """The paper's way: least-squares affine map between the plane images of the loops, and its residual."""
    scale = mean_stretch(uv_ring, surface)
    nodes = np.concatenate(loops)
    sweep = project_layers(
        plane, quads, np.stack([plane[nodes], uv_ring * scale]), loops=loops, functional="H", strategy="source"
    )
    return sweep.layer(1) / scale


def mean_stretch(uv: FloatArray, surface: Surface) -> FloatArray:
    """Length per unit of u and of v, in the mean over the ring: so scaled, shapes are nearly those on the surface."""
    lengths = np.array([np.linalg.norm(d, axis=1).mean() for d in surface.derivatives(uv)])
    return np.where(np.isfinite(lengths) & (lengths > 0.0), lengths, 1.0)


def _projected_uv(
    source: FloatArray, quads: IntArray, loops: Sequence[IntArray], ring: FloatArray, surface: Surface
) -> FloatArray:
    """The 3-D affine image and its residual, projected orthogonally to the surface."""
    nodes = np.concatenate(loops)
    sweep = project_layers(source, quads, np.stack([source[nodes], ring]), loops=loops, strategy="source")
    return surface.project(sweep.layer(1))
