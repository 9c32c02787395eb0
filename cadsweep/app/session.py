"""The wishes of a session with their history, and the file that a session is kept in.

Place in the flow: between the page and everything that is made; knows no browser and no CAD.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from .._version import __version__
from ..errors import InputError
from .wishes import KINDS, WHOLE, Asked, Wish

FORMAT = "cadsweep session 1"


@dataclass(kw_only=True, eq=False)
class Session:
    """What has been asked, and what was asked before and after.

    Attributes
    ----------
    source : str
        The file that is open; empty where none is, or where it is an object of a program.
    params : dict
        Parameters of a script.
    """

    source: str = ""
    params: dict[str, Any] = field(default_factory=dict)
    _states: list[Asked] = field(default_factory=lambda: [Asked()])
    _at: int = 0

    @property
    def asked(self) -> Asked:
        """The wishes that hold now."""
        return self._states[self._at]

    def ask(self, asked: Asked) -> None:
        """Take other wishes; what was undone before is forgotten."""
        if asked == self.asked:
            return
        del self._states[self._at + 1 :]
        self._states.append(asked)
        self._at += 1

    @property
    def can_undo(self) -> bool:
        """Whether there are wishes before these."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether wishes were undone."""
        return self._at + 1 < len(self._states)

    def undo(self) -> None:
        """Go back by one change, where there is one."""
        self._at = max(0, self._at - 1)

    def redo(self) -> None:
        """Take back what was undone."""
        self._at = min(len(self._states) - 1, self._at + 1)

    def to_json(self) -> str:
        """The session as text: the file, the parameters, the wishes; without their history."""
        return json.dumps(
            {
                "format": FORMAT,
                "version": __version__,
                "source": self.source,
                "params": self.params,
                "whole": dict(self.asked.whole),
                "wishes": [asdict(wish) for wish in self.asked.wishes],
            },
            indent=1,
        )

    @classmethod
    def from_json(cls, text: str) -> Session:
        """A session from its text.

        Raises
        ------
        InputError
            It is no session file, or a damaged one.
        """
        try:
            data = json.loads(text)
        except ValueError as error:
            raise InputError(f"this is no session file: {error}") from error
        if not isinstance(data, Mapping) or data.get("format") != FORMAT:
            raise InputError(f"this is no session file of cadsweep ('{FORMAT}')")
        try:
            wishes = tuple(_wish(one) for one in data["wishes"])
            whole = {name: data["whole"][name] for name in WHOLE if name in data["whole"]}
            made = cls(source=str(data["source"]), params=dict(data["params"]))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"the session file is damaged: {error}") from error
        made.ask(Asked(wishes=wishes, whole=whole))
        return made


def _wish(data: Mapping[str, Any]) -> Wish:
    if data["kind"] not in KINDS:
        raise ValueError(f"there is no wish '{data['kind']}'")
    return Wish(kind=data["kind"], on=tuple(map(str, data["on"])), value=data["value"])
