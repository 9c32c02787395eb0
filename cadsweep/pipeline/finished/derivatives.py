"""How a mesh moves with a parameter of the model: the derivative of its nodes, by differences of the same mesh.

Place in the flow: on top of ``sweep_mesh`` and its ``like``. Optimisers and reduced models multiply the derivative by
what an adjoint solver says of the nodes.

Method: the part is built at four neighbouring values, the mesh carried to each; central differences with a step and
with half of it give the derivative by Richardson's extrapolation, and their disagreement an estimate of its error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...errors import CadSweepError, InputError
from ...mesh import HexMesh
from ..meshing import sweep_mesh
from ..routes import LEAVING_OUT
from .template import make_template

STEP = 0.01
"""Part of the parameter that is stepped: the fourth power of it is what the differences neglect, and what projections
leave of accuracy (1e-9 of a part) is divided by it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivity:
    """The derivative of a mesh by a parameter.

    Attributes
    ----------
    mesh : HexMesh
        At the parameters themselves.
    wrt : str
    value : float
        Of the parameter.
    derivative : (n, 3) float64
        d points / d parameter, model units a unit of the parameter.
    step : float
        Larger one of the two steps of the differences.
    error : float
        Estimated error of the worst component, from how far the two differences disagree: what it would be without
        the extrapolation, so with it a safe figure.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> def box(width):
    ...     return cq.Workplane().box(width, 3, 2)
    >>> found = cs.sensitivity(box, {"width": 4.0}, wrt="width", size=1.0)
    >>> found.derivative.shape == found.mesh.points.shape, found.error < 1e-9
    (True, True)
    """

    mesh: HexMesh
    wrt: str
    value: float
    derivative: FloatArray
    step: float
    error: float


def sensitivity(
    source: str | PathLike[str] | Callable[..., Any],
    params: Mapping[str, Any] | None = None,
    *,
    wrt: str,
    step: float | None = None,
    **options: Any,
) -> Sensitivity:
    """Differentiate the nodes of a mesh by a parameter of the model.

    Parameters
    ----------
    source : path or callable
        A CadQuery script, or a function that takes `params` as keywords and returns what ``sweep_mesh`` takes.
    params : mapping or None
        Parameters; those of a script that are missing have the script's values.
    wrt : str
        The parameter, a number.
    step : float or None
        How far the parameter is moved at most; None: a hundredth of it.
    **options
        Of :func:`cadsweep.sweep_mesh`.

    Raises
    ------
    InputError
        There is no such parameter, it is no number, or it is 0 and `step` is not given.
    CadSweepError
        The part cannot be meshed, or a neighbouring one cannot have its mesh: the parameter changes which faces
        there are. Says at which value.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> def box(width):
    ...     return cq.Workplane().box(width, 3, 2)
    >>> found = cs.sensitivity(box, {"width": 4.0}, wrt="width", size=1.0)
    >>> right = found.mesh.points[:, 0].argmax()  # a node at x = width / 2
    >>> found.derivative[right].round(6).tolist()
    [0.5, 0.0, 0.0]
    """
    known = dict(params or {})
    value = _value(source, known, wrt)
    if step is None:
        if value == 0.0:
            raise InputError(f"'{wrt}' is 0, of which no part makes a step: give step=...")
        step = STEP * abs(value)
    if isinstance(step, bool) or not isinstance(step, int | float) or not math.isfinite(step) or step <= 0:
        raise InputError(f"step must be a positive, finite number, not {step!r}")

    def build(at: float, **more: Any) -> HexMesh:
        wanted = {**known, wrt: at}
        if callable(source):
            return sweep_mesh(source(**wanted), **more)
        return sweep_mesh(source, params=wanted, **more)

    # Others are to be like this mesh.
    mesh = build(value, **{**options, "without": [*(options.get("without") or ()), *LEAVING_OUT]})
    template = make_template(mesh, "a derivative")
    kept = {
        name: options[name] for name in ("order", "nodes", "part", "touch", "cut_overlaps", "refine") if name in options
    }
    differences = []
    for h in (step, 0.5 * step):
        ends = []
        for at in (value + h, value - h):
            try:
                ends.append(build(at, like=template, **kept).points)
            except CadSweepError as error:
                raise CadSweepError(
                    f"no derivative by '{wrt}': at {wrt} = {at:.6g} the part cannot have the mesh that it has at "
                    f"{value:.6g} ({error.message}); try a smaller step"
                ) from error
        differences.append((ends[0] - ends[1]) / (2.0 * h))
    coarse, fine = differences
    return Sensitivity(
        mesh=mesh,
        wrt=wrt,
        value=value,
        derivative=fine + (fine - coarse) / 3.0,
        step=float(step),
        error=float(np.abs(fine - coarse).max()) / 3.0,
    )


def _value(source: Any, params: Mapping[str, Any], wrt: str) -> float:
    """The parameter's value, from the user or the script."""
    value = params.get(wrt)
    if wrt not in params:
        from ...cad.read.scripts import list_parameters  # and OpenCASCADE, which takes its time

        known = {} if callable(source) else list_parameters(Path(source))
        if wrt not in known:
            there = ", ".join(known) if known else ", ".join(params) or "none"
            raise InputError(f"there is no parameter '{wrt}' to differentiate by; there are: {there}")
        value = known[wrt][1]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"'{wrt}' must be a finite number to differentiate by, not {value!r}")
    return float(value)
