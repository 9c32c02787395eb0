"""The table of families of cutters: each has a name by which it can be switched off, and by which a mesh tells of it.

Place in the flow: :mod:`.cutters` asks one family after the other for the cutters of a cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from ... import rows
from .central import Cutter

FAMILIES = (
    "columns",
    "strips",
    "spokes",
    "ports",
    "centres",
    "gaps",
    "regions",
    "boxes",
    "grids",
    "beside holes",
    "mitres",
    "around bores",
    "crossings",
    "rims",
    "batches",
    "edges",
    "cushions",
    "axes",
    "stars",
)
"""Names, about in the order in which the families are tried."""


def family(name: str, find: Callable[[], Iterable[Cutter]]) -> Iterator[Cutter]:
    """The cutters of a family, each with its name; none where it is switched off."""
    assert name in FAMILIES
    if rows.is_on(f"cut: {name}"):
        for cutter in find():
            yield replace(cutter, family=name)
