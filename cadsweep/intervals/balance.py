"""Wishes spread over what hangs together, before counts become whole numbers.

Place in the flow: used by :mod:`.programme` where a user's wish or demand moves some counts
away from what their lengths ask for. The integer programmes minimise a sum of absolute deviations, which says
how far the others must follow and not which of them; here all follow alike.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

FIRM = 100.0
"""Price of leaving a user's wish beside that of leaving what a length asks for."""
_EXACT = 1e6
"""Weight of the sums against the wishes: they hold to about its inverse, far below a half."""


def balance(counts: FloatArray, want: FloatArray, firm: FloatArray, sums: FloatArray, totals: FloatArray) -> FloatArray:
    """Real counts near the wanted ones, given sums that must be met.

    Minimises ``sum_j (x_j - want_j)^2 / want_j`` over ``x = counts @ y``: what hangs together is stretched by one
    factor.

    Parameters
    ----------
    counts : (m, n) float64
        Counts as linear functions of the unknowns y.
    want : (m,) float64
        Wanted counts, at least 1 each.
    firm : (m,) bool
        Wishes of the user.
    sums : (k, n), totals : (k,) float64
        ``sums @ y = totals``.

    Returns
    -------
    (m,) float64
        At least 1 each.
    """
    weight = np.where(firm, FIRM, 1.0) / np.sqrt(want)
    matrix = np.vstack([weight[:, None] * counts, _EXACT * sums])
    y = np.linalg.lstsq(matrix, np.concatenate([weight * want, _EXACT * totals]), rcond=1e-14)[0]
    return np.maximum(counts @ y, 1.0)
