"""Rules in tables: each row has a name by which it can be switched off, and a mesh says which had a share in it.

Place in the flow: foundation. A table (ways to a mesh, to a sweep, families of cuts, fillings of caps, steps of
smoothing) asks :func:`is_on` of a row before it is tried, and says :func:`took` of one whose result was taken. Whoever
makes several and keeps one collects each by :func:`share`, and tells of the one that is kept.

Names are ``table: row``, as ``"cap: fan"``; :mod:`cadsweep.pipeline.tables` lists them all.
"""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterable, Iterator
from contextvars import ContextVar

_off: ContextVar[frozenset[str]] = ContextVar("rows_off", default=frozenset())
_shares: ContextVar[set[str] | None] = ContextVar("rows_shares", default=None)


def is_on(name: str) -> bool:
    """Whether a row may be tried."""
    return name not in _off.get()


def took(names: Iterable[str]) -> None:
    """Say that rows had a share in what is being made."""
    shares = _shares.get()
    if shares is not None:
        shares.update(names)


@contextlib.contextmanager
def without(names: Collection[str]) -> Iterator[None]:
    """Switch rows off.

    Examples
    --------
    >>> with without(["cap: fan"]):
    ...     is_on("cap: fan"), is_on("cap: grid")
    (False, True)
    """
    token = _off.set(_off.get() | frozenset(names))
    try:
        yield
    finally:
        _off.reset(token)


@contextlib.contextmanager
def share() -> Iterator[set[str]]:
    """Collect the rows that have a share in what the block makes; nobody outside hears of them.

    Examples
    --------
    >>> with share() as all_of_it:
    ...     with share() as one:
    ...         took(["cap: fan"])
    ...     with share() as kept:
    ...         took(["cap: grid"])
    ...     took(kept)
    >>> all_of_it
    {'cap: grid'}
    """
    names: set[str] = set()
    token = _shares.set(names)
    try:
        yield names
    finally:
        _shares.reset(token)


__all__ = ["is_on", "share", "took", "without"]
