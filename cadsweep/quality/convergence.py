"""How sure a figure is that was computed on a family of nested meshes: Roache's grid convergence index.

Place in the flow: beside the checks; any figure will do, a mesh's volume or what a solver says of a stress.

Not handled: families whose steps are not in one ratio, and figures that swing from mesh to mesh, of which no order is
found (``order`` is None).

References
----------
Roache, "Perspective: a method for uniform reporting of grid refinement studies", J. Fluids Eng. 116 (1994).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..errors import InputError

SAFETY = 1.25
"""Roache's factor for an order that three meshes or more have shown."""

NOISE = 1e-12
"""Part of a figure below which a change from mesh to mesh is rounding."""


@dataclass(frozen=True, kw_only=True)
class ConvergenceIndex:
    """What the three finest meshes of a family say of a figure.

    Attributes
    ----------
    values : tuple of float
        On every mesh, the coarsest first.
    order : float or None
        Observed order of convergence; None where the figure does not change, or not in one direction and less each
        time.
    extrapolated : float or None
        Richardson's value for steps of nought.
    index : float or None
        Uncertainty of the finest value, as a part of it: 1.25 times the difference from `extrapolated`. Nought where
        the figure does not change.
    ratio : float or None
        Index of the mesh before over the finest's and ``2 ** order``: near 1 where the meshes are fine enough for the
        order to mean something.
    """

    values: tuple[float, ...]
    order: float | None
    extrapolated: float | None
    index: float | None
    ratio: float | None


def convergence_index(values: Sequence[float], *, step_ratio: float = 2.0) -> ConvergenceIndex:
    """Work out order, limit and uncertainty of a figure on a family of meshes.

    Parameters
    ----------
    values : sequence of float
        Three or more, the coarsest mesh's first.
    step_ratio : float
        Step of a mesh over that of the next.

    Raises
    ------
    InputError
        Fewer than three values, one that is not finite, or a ratio that is not above 1.
    """
    known = tuple(float(value) for value in values)
    if len(known) < 3 or not all(math.isfinite(value) for value in known):
        raise InputError(f"a convergence index needs three finite values or more, not {list(values)}")
    if not step_ratio > 1.0:
        raise InputError(f"step_ratio must be above 1, not {step_ratio}")
    coarse, middle, fine = known[-3:]
    before, last = middle - coarse, fine - middle
    noise = NOISE * max(abs(coarse), abs(middle), abs(fine))
    if abs(before) <= noise and abs(last) <= noise:
        return ConvergenceIndex(values=known, order=None, extrapolated=fine, index=0.0, ratio=None)
    if abs(last) <= noise or before / last <= 1.0:
        return ConvergenceIndex(values=known, order=None, extrapolated=None, index=None, ratio=None)
    order = math.log(before / last) / math.log(step_ratio)
    growth = step_ratio**order - 1.0
    extrapolated = fine + last / growth
    index = SAFETY * abs(last / growth / fine) if fine else None
    ratio = abs(fine / middle) if middle else None  # of the two indices the growth cancels against the differences
    return ConvergenceIndex(values=known, order=order, extrapolated=extrapolated, index=index, ratio=ratio)


def convergence_rows(found: Mapping[str, ConvergenceIndex]) -> list[tuple[str, ...]]:
    """A table as texts, its head first: figure, value on every mesh, order, limit, index of the finest value."""
    levels = max((len(one.values) for one in found.values()), default=0)
    head = ("", *(f"level {level}" for level in range(levels)), "order", "extrapolated", "GCI of the finest")
    rows = [head]
    for name, one in found.items():
        order = "-" if one.order is None else f"{one.order:.2f}"
        limit = "-" if one.extrapolated is None else f"{one.extrapolated:,.8g}"
        index = "-" if one.index is None else f"{one.index:.2e}"
        rows.append((name, *(f"{value:,.8g}" for value in one.values), order, limit, index))
    return rows


def convergence_lines(found: Mapping[str, ConvergenceIndex]) -> list[str]:
    """The same table as aligned lines."""
    rows = convergence_rows(found)
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join([row[0].ljust(widths[0]), *(text.rjust(n) for text, n in zip(row[1:], widths[1:], strict=True))])
        for row in rows
    ]
