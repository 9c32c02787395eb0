"""The affine map between two rings.

Place in the flow: the public face of the fit, for one pair of rings; the equations (6), (9) and (10) are in
:mod:`.functionals`, whole sweeps in :mod:`.fitting`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray
from ..choices import FUNCTIONALS
from ..errors import InputError
from .fitting import fit_from_cap
from .inputs import checked_choice, checked_points
from .normals import row_loops


@dataclass(frozen=True, kw_only=True, eq=False)
class AffineMap:
    """``phi(x) = A (x - c^X) + b``, eq. (4).

    Attributes
    ----------
    matrix : (n, n) float64
        A.
    source_center : (n,) float64
        c^X.
    center : (n,) float64
        b, the image of the source centre (c^Y for F and H).
    rank : int
        Rank of the fitted system's matrix.
    condition : float
        Its condition number in the 2-norm; infinite where the rank is below n.
    functional : str

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep.projection import fit_affine
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> phi = fit_affine(square, 2 * square)
    >>> phi([[0.5, 0.5, 0.0]]).round(12).tolist()
    [[1.0, 1.0, 0.0]]
    """

    matrix: FloatArray
    source_center: FloatArray
    center: FloatArray
    rank: int
    condition: float
    functional: str

    def __call__(self, points: npt.ArrayLike) -> FloatArray:
        """Return the images (..., n) of `points` (..., n)."""
        return (np.asarray(points, dtype=np.float64) - self.source_center) @ self.matrix.T + self.center


def fit_affine(
    source_ring: npt.ArrayLike,
    ring: npt.ArrayLike,
    functional: str = "H",
    *,
    loops: Sequence[npt.ArrayLike] | None = None,
    vectors: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> AffineMap:
    """Fit an affine map that takes a source ring to a ring in the least-squares sense.

    Parameters
    ----------
    source_ring, ring : (m, n) arrays
        X and Y, node by node.
    functional : "F", "G" or "H"
        Eqs. (6), (9), (10).
    loops : sequence of int arrays, optional
        Rows of the rings in cyclic order, outer loop first, as :func:`.pseudo_normal` takes them; one loop of all
        rows where not given. Used for the normals of H.
    vectors : (u^X, u^Y), optional
        The vectors of H. By default Remark 8's: the pseudo-normals of both rings where X is planar, zero
        where it is not. They enter with the ring's Frobenius norm as their length, which leaves the
        paper's solution for a planar ring as it is and makes the result the same in every unit of length;
        where X lies between planar and curved their weight goes over smoothly (:mod:`.normals`).
        Vectors given here are used as they are.

    Returns
    -------
    AffineMap

    Raises
    ------
    InputError
        Coordinates that are not finite, rings of unequal length, an unknown functional.
    ProjectionError
        A ring spans less than n - 1 dimensions (Remark 7).

    Notes
    -----
    For F and G a ring with a relative non-planarity below 1e-5 is taken as planar: its offsets are noise, and
    dividing by them would make the map noise too.

    References
    ----------
    Roca, Sarrate, Huerta, eqs. (6), (9), (10), Remarks 7 and 8.

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep.projection import fit_affine
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> turned = square[:, [0, 2, 1]] + [0, 0, 5]  # into the plane y = 0, and up by 5
    >>> phi = fit_affine(square, turned, functional="H")
    >>> bool(np.allclose(phi(square), turned)), phi.rank
    (True, 3)
    >>> fit_affine(square, turned, functional="F").rank  # F does not know what becomes of the normal
    2
    """
    X, Y = checked_points(source_ring, "source_ring"), checked_points(ring, "ring")
    checked_choice(functional, "functional", FUNCTIONALS)
    if X.shape != Y.shape:
        raise InputError(f"the rings have different shapes, {X.shape} and {Y.shape}; nodes are paired row by row")
    given = None
    if vectors is not None:
        if functional != "H":
            raise InputError(f"`vectors` belong to functional 'H', not to {functional!r}")
        given = np.stack([checked_points(np.atleast_2d(v), "vectors")[0] for v in vectors])
        if given.shape != (2, X.shape[1]):
            raise InputError(f"`vectors` must be two vectors of R^{X.shape[1]}")
    order = row_loops(loops, len(X))
    rows = np.concatenate(order)
    if len(rows) != len(X):
        raise InputError(f"`loops` hold {len(rows)} rows of a ring of {len(X)}; every row belongs to one loop")
    maps = fit_from_cap(X[rows], Y[None, rows], order, functional, vectors=given)
    return AffineMap(
        matrix=maps.matrices[0],
        source_center=maps.source_centers[0],
        center=maps.centers[0],
        rank=int(maps.ranks[0]),
        condition=float(maps.conditions[0]),
        functional=functional,
    )
