"""Wishes spread over what hangs together, before counts become whole numbers.

Place in the flow: used by :mod:`.programme` where a user's wish or demand moves some counts
away from what their lengths ask for. The integer programmes minimise a sum of absolute deviations, which says
how far the others must follow and not which of them; here all follow alike.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray

FIRM = 100.0
"""Price of leaving a user's wish beside that of leaving what a length asks for."""
_EXACT = 1e5
"""Weight of the sums against the wishes: they hold to far below a half, and may repeat or contradict each other."""


def balance(want: FloatArray, firm: FloatArray, sums: scipy.sparse.csr_array, totals: FloatArray) -> FloatArray:
    """Real counts near the wanted ones, given sums that must be met.

    Minimises ``sum_j (x_j - want_j)^2 / want_j``: what hangs together is stretched by one factor.

    Parameters
    ----------
    want : (n,) float64
        Wanted counts, at least 1 each.
    firm : (n,) bool
        Wishes of the user.
    sums : (k, n) sparse, totals : (k,) float64
        ``sums @ x = totals``.

    Returns
    -------
    (n,) float64
        At least 1 each.
    """
    price = np.where(firm, FIRM**2, 1.0) / want
    slack = scipy.sparse.diags_array(np.full(len(totals), -1.0 / _EXACT**2))
    system = scipy.sparse.block_array([[scipy.sparse.diags_array(price), sums.T], [sums, slack]], format="csc")
    found = scipy.sparse.linalg.spsolve(system, np.concatenate([price * want, totals]))
    return np.maximum(found[: len(want)], 1.0)
