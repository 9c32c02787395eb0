"""Check the arrays that enter projection, and say plainly what is wrong with them.

Place in the flow: the first thing :func:`fit_affine` and :func:`project_layers` do. Everything after it
may rely on finite float64 points, int64 ids and loops that hold every ring row once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, distinct
from ..errors import InputError


def checked_points(values: npt.ArrayLike, name: str, *, n_axes: int = 2) -> FloatArray:
    """Return `values` as a finite float64 array of `n_axes` axes whose last one is the space R^n, n >= 2."""
    try:
        points = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"`{name}` is not a regular array of numbers ({error}); every ring needs the same number of nodes"
        ) from error
    if points.ndim != n_axes or points.shape[-1] < 2:
        wanted = "(n_layers + 1, b, 3)" if n_axes == 3 else "(m, 3)"
        raise InputError(f"`{name}` has shape {points.shape}; wanted {wanted}, or 2 for 3 in a plane")
    if 0 in points.shape:
        raise InputError(f"`{name}` is empty: its shape is {points.shape}")
    if not np.isfinite(points).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(points))[0])
        place = f"layer {where[0]}, ring node {where[1]}" if n_axes == 3 else f"node {where[0]}"
        raise InputError(f"`{name}` has a coordinate that is not finite at {place}")
    return points


def checked_ids(values: npt.ArrayLike, name: str, n_nodes: int) -> IntArray:
    """Return `values` as int64 node ids in [0, n_nodes)."""
    ids = np.asarray(values)
    if ids.size and not np.issubdtype(ids.dtype, np.integer):
        raise InputError(f"`{name}` must hold integer node ids, not {ids.dtype}")
    ids = ids.astype(np.int64)
    if ids.size and (ids.min() < 0 or ids.max() >= n_nodes):
        raise InputError(f"`{name}` refers to node {ids.min() if ids.min() < 0 else ids.max()} of {n_nodes} nodes")
    return ids


def checked_loops(loops: Sequence[npt.ArrayLike], n_nodes: int) -> tuple[IntArray, ...]:
    """Return `loops` as int64 arrays, each of three nodes or more, no node used twice."""
    checked = tuple(checked_ids(loop, f"loops[{j}]", n_nodes) for j, loop in enumerate(loops))
    if not checked:
        raise InputError("`loops` is empty; the outer loop is needed")
    for j, loop in enumerate(checked):
        if loop.ndim != 1 or len(loop) < 2:
            raise InputError(f"`loops[{j}]` has shape {loop.shape}; a loop is a row of node ids")
    nodes = np.concatenate(checked)
    if len(distinct(nodes)) != len(nodes):
        raise InputError("`loops` use a node twice; each boundary node belongs to one loop, once")
    return checked


def loop_slices(loops: Sequence[IntArray]) -> tuple[slice, ...]:
    """Where each loop lies in ``np.concatenate(loops)``."""
    ends = np.cumsum([len(loop) for loop in loops])
    return tuple(slice(int(end - len(loop)), int(end)) for loop, end in zip(loops, ends, strict=True))


def checked_choice(value: Any, name: str, choices: Sequence[str]) -> str:
    """Return `value` where it is one of `choices`."""
    if value not in choices:
        raise InputError(f"`{name}` is {value!r}; it can be {', '.join(repr(c) for c in choices)}")
    return str(value)


def extent(points: FloatArray) -> float:
    """Longest side of the box round points (..., n), one axis after the other: rows of three are slow to reduce."""
    return max(float(np.max(points[..., c]) - np.min(points[..., c])) for c in range(points.shape[-1]))
