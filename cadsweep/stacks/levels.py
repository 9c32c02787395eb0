"""On which layer of nodes every cap lies: one integer programme.

Place in the flow: after :mod:`.sheets`. The sheets are given whole numbers so that those over each other differ by one
at least, those with material between them by their distance in wanted layers, as nearly as may be; what does not
touch is free to share a level or not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from ..arrays import FloatArray, sparse
from ..errors import SurfaceMeshError
from ..stack import Levels, Stack
from .level_demands import Wanted, label_of, minimal, refusal
from .sheets import Sheets

_PATIENCE = 20.0
"""Seconds after which the best levels found so far are taken."""
_INFEASIBLE = 2
"""What scipy's programme says where nothing fits."""
_APART = 2.0
"""Price of sheets on one level that come near each other, beside 1 for all layers being of the wrong height."""
_UPRIGHT = 10.0
"""How steep a level may be that has both, in lengths of the way, before the price rises no more."""
_ORDER = 1e-4
"""Price of a layer too much, beside that of layers of the wrong height."""


def assign_levels(
    stack: Stack,
    sheets: Sheets,
    *,
    size: float,
    layers: int | None = None,
    demands: Mapping[tuple[int, int], int] | None = None,
    apart: Mapping[tuple[int, int], float] | None = None,
    least: int = 1,
) -> Levels:
    """Choose the level of every cap and station.

    Parameters
    ----------
    stack : Stack
    sheets : Sheets
    size : float
        Wanted height of a layer, working units.
    layers : int, optional
        Layers demanded from the lowest cap to the highest.
    demands : mapping of (int, int) to int, optional
        Layers demanded between two sheets.
    apart : mapping of (int, int) to float, optional
        Sheets of which the one should lie over the other (:mod:`.apart`), and how steep a level that had both would be.
    least : int
        Layers wished for between two sheets, however near they are.

    Raises
    ------
    InputError
        What is demanded cannot be had.
    SurfaceMeshError
        Caps lie over each other in one place and under each other in another.
    """
    _check_order(stack, sheets)
    n = len(sheets.heights)
    pairs = [
        (a, b, max(h / size, float(least)), w) for (a, b), found in sheets.spans.items() for h, w in _merged(found)
    ]
    lowest, highest = int(np.argmin(sheets.heights)), int(np.argmax(sheets.heights))
    wanted = [Wanted(low, high, int(count)) for (low, high), count in (demands or {}).items()]
    if layers is not None:
        wanted.append(Wanted(lowest, highest, layers, whole=True))
    steep = {pair: value for pair, value in (apart or {}).items() if pair not in sheets.over}
    found = _solved(sheets, pairs, wanted, steep)
    if found is None:
        raise refusal(stack, sheets, minimal(wanted, lambda some: _solved(sheets, pairs, some, {}) is not None))
    levels = np.round(found[:n]).astype(np.int64)
    levels -= levels.min()
    return Levels(
        caps={f: int(levels[s]) for f, s in sheets.caps.items()},
        stations={e: int(levels[s]) for e, s in sheets.stations.items()},
        heights=_mean_heights(sheets, levels),
    )


def _solved(
    sheets: Sheets,
    pairs: Sequence[tuple[int, int, float, float]],
    wanted: Sequence[Wanted],
    steep: Mapping[tuple[int, int], float],
) -> FloatArray | None:
    """Levels of all sheets, and after them how far each pair is off its wish; None where there are none.

    Raises
    ------
    SurfaceMeshError
        None were found in the time there is.
    """
    # Columns: levels 0 .. n - 1, then one deviation a pair, then by how much those that should be apart are not.
    n, n_pairs, n_apart = len(sheets.heights), len(pairs), len(steep)
    price = np.concatenate([np.full(n, _ORDER), [w / max(wish, 1.0) for _, _, wish, w in pairs]])
    price[n:] /= max(float(price[n:].sum()), 1e-300)
    price = np.append(price, [_APART * min(value / _UPRIGHT, 1.0) for value in steep.values()])
    rows: list[tuple[dict[int, float], float, float]] = []
    for a, b in sheets.over:
        rows.append(({b: 1.0, a: -1.0}, 1.0, np.inf))
    for j, (a, b, wish, _) in enumerate(pairs):
        rows.append(({b: 1.0, a: -1.0, n + j: 1.0}, wish, np.inf))
        rows.append(({b: 1.0, a: -1.0, n + j: -1.0}, -np.inf, wish))
    for j, (a, b) in enumerate(steep):
        rows.append(({b: 1.0, a: -1.0, n + n_pairs + j: 1.0}, 1.0, np.inf))
    for low, high, count, _ in wanted:
        rows.append(({high: 1.0, low: -1.0}, float(count), float(count)))
    most = min((float(one.n) for one in wanted if one.whole), default=np.inf)
    found = scipy.optimize.milp(
        price,
        integrality=np.concatenate([np.ones(n), np.zeros(n_pairs + n_apart)]),
        bounds=scipy.optimize.Bounds(
            np.zeros(len(price)), np.concatenate([np.full(n, most), np.full(n_pairs + n_apart, np.inf)])
        ),
        constraints=scipy.optimize.LinearConstraint(sparse([row for row, _, _ in rows], len(price)), *_limits(rows)),
        options={"time_limit": _PATIENCE, "mip_rel_gap": 1e-3},
    )
    if found.x is None and found.status != _INFEASIBLE:
        raise SurfaceMeshError(
            f"no layers for the {n} levels of the stack were found in {_PATIENCE:g} s: ask for a larger size, or for "
            "layers between fewer caps"
        )
    return None if found.x is None else np.asarray(found.x)


def _merged(found: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Distances of two sheets that are the same, with their lengths together."""
    total: dict[float, float] = {}
    for height, weight in found:
        key = float(f"{height:.6g}")
        total[key] = total.get(key, 0.0) + weight
    return list(total.items())


def _limits(rows: list[tuple[dict[int, float], float, float]]) -> tuple[FloatArray, FloatArray]:
    return np.array([low for _, low, _ in rows]), np.array([high for _, _, high in rows])


def _check_order(stack: Stack, sheets: Sheets) -> None:
    """Refuse sheets that lie over each other in a circle."""
    n = len(sheets.heights)
    pairs = np.array(list(sheets.over), dtype=np.int64).reshape(-1, 2)
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    count, group = scipy.sparse.csgraph.connected_components(
        scipy.sparse.csr_array(graph), directed=True, connection="strong"
    )
    if count == n:
        return
    a, b = next((a, b) for a, b in sheets.over if group[a] == group[b])
    names = [label_of(stack, sheets, sheet) for sheet in (a, b)]
    raise SurfaceMeshError(
        f"{names[0]} lies under {names[1]} at ({sheets.over[a, b]}), and over it in another place: no layers go between"
    )


def _mean_heights(sheets: Sheets, levels: np.ndarray) -> FloatArray:
    """Height of every level: the mean of its sheets, between them in equal steps; rising."""
    n = int(levels.max())
    known = np.unique(levels)
    means = np.array([sheets.heights[levels == k].mean() for k in known])
    heights = np.interp(np.arange(n + 1), known, means)
    least = 0.1 * (sheets.heights.max() - sheets.heights.min()) / max(n, 1)
    if (np.diff(heights) < least).any():
        # Sheets of one level at unlike heights: what rises in all is kept, what does not is evened out.
        rising = np.maximum.accumulate(heights)
        heights = 0.5 * rising + 0.5 * np.linspace(rising[0], rising[-1], n + 1)
    return np.asarray(heights)
