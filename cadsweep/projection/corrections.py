"""Where the product folds or flattens hexahedra: a sparse correction on top of it.

Place in the flow: after :func:`project_layers`; ``smoothing`` comes later and may do more. A sweep whose worst
hexahedron is good enough goes through untouched, and most do.

Method: the bad hexahedra and some rows round them are a patch. Its nodes inside the sweep (never the rings, never
the caps) move until a shape energy of the hexahedra's corners is least (:mod:`.hexenergy`), first with a barrier that
lets folded corners unfold, then in rising p-norms that lift the worst. What has moved is stored as displacements, node
by node; a patch that did not get better is put back.

Not handled: corners whose four nodes all lie on rings and caps; nothing inside can mend them, and they do not count.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

from ..mesh import sweep_hexes
from ..topology import FloatArray, IntArray
from .descent import Energy, minimise
from .factored import Corrections, FactoredSweep
from .hexenergy import corner_energies, layer_scaled_jacobians, worst_determinant
from .relax import is_stuck

log = logging.getLogger(__name__)

WANTED = 0.4
"""Hexahedra with a smaller scaled Jacobian are worked on."""
SIZE_WEIGHT = 0.1
"""How much even sizes count against shape while folded corners unfold."""
POLISH = (0.02, 0.9)
"""The same while the worst corners are lifted, and the weight of the angles."""
SQUARINGS = (2, 3, 4)
"""The p-norms that lift them, one after the other: p is 4, 8, 16."""
_ROUNDS = 30
_LEAST_GAIN = 1e-3
_MOST_FACTORED = 30_000
"""Nodes of a patch up to which the Laplacian is factorised; beyond, it is replaced by its diagonal."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Patch:
    """Hexahedra to work on, over nodes numbered anew.

    nodes : ids ``k * n_nodes + i`` (p,); hexes : (h, 8) into them; free : (f,) positions in them.
    """

    nodes: IntArray
    hexes: IntArray
    free: IntArray


def corrected(
    sweep: FactoredSweep,
    quads: npt.ArrayLike | None = None,
    loops: Sequence[npt.ArrayLike] | None = None,
    *,
    wanted: float = WANTED,
    n_patches: int = 4,
    max_nodes: int = 400_000,
) -> FactoredSweep:
    """Return the sweep, corrected where its hexahedra are bad, never worse than it was.

    Parameters
    ----------
    sweep : FactoredSweep
    quads, loops : optional
        Those of the sweep, which knows them itself.
    wanted : float
        Scaled Jacobian below which a hexahedron is worked on.
    n_patches : int
        How often to look for bad hexahedra again, at most.
    max_nodes : int
        Patches of more nodes are left alone: that many corrections are no longer sparse.

    Returns
    -------
    FactoredSweep
        With :attr:`FactoredSweep.corrections` where something was moved; the same object where nothing was.
    """
    cells = sweep.quads if quads is None else np.ascontiguousarray(quads, dtype=np.int64)
    if sweep.source_points.shape[1] != 3 or sweep.n_layers < 2 or not len(cells):
        return sweep
    fixed = _fixed_nodes(sweep)
    values = scaled_jacobians(sweep, cells, fixed=fixed)
    bad = values < wanted
    if not bad.any():
        return sweep
    if np.mean(values <= 0.0) > 0.5:
        log.warning("more than half of the hexahedra are inverted: the quads turn against the sweep, or the rings do")
        return sweep
    if 2 * int(bad.sum()) > max_nodes:
        log.warning("%d bad hexahedra: too many for a sparse correction", int(bad.sum()))
        return sweep
    # Only the run of layers that the patches can reach is made.
    layers = np.flatnonzero(bad.any(axis=1))
    first, last = max(int(layers[0]) - n_patches - 2, 0), min(int(layers[-1]) + n_patches + 3, sweep.n_layers)
    before, inside = sweep.points(slice(first, last + 1)), ~fixed[first : last + 1]
    inside[0] = inside[-1] = False
    after, found = _mended(
        before, cells, inside, values[first:last], wanted=wanted, n_patches=n_patches, max_nodes=max_nodes
    )
    log.info("worst hexahedron %.3f, corrected %.3f", np.min(values), np.min(found))
    return sweep if after is before else _with_moves(sweep, after - before, first)


def _mended(
    points: FloatArray,
    quads: IntArray,
    inside: npt.NDArray[np.bool_],
    values: FloatArray,
    *,
    wanted: float,
    n_patches: int,
    max_nodes: int,
) -> tuple[FloatArray, FloatArray]:
    """Points of a run of layers after the patches that made them better, and their hexahedra's values."""
    for grow in range(2, 2 + n_patches):
        patch = _patch_round(values < wanted, quads, inside, grow, max_nodes)
        if patch is None:
            break
        trial = points.copy()
        flat = trial.reshape(-1, 3)
        flat[patch.nodes] = _relaxed(flat[patch.nodes], patch)
        found = _values_of(trial, quads, ~inside)
        gain = float(np.min(found) - np.min(values))
        if _rank(found, wanted) > _rank(values, wanted):
            points, values = trial, found
        worst = float(np.min(values))
        if worst >= wanted or (gain < _LEAST_GAIN and worst > 0.0):
            break
    return points, values


def scaled_jacobians(
    sweep: FactoredSweep, quads: IntArray | None = None, *, fixed: npt.NDArray[np.bool_] | None = None
) -> FloatArray:
    """Least corner value (n_layers, q) of every hexahedron, made a few layers at a time.

    Corners between four `fixed` nodes (n_layers + 1, n_nodes) do not count; all count where not given.
    """
    cells = sweep.quads if quads is None else quads
    fixed = np.zeros((sweep.n_layers + 1, sweep.n_nodes), dtype=bool) if fixed is None else fixed
    values: FloatArray = np.empty((sweep.n_layers, len(cells)))
    step = max(1, (1 << 24) // sweep.source_points.nbytes)
    for start in range(0, sweep.n_layers, step):
        stop = min(start + step, sweep.n_layers)
        values[start:stop] = _values_of(sweep.points(slice(start, stop + 1)), cells, fixed[start : stop + 1])
    return values


def _fixed_nodes(sweep: FactoredSweep) -> npt.NDArray[np.bool_]:
    """Nodes of the rings and the caps (n_layers + 1, n_nodes)."""
    fixed = np.zeros((sweep.n_layers + 1, sweep.n_nodes), dtype=bool)
    fixed[0] = fixed[-1] = True
    fixed[:, sweep.ring_nodes] = True
    return fixed


def _values_of(points: FloatArray, quads: IntArray, fixed: npt.NDArray[np.bool_]) -> FloatArray:
    values = np.empty((len(points) - 1, len(quads)))
    for k in range(len(values)):
        layer_scaled_jacobians(points[k], points[k + 1], quads, fixed[k], fixed[k + 1], values[k])
    return values


def _rank(values: FloatArray, wanted: float) -> tuple[int, float, int]:
    """Better is: fewer inverted; or as few, and a better worst one; or that too, and fewer below `wanted`."""
    return (-int((values <= 0.0).sum()), round(float(np.min(values)), 9), -int((values < wanted).sum()))


def _patch_round(
    bad: npt.NDArray[np.bool_], quads: IntArray, inside: npt.NDArray[np.bool_], grow: int, max_nodes: int
) -> _Patch | None:
    """The bad hexahedra (n_layers, q), `grow` rows round them, and their nodes; None where nothing can move."""
    n_layers, n_nodes = len(inside) - 1, inside.shape[1]
    touched = np.zeros(inside.shape, dtype=bool)
    chosen = bad
    for _ in range(grow):
        touched[:] = False
        for k in range(n_layers):
            nodes = quads[chosen[k]]
            touched[k, nodes] = True
            touched[k + 1, nodes] = True
        around = np.asarray(touched[:, quads].any(axis=2))
        chosen = around[:-1] | around[1:]
    movable = touched & inside
    n_free = int(movable.sum())
    if not n_free:
        return None
    if n_free > max_nodes:
        log.warning("%d nodes round bad hexahedra: too many for a sparse correction", n_free)
        return None
    around = np.asarray(movable[:, quads].any(axis=2))
    used = np.flatnonzero((around[:-1] | around[1:]).ravel())
    hexes = sweep_hexes(quads, n_nodes, n_layers)[used]
    nodes, local = np.unique(hexes, return_inverse=True)
    free = np.flatnonzero(movable.ravel()[nodes])
    return _Patch(nodes=nodes, hexes=np.ascontiguousarray(local.reshape(hexes.shape)), free=free)


def _relaxed(points: FloatArray, patch: _Patch) -> FloatArray:
    """The patch's points (p, 3) with its free nodes moved to where the shape energy is least."""
    ideal = _ideal_lengths(points, patch.hexes)
    moved, free = points.copy(), patch.free
    solve = _preconditioner(patch, len(points))

    def norm(eps: float, weights: tuple[float, float], squarings: int) -> Energy:
        power = 2.0**squarings

        def energy(x: FloatArray) -> tuple[float, FloatArray]:
            moved[free] = x
            gradient = np.zeros_like(moved)
            value = corner_energies(moved, patch.hexes, ideal, eps, *weights, squarings, gradient)
            root = value ** (1.0 / power)
            return root, gradient[free] * (root / (value * power) if np.isfinite(value) else 0.0)

        return energy

    x = points[free].copy()
    worst = worst_determinant(moved, patch.hexes, ideal)
    history = [worst]
    for _ in range(_ROUNDS):
        if worst > 0.0 or is_stuck(history):
            break
        eps = float(np.sqrt(1e-12 + 0.04 * worst**2))
        x, _ = minimise(norm(eps, (SIZE_WEIGHT, 0.0), 0), x, solve, n_steps=25)
        moved[free] = x
        worst = worst_determinant(moved, patch.hexes, ideal)
        history.append(worst)
    if worst > 0.0:
        for squarings in SQUARINGS:
            x, _ = minimise(norm(0.0, POLISH, squarings), x, solve, n_steps=40)
    moved[free] = x
    return moved


def _ideal_lengths(points: FloatArray, hexes: IntArray) -> FloatArray:
    """Mean edge length (h, 3) of each hexahedron in its three directions."""
    p = points[hexes]
    pairs = (((0, 1), (3, 2), (4, 5), (7, 6)), ((0, 3), (1, 2), (4, 7), (5, 6)), ((0, 4), (1, 5), (2, 6), (3, 7)))
    lengths = [
        np.mean([np.linalg.norm(p[:, b] - p[:, a], axis=1) for a, b in direction], axis=0) for direction in pairs
    ]
    ideal: FloatArray = np.stack(lengths, axis=1)
    return np.maximum(ideal, 1e-3 * ideal.mean())


def _preconditioner(patch: _Patch, n_nodes: int) -> Callable[[FloatArray], FloatArray]:
    """Inverse of the graph Laplacian of the patch's edges, or of its diagonal where the patch is large."""
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]])
    starts, ends = patch.hexes[:, edges[:, 0]].ravel(), patch.hexes[:, edges[:, 1]].ravel()
    pairs = sparse.coo_matrix((np.ones(len(starts)), (starts, ends)), shape=(n_nodes, n_nodes)).tocsr()
    pairs = pairs + pairs.T
    degrees = np.asarray(pairs.sum(axis=1)).ravel()
    if len(patch.free) > _MOST_FACTORED:
        return lambda rhs: rhs / degrees[patch.free, None]
    laplacian = (sparse.diags(degrees) - pairs).tocsr()
    system = laplacian[patch.free][:, patch.free].tocsc()
    factor = sparse_linalg.splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return lambda rhs: factor.solve(np.ascontiguousarray(rhs))


def _with_moves(sweep: FactoredSweep, moves: FloatArray, first: int) -> FactoredSweep:
    """The sweep with displacements (K, n_nodes, 3) of the layers from `first` on added to those it has."""
    k, nodes = np.nonzero(moves.any(axis=2))
    layers, displacements = k + first, moves[k, nodes]
    if sweep.corrections is not None:
        old = sweep.corrections
        keys = np.concatenate([old.layers, layers]) * sweep.n_nodes + np.concatenate([old.nodes, nodes])
        unique, places = np.unique(keys, return_inverse=True)
        sums = np.zeros((len(unique), 3))
        np.add.at(sums, places, np.concatenate([old.displacements, displacements]))
        layers, nodes, displacements = unique // sweep.n_nodes, unique % sweep.n_nodes, sums
    return replace(sweep, corrections=Corrections(layers=layers, nodes=nodes, displacements=displacements))
