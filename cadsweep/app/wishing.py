"""Wishes, made and taken back, each checked where it is typed; and what the mesh is expected to be.

Place in the flow: works at the desk.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

from ..errors import CadSweepError, InputError
from .desk import Desk
from .entities import tree_rows
from .wishes import KINDS, TAKES, WHOLE, check_options, make_wish, number, say

FIELDS = {"name": "", "size": "", "count": "", "ratio": "3", "towards": "both", "first": "", "growth": "1.2", "n": "6"}
_WHOLE_NUMBERS = ("layers", "order", "max_hexes")
_WAIT = 0.4
"""Seconds without a change after which the estimate is asked for."""


class Wishing:
    """Turns fields into wishes."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._estimating: asyncio.Task[None] | None = None
        self._last = ""
        empty = {f"f_{name}": value for name, value in FIELDS.items()}
        whole = {f"w_{name}": "" for name in WHOLE}
        problems = {f"p_{name}": "" for name in (*KINDS, *(f"whole_{one}" for one in WHOLE))}
        desk.state.update({**empty, **whole, **problems, "wishes": [], "can_undo": False, "can_redo": False})
        desk.state.update(
            {"estimate": "", "estimate_problem": "", "takes": {kind: list(t) for kind, t in TAKES.items()}}
        )
        desk.on("wishes", self._show)
        desk.trigger("wish", self._wish)
        desk.trigger("wish_whole", self._wish_whole)
        desk.trigger("wish_away", self._away)
        desk.trigger("undo", lambda: self._step("undo"))
        desk.trigger("redo", lambda: self._step("redo"))

    def _wish(self, kind: str, fields: Mapping[str, Any] | None = None) -> None:
        desk, state = self._desk, self._desk.state
        if desk.part is None:
            return
        state[f"p_{kind}"] = ""
        try:
            asked = desk.session.asked.with_wish(make_wish(kind, desk.picked, fields or {}, desk.part))
            check_options(asked.options(desk.part))
        except InputError as error:
            state[f"p_{kind}"] = str(error)
            return
        if kind == "name":
            state.f_name = ""
        self._ask(asked, f"p_{kind}")

    def _wish_whole(self, name: str, text: Any) -> None:
        desk, state = self._desk, self._desk.state
        if desk.part is None or name not in WHOLE:
            return
        state[f"p_whole_{name}"] = ""
        try:
            empty = not str(text if text is not None else "").strip()
            value = None if empty else number(text, "this", whole=name in _WHOLE_NUMBERS)
            if name == "order" and value == 1:
                value = None
            asked = desk.session.asked.with_whole(name, value)
            check_options(asked.options(desk.part))
        except InputError as error:
            state[f"p_whole_{name}"] = str(error)
            return
        self._ask(asked, f"p_whole_{name}")

    def _away(self, row: int) -> None:
        self._ask(self._desk.session.asked.without(int(row)))

    def _step(self, which: str) -> None:
        getattr(self._desk.session, which)()
        self._desk.happened("wishes")

    def _ask(self, asked: Any, problem: str = "") -> None:
        """Ask for something else; `problem` is where it is said if that cannot be had."""
        self._desk.session.ask(asked)
        self._desk.happened("wishes")
        self._last = problem

    def _show(self) -> None:
        desk, part = self._desk, self._desk.part
        if part is None:
            return
        asked, self._last = desk.session.asked, ""
        names = asked.given_names()
        desk.state.update(
            {
                "wishes": [
                    {"text": say(wish, part, names), "on": list(wish.on), "kind": wish.kind} for wish in asked.wishes
                ],
                "can_undo": desk.session.can_undo,
                "can_redo": desk.session.can_redo,
                "tree": tree_rows(part, names),
                **{f"w_{name}": _shown(asked.whole.get(name)) for name in WHOLE},
                **{f"p_{name}": "" for name in (*KINDS, *(f"whole_{one}" for one in WHOLE))},
                "estimate": "estimating ...",  # what was said of the wishes before is no word on these
                "estimate_problem": "",
            }
        )
        if self._estimating is not None:
            self._estimating.cancel()
        self._estimating = asyncio.get_running_loop().create_task(self._estimate())

    async def _estimate(self) -> None:
        desk = self._desk
        assert desk.part is not None
        await asyncio.sleep(_WAIT)
        try:
            found = await desk.jobs.read(
                "estimate", desk.source, desk.session.asked.options(desk.part, desk.session.params)
            )
            desk.state.update({"estimate": found, "estimate_problem": ""})
        except CadSweepError as error:
            # What was asked last is what cannot be had beside the rest: it is said at its field.
            place = self._last if isinstance(error, InputError) and self._last else "estimate_problem"
            desk.state.update({"estimate": "", "estimate_problem": "", place: " ".join(str(error).split())})
        desk.state.flush()


def _shown(value: Any) -> str:
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
