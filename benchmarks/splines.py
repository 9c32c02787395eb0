"""B-splines: this package's compiled loops beside scipy's and OpenCASCADE's, for a few parameters and for many."""

from __future__ import annotations

import timeit
from collections.abc import Callable
from functools import partial

import numpy as np
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface
from OCP.GeomAdaptor import GeomAdaptor_Curve, GeomAdaptor_Surface
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal, TColStd_Array2OfReal
from scipy.interpolate import BSpline as ScipyBSpline
from scipy.interpolate import NdBSpline

from cadsweep.cad.geometry.nurbs import BSpline, BSplineSurface

N, DEGREE = 20, 3
RNG = np.random.default_rng(0)
KNOTS = np.concatenate([np.zeros(DEGREE + 1), np.sort(RNG.random(N - DEGREE - 1)), np.ones(DEGREE + 1)])
POLES, WEIGHTS = RNG.random((N, N, 3)), RNG.random((N, N)) + 0.5
HOMOGENEOUS = np.concatenate([POLES * WEIGHTS[..., None], WEIGHTS[..., None]], axis=2)


def opencascade() -> tuple[GeomAdaptor_Curve, GeomAdaptor_Surface]:
    """The curve of the first row of poles and the surface, as OpenCASCADE's own."""
    distinct = np.unique(KNOTS)
    knots, multiplicities = TColStd_Array1OfReal(1, len(distinct)), TColStd_Array1OfInteger(1, len(distinct))
    for j, knot in enumerate(distinct):
        knots.SetValue(j + 1, float(knot))
        multiplicities.SetValue(j + 1, DEGREE + 1 if j in (0, len(distinct) - 1) else 1)
    row, row_weights = TColgp_Array1OfPnt(1, N), TColStd_Array1OfReal(1, N)
    net, net_weights = TColgp_Array2OfPnt(1, N, 1, N), TColStd_Array2OfReal(1, N, 1, N)
    for i in range(N):
        row.SetValue(i + 1, gp_Pnt(*POLES[0, i].tolist()))
        row_weights.SetValue(i + 1, float(WEIGHTS[0, i]))
        for j in range(N):
            net.SetValue(i + 1, j + 1, gp_Pnt(*POLES[i, j].tolist()))
            net_weights.SetValue(i + 1, j + 1, float(WEIGHTS[i, j]))
    curve = Geom_BSplineCurve(row, row_weights, knots, multiplicities, DEGREE)
    surface = Geom_BSplineSurface(net, net_weights, knots, knots, multiplicities, multiplicities, DEGREE, DEGREE)
    return GeomAdaptor_Curve(curve), GeomAdaptor_Surface(surface)


def quotients(point: np.ndarray, *slopes: np.ndarray) -> list[np.ndarray]:
    """Rational points and derivatives of homogeneous ones."""
    place = point[:, :3] / point[:, 3:]
    return [place, *((slope[:, :3] - slope[:, 3:] * place) / point[:, 3:] for slope in slopes)]


def rivals() -> dict[str, dict[str, Callable[[np.ndarray], object]]]:
    """The evaluators, by what they evaluate and who does it."""
    own_curve = BSpline(degree=DEGREE, knots=KNOTS, poles=POLES[0], weights=WEIGHTS[0])
    own_surface = BSplineSurface(degrees=(3, 3), u_knots=KNOTS, v_knots=KNOTS, poles=POLES, weights=WEIGHTS)
    curve, surface = ScipyBSpline(KNOTS, HOMOGENEOUS[0], DEGREE), NdBSpline((KNOTS, KNOTS), HOMOGENEOUS, DEGREE)
    occ_curve, occ_surface = opencascade()
    point, by_u, by_v = gp_Pnt(), gp_Vec(), gp_Vec()

    def walk_curve(uv: np.ndarray) -> np.ndarray:
        out = np.empty((2, len(uv), 3))
        for m, u in enumerate(uv[:, 0].tolist()):
            occ_curve.D1(u, point, by_u)
            out[0, m], out[1, m] = (point.X(), point.Y(), point.Z()), (by_u.X(), by_u.Y(), by_u.Z())
        return out

    def walk_surface(uv: np.ndarray) -> np.ndarray:
        out = np.empty((3, len(uv), 3))
        for m, (u, v) in enumerate(uv.tolist()):
            occ_surface.D1(u, v, point, by_u, by_v)
            out[0, m], out[1, m] = (point.X(), point.Y(), point.Z()), (by_u.X(), by_u.Y(), by_u.Z())
            out[2, m] = by_v.X(), by_v.Y(), by_v.Z()
        return out

    return {
        "curve": {
            "scipy": lambda uv: quotients(curve(uv[:, 0]), curve(uv[:, 0], 1)),
            "OpenCASCADE": walk_curve,
            "compiled": lambda uv: own_curve.derivatives(uv[:, 0], 1),
        },
        "surface": {
            "scipy": lambda uv: quotients(surface(uv), surface(uv, nu=(1, 0)), surface(uv, nu=(0, 1))),
            "OpenCASCADE": walk_surface,
            "compiled": own_surface.derivatives,
        },
    }


def main() -> None:
    """Print a row for each size and kind."""
    for m in (1, 10, 100, 10_000):
        uv = RNG.random((m, 2))
        turns = max(1, 200 // m)
        for kind, evaluators in rivals().items():
            row = []
            for name, evaluate in evaluators.items():
                evaluate(uv)
                best = min(timeit.repeat(partial(evaluate, uv), number=turns, repeat=9)) / turns
                row.append(f"{name} {best * 1e6:.1f} us")
            print(f"{m:6d} {kind:8s}", ", ".join(row))


if __name__ == "__main__":
    main()
