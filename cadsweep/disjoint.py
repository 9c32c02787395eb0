"""Sets that are joined two at a time: which things are one, as more is learnt."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

Item = TypeVar("Item")


class DisjointSets(Generic[Item]):
    """Items, each a set by itself at first (scipy has the same, behind a second of imports).

    Examples
    --------
    >>> sets = DisjointSets("abc")
    >>> sets.merge("a", "c")
    >>> sets.find("a") == sets.find("c"), sets.find("a") == sets.find("b")
    (True, False)
    """

    def __init__(self, items: Iterable[Item]) -> None:
        self._parent = {item: item for item in items}

    def find(self, item: Item) -> Item:
        """The item that stands for a set."""
        parent = self._parent
        while parent[item] != item:
            parent[item] = parent[parent[item]]
            item = parent[item]
        return item

    def merge(self, one: Item, other: Item) -> None:
        """Make two sets one, for which stands who stood for the `other`."""
        self._parent[self.find(one)] = self.find(other)
