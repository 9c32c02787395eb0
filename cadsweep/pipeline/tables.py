"""All rows of all tables of rules, by name: what the option ``without`` may name.

Place in the flow: asked when a row is to be switched off, and by ``benchmarks/worth.py``. A table has one home each; a
new table is one more line here.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..blends.borders import BORDERS
from ..blends.sheets import SHEET
from ..cad.edit.families import FAMILIES
from ..errors import InputError, did_you_mean
from ..recognition.find import SHEET as THROUGH_SHEET
from ..recognition.outlines import ALIKE
from ..smoothing.ladder import STEPS
from ..surface.filling import FILLINGS
from .attempts import ATTEMPTS
from .complexes.answering import CARRIED
from .complexes.best import AGAIN
from .complexes.decomposing import SEARCHES
from .fitted_grids import ENDING, LETTING, MENDING
from .routes import INSTEAD, WAYS
from .tips import AFTER, HIGHER, MARKS, TIPS


def all_rows() -> tuple[str, ...]:
    """Names of all rows, table by table.

    Examples
    --------
    >>> from cadsweep.pipeline.tables import all_rows
    >>> all_rows()[:3]
    ('way: sweep', 'way: columns', 'way: cells')
    """
    return (
        *WAYS,
        INSTEAD,
        MARKS,
        HIGHER,
        TIPS,
        AFTER,
        MENDING,
        LETTING,
        ENDING,
        SHEET,
        BORDERS,
        *(attempt.row for attempt in ATTEMPTS),
        THROUGH_SHEET,
        ALIKE,
        *SEARCHES,
        *(f"cut: {name}" for name in FAMILIES),
        CARRIED,
        AGAIN,
        *(filling.row for filling in FILLINGS),
        *(f"mend: {name}" for steps in STEPS.values() for name, _ in steps),
    )


def check_rows(names: Sequence[str]) -> None:
    """Refuse a name that no row has.

    Raises
    ------
    InputError
    """
    known = all_rows()
    for name in names:
        if name not in known:
            raise InputError(f"there is no rule '{name}'{did_you_mean(name, known)}", try_=f"one of {', '.join(known)}")


__all__ = ["all_rows", "check_rows"]
