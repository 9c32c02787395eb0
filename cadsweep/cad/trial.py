"""Steps of OpenCASCADE that may crash, hang or take all memory: done where a copy of the process came through them.

Place in the flow: ``heal``, ``imprinting``, ``edit`` and ``geometry`` do every step here that unites, divides,
intersects, fills or mends shapes. Planes and cylinders divide each other in closed form, and nothing has been seen to
end there: such steps go without a copy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..trial import SECONDS, give_up, survives
from .shapes import is_plain


def attempted(
    step: Callable[[], object], what: str, *, on: Sequence[Any] | None = None, seconds: float = SECONDS
) -> bool:
    """Do a step of OpenCASCADE; whether it was done: not where a copy of this process does not come to its end.

    Where there is no copy, an exception of OpenCASCADE is no end either.

    Parameters
    ----------
    step : callable
        As for :func:`cadsweep.trial.survives`.
    what : str
    on : sequence of TopoDS_Shape or None
        What it works on, where it is harmless on planes and cylinders; None: it is tried whatever it works on.
    seconds : float
    """
    plain = on is not None and all(map(is_plain, on))
    if not plain and not survives(step, what, seconds=seconds):
        return False
    try:
        step()
    except Exception as error:  # OpenCASCADE's own have no base in common
        if not type(error).__module__.startswith("OCP"):
            raise
        give_up(what, f"OpenCASCADE says '{error}'")
        return False
    return True


__all__ = ["SECONDS", "attempted", "survives"]
