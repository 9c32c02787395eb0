"""Place the interior nodes of every layer of a sweep.

Place in the flow: the rings come from ``surface``, the target cap from :mod:`.target`; the result goes to ``smoothing``
and ``mesh``.

Method: affine maps of all layers (:mod:`.fitting`) from the source cap, from layer to layer, or from both caps; what
they miss at the rings is carried inwards (:mod:`.residual`); all of it becomes one pair of factors (:mod:`.factored`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..choices import FUNCTIONALS, STRATEGIES
from ..errors import InputError
from .factored import FactoredSweep, make_basis
from .fitting import fit_from_caps, fit_steps
from .functionals import AffineMaps
from .inputs import checked_choice, checked_ids, checked_loops, checked_points, extent
from .residual import TOLERANCE, carry_tolerance, compress, cotangent_weights, extend

SAME = 1e-9
"""Cap nodes on the boundary and the first or last ring may differ by this fraction of the part's size."""


def project_layers(
    source_points: npt.ArrayLike,
    quads: npt.ArrayLike,
    rings: npt.ArrayLike,
    *,
    loops: Sequence[npt.ArrayLike],
    functional: str = "H",
    strategy: str = "both",
    target_points: npt.ArrayLike | None = None,
    residual: bool = True,
    residual_tolerance: float = TOLERANCE,
    known: tuple[IntArray, FloatArray] | None = None,
) -> FactoredSweep:
    """Place the interior nodes of every layer of a sweep.

    Parameters
    ----------
    source_points : (n_nodes, n) array, n = 2 or 3
        Source nodes, in any unit of length.
    quads : (q, 4) int array
        Their quads; used for the residual alone.
    rings : (n_layers + 1, b, n) array
        Boundary nodes of every layer, in the order of ``np.concatenate(loops)``; ``rings[0]`` are the
        boundary nodes of the source.
    loops : sequence of int arrays
        Boundary node ids in cyclic order, outer loop first.
    functional : "F", "G" or "H"
        Eqs. (6), (9), (10).
    strategy : "source", "advancing" or "both"
        Maps from the source cap; from the previous layer, composed; or from both caps, where the weight of the target
        cap is the mean over the ring nodes of the normalised chord length along each node's own line.
    target_points : (n_nodes, n) array, optional
        Nodes of the last layer. Needed for "both"; where given, the last layer is it whatever the strategy.
    residual : bool
        Carry what the maps miss at the rings into the interior.
    residual_tolerance : float
        What is not carried: this fraction of the shortest ring segment.
    known : ((m,) int64, (n_layers + 1, m, n) float64), optional
        Nodes inside whose places are known as well, and these; they are met as nearly as the residual at the rings.

    Returns
    -------
    FactoredSweep
        Boundary nodes equal `rings`, layer 0 `source_points` and the last layer `target_points`, bit for bit.

    Raises
    ------
    InputError
        Arrays that do not fit each other or are not finite, an unknown option, "both" without `target_points`.
    ProjectionError
        A ring spans less than n - 1 dimensions (Remark 7); names the layer and the loop.

    References
    ----------
    Roca, Sarrate, Huerta, "A new least-squares approximation of affine mappings for sweep algorithms",
    eqs. (6), (9), (10).

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep.projection import project_layers
    >>> source = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0.5]])  # the middle stands up
    >>> quads = [[0, 1, 4, 3], [1, 2, 3, 4]]
    >>> heights = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2]])
    >>> rings = source[:4] + heights[:, None]
    >>> sweep = project_layers(source, quads, rings, loops=[[0, 1, 2, 3]], strategy="source")
    >>> sweep.layer(2)[4].round(12).tolist()  # the middle node of the last layer
    [1.0, 1.0, 2.5]
    """
    checked_choice(functional, "functional", FUNCTIONALS)
    checked_choice(strategy, "strategy", STRATEGIES)
    if not 0.0 < residual_tolerance < np.inf:
        raise InputError(
            f"`residual_tolerance` is {residual_tolerance}; wanted a positive fraction, such as {TOLERANCE}"
        )
    source = checked_points(source_points, "source_points")
    ring_array = checked_points(rings, "rings", n_axes=3)
    node_loops = checked_loops(loops, len(source))
    quad_array = _checked_quads(quads, len(source))
    ring_nodes = np.concatenate(node_loops)
    if ring_array.shape[0] < 2 or ring_array.shape[1:] != (len(ring_nodes), source.shape[1]):
        raise InputError(
            f"`rings` has shape {ring_array.shape}; `loops` and `source_points` want "
            f"(n_layers + 1 >= 2, {len(ring_nodes)}, {source.shape[1]})"
        )
    _check_cap(source, "source_points", ring_array, 0, ring_nodes)
    target = None
    if target_points is not None:
        target = checked_points(target_points, "target_points")
        if target.shape != source.shape:
            raise InputError(f"`target_points` has shape {target.shape}, `source_points` {source.shape}")
        _check_cap(target, "target_points", ring_array, len(ring_array) - 1, ring_nodes)
    if strategy == "both" and target is None:
        raise InputError("strategy 'both' needs `target_points`; without a target cap use 'source' or 'advancing'")

    from_target, weights = None, np.zeros(len(ring_array))
    if strategy == "both":
        from_source, from_target = fit_from_caps(ring_array, node_loops, functional, caps=(0, -1))
        weights = chord_weights(ring_array)
    elif strategy == "source":
        (from_source,) = fit_from_caps(ring_array, node_loops, functional, caps=(0,))
    else:
        from_source = fit_composed(ring_array, node_loops, functional)
    source_center = from_source.source_centers[0]
    target_center = None if from_target is None else from_target.source_centers[0]
    coefficients = _affine_coefficients(from_source, from_target, weights)
    basis = make_basis(source, source_center, target, target_center, np.empty((len(source), 0)))
    # Without the carry a tolerance that nothing exceeds leaves no modes, and reports what is missed.
    tolerance = carry_tolerance(ring_array, node_loops, residual_tolerance) if residual else np.inf
    given, places = ring_nodes, ring_array
    if known is not None:
        given, places = np.concatenate([ring_nodes, known[0]]), np.concatenate([ring_array, known[1]], axis=1)
    modes = compress(places - basis[given] @ coefficients, tolerance)
    n_modes = modes.shapes.shape[1]
    if n_modes:
        operator = cotangent_weights(source, quad_array)
        if from_target is not None and target is not None:
            operator = operator + cotangent_weights(target, quad_array)
        basis = np.concatenate([basis, extend(operator, given, modes.shapes)], axis=1)
        coefficients = np.concatenate([coefficients, modes.amplitudes], axis=1)
    return FactoredSweep(
        basis=np.ascontiguousarray(basis),
        coefficients=np.ascontiguousarray(coefficients),
        rings=ring_array,
        loops=node_loops,
        quads=quad_array,
        source_points=source,
        source_center=source_center,
        target_points=target,
        target_center=target_center,
        ranks=np.minimum(from_source.ranks, from_target.ranks) if from_target else from_source.ranks,
        conditions=np.maximum(from_source.conditions, from_target.conditions)
        if from_target
        else from_source.conditions,
        weights=weights,
        n_modes=n_modes,
        remainder=modes.remainder,
        functional=functional,
        strategy=strategy,
    )


def chord_weights(rings: FloatArray) -> FloatArray:
    """Share of the target cap in each layer (K,): mean of the normalised chord length along the ring nodes' lines.

    Nodes that do not move have no line and no say; where none moves, layers count evenly.
    """
    steps = np.linalg.norm(np.diff(rings, axis=0), axis=-1)
    along = np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])
    moving = along[-1] > 1e-12 * extent(rings)
    if not moving.any():
        return np.linspace(0.0, 1.0, len(rings))
    weights = (along[:, moving] / along[-1, moving]).mean(axis=1)
    weights[-1] = 1.0
    return np.asarray(weights)


def fit_composed(rings: FloatArray, loops: Sequence[IntArray], functional: str) -> AffineMaps:
    """Fit the maps from layer to layer, and compose them to maps from the source cap.

    Ranks and conditions are those of the steps.
    """
    steps = fit_steps(rings, loops, functional)
    n_layers, n, _ = steps.matrices.shape
    # (x, 1) -> A (x - c) + b as one homogeneous matrix about the source centre keeps the composition a product.
    matrices, centers = np.empty_like(steps.matrices), np.empty_like(steps.centers)
    matrices[0], centers[0] = np.eye(n), steps.source_centers[0]
    for k in range(1, n_layers):
        A, c, b = steps.matrices[k], steps.source_centers[k], steps.centers[k]
        matrices[k] = A @ matrices[k - 1]
        centers[k] = A @ (centers[k - 1] - c) + b
    return AffineMaps(
        matrices=matrices,
        source_centers=np.broadcast_to(steps.source_centers[0], centers.shape),
        centers=centers,
        ranks=steps.ranks,
        conditions=steps.conditions,
    )


def _affine_coefficients(from_source: AffineMaps, from_target: AffineMaps | None, weights: FloatArray) -> FloatArray:
    """Coefficients (K, r, n) of the columns that :func:`make_basis` lays down, without residual modes."""
    linear = from_source.matrices.transpose(0, 2, 1)
    if from_target is None:
        return np.concatenate([linear, from_source.centers[:, None]], axis=1)
    w = weights[:, None, None]
    centers = (1.0 - w) * from_source.centers[:, None] + w * from_target.centers[:, None]
    return np.concatenate([(1.0 - w) * linear, centers, w * from_target.matrices.transpose(0, 2, 1)], axis=1)


def _checked_quads(quads: npt.ArrayLike, n_nodes: int) -> IntArray:
    array = checked_ids(quads, "quads", n_nodes)
    if array.ndim != 2 or array.shape[1] != 4:
        raise InputError(f"`quads` has shape {array.shape}; wanted (q, 4)")
    return array


def _check_cap(points: FloatArray, name: str, rings: FloatArray, layer: int, ring_nodes: IntArray) -> None:
    off = np.abs(points[ring_nodes] - rings[layer]).max(axis=1)
    if not off.any():
        return
    if off.max() > SAME * extent(rings):
        j = int(off.argmax())
        raise InputError(
            f"`{name}` and rings[{layer}] disagree by {off.max():.3g} at ring node {j} (node {ring_nodes[j]}); "
            "rings follow the order of np.concatenate(loops)"
        )
