"""Names that every format and every solver can carry.

Names travel between programs only as ``[A-Za-z0-9_]``. ``cad`` hands over such names; a mesh made from arrays may hold
any string, and some formats allow less (a length, no difference between upper and lower case).
"""

from __future__ import annotations

import logging
import re
from collections.abc import Collection, Iterable

logger = logging.getLogger(__name__)

_SAFE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


def portable_names(names: Iterable[str], *, max_length: int = 80, reserved: Collection[str] = ()) -> dict[str, str]:
    """Map each name to a portable one: ``[A-Za-z_][A-Za-z0-9_]*``, unique also where case does not count.

    A name that is already portable stays as it is, unless it is too long or differs from an earlier one by case alone.

    Parameters
    ----------
    names : iterable of str
    max_length : int
        Most characters that the format keeps.
    reserved : collection of str
        Names that the format needs for itself.

    Returns
    -------
    dict of str to str
        In the order of `names`; a change is logged as a warning.
    """
    names = [str(name) for name in names]
    taken = {name.lower() for name in reserved}
    chosen: dict[str, str] = {}
    # Names that need no change come first, so that a changed one never takes a good name away.
    for name in sorted(names, key=lambda name: not _is_portable(name, max_length)):
        stem = _portable(name)
        candidate, count = stem[:max_length], 1
        while candidate.lower() in taken:
            count += 1
            ending = f"_{count}"
            candidate = stem[: max_length - len(ending)] + ending
        taken.add(candidate.lower())
        chosen[name] = candidate
        if candidate != name:
            logger.warning("the name %r is written as %r", name, candidate)
    return {name: chosen[name] for name in names}


def _is_portable(name: str, max_length: int) -> bool:
    return len(name) <= max_length and _SAFE.match(name) is not None


def _portable(name: str) -> str:
    plain = name
    if not name.isascii():
        from anyascii import anyascii

        plain = anyascii(name)
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", plain.strip())
    if not plain.strip("_") and name != plain:
        plain = "name"
    return plain if plain[:1].isalpha() or plain[:1] == "_" else f"n{plain}"
