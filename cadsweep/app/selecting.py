"""Picking, in the picture and in the tree alike.

Place in the flow: works at the desk; what is picked is what wishes are about.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from .desk import Desk
from .entities import KINDS, all_tangent, described, same_kind
from .picking import pick


class Selecting:
    """Keeps what is picked and what is under the pointer."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        desk.state.update(
            {"picked": [], "picked_text": "nothing", "picked_kind": "", "hovered": "", "kind": "face", "selector": ""}
        )
        desk.on("picked", self._show)
        desk.on("wishes", self._show)
        desk.trigger("pick_at", self._pick_at)
        desk.trigger("hover_at", self._hover_at)
        desk.trigger("hover", self._hover)
        desk.trigger("pick", self._pick)
        desk.trigger("pick_none", lambda: self._take([]))
        desk.trigger("pick_kind", self._set_kind)
        desk.trigger("pick_tangent", lambda: self._grow(all_tangent))
        desk.trigger("pick_alike", lambda: self._grow(same_kind))
        desk.trigger("pick_named", self._pick_named)
        desk.trigger("pick_words", lambda words: desk.start(self._pick_words(str(words))))

    def _seen_at(self, start: Sequence[float], end: Sequence[float], width: float) -> str | None:
        desk = self._desk
        if desk.part is None or desk.state.showing != "part":
            return None
        kind = desk.state.kind
        return pick(desk.part, np.array(start, float), np.array(end, float), kind=kind, width=float(width))

    def _pick_at(self, start: Sequence[float], end: Sequence[float], width: float, more: bool) -> None:
        key = self._seen_at(start, end, width)
        if key is not None:
            self._pick(key, more)
        elif not more and self._desk.state.showing == "part":
            self._take([])

    def _pick(self, key: str, more: bool = False) -> None:
        """Pick a thing; with `more` beside the others, or let go of it."""
        part = self._desk.part
        if part is None or key not in part.entities:
            return
        if more:
            kept = [one for one in self._desk.picked if one != key]
            self._take(kept if len(kept) < len(self._desk.picked) else [*kept, key])
        else:
            self._take([] if self._desk.picked == [key] else [key])

    def _hover_at(self, start: Sequence[float], end: Sequence[float], width: float) -> None:
        self._hover(self._seen_at(start, end, width) or "")

    def _hover(self, key: str) -> None:
        desk = self._desk
        if desk.part is None or (key or None) == desk.hovered or (key and key not in desk.part.entities):
            return
        desk.hovered = key or None
        desk.state.hovered = key
        desk.recolor()

    def _set_kind(self, kind: str) -> None:
        if kind not in KINDS:
            raise InputError(f"there is no kind '{kind}'")
        self._desk.state.kind = kind

    def _grow(self, how: object) -> None:
        desk = self._desk
        if desk.part is None or not desk.picked:
            raise InputError("pick something first")
        assert callable(how)
        self._take(how(desk.part, desk.picked))

    def _pick_named(self) -> None:
        """Everything that has the names of what is picked."""
        desk = self._desk
        if desk.part is None or not desk.picked:
            raise InputError("pick something first")
        names = {desk.part.entities[key].name for key in desk.picked} - {""}
        if not names:
            raise InputError("what is picked has no name")
        self._take([key for key, entity in desk.part.entities.items() if entity.name in names])

    async def _pick_words(self, words: str) -> None:
        desk = self._desk
        if desk.part is None:
            return
        if not words.strip():
            raise InputError("write a CadQuery selector such as >Z or |X, a name, or 'face 7'")
        kind = "edge" if desk.state.kind == "edge" or words.startswith("edge ") else "face"
        found = await desk.jobs.read(
            "select", desk.source, words.strip(), kind=kind, params=desk.session.params or None
        )
        self._take(found)

    def _take(self, keys: list[str]) -> None:
        self._desk.picked = keys
        self._desk.happened("picked")

    def _show(self) -> None:
        desk = self._desk
        kinds = {key.split(":")[0] for key in desk.picked}
        desk.state.update(
            {
                "picked": list(desk.picked),
                "picked_text": (
                    described(desk.part, desk.picked, desk.session.asked.given_names()) if desk.part else "nothing"
                ),
                "picked_kind": kinds.pop() if len(kinds) == 1 else "mixed" if kinds else "",
                "questioned": list(desk.questioned),
            }
        )
        desk.recolor()
