"""What a value lets others do for it: write it, draw it, measure it, show it in a notebook.

A value (a part, a sweep, a mesh, a report) stands below the rooms that know how, which import it and may not be
imported by it. It says the verb; the package's ``__init__``, which is above all rooms, says where the verb lives.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_find: list[Callable[[str], Callable[..., Any]]] = []


def look_up_by(find: Callable[[str], Callable[..., Any]]) -> None:
    """Say what finds the function of a verb."""
    _find[:] = [find]


def do(verb: str, *args: Any, **options: Any) -> Any:
    """Do what a verb names, as its room does it."""
    return _find[0](verb)(*args, **options)
