"""Why a command failed, for programs and in the words of the command line.

Messages are sentences that end with what to try; programs get that apart, and the faces that a message names.
"""

from __future__ import annotations

import re
from typing import Any

from ..errors import CadSweepError

_ADVICE = re.compile(
    r"(?:^|[;:.,]\s+|\bor\s+)"
    r"((?:try|take|repair|use|see|ask|name|say|export|choose|give|leave|make|mesh|pass|raise|lower|install|list)\b.*)$",
    re.IGNORECASE | re.DOTALL,
)
_FACE = re.compile(r"\bfaces?:? ((?:\d+)(?:(?:, | and )\d+)*)")
_SPECIAL = {
    "allow_inverted=True": "--allow-inverted",
    "smoothing=False": "--no-smoothing",
    "residual=False": "--no-residual",
    "isolated=True, ": "",
}
_RENAMED = {"sizes": "face-size", "counts": "edge-count", "params": "param"}
_ASSIGNED = re.compile(
    r"\b(size|layers|bias|fractions|functional|strategy|source|target|part|order|nodes|refine|touch|tolerance|max_hexes"
    r"|max_memory|timeout|screenshot|clip|limits|sizes|counts|rail_layers|biases|wall_layers|periodic|local_sizes|params)\s?=\s?('[^']*'|\"[^\"]*\"|[^\s,;()]+)"
)


def in_command_words(message: str) -> str:
    """A message with options of Python's functions written as those of the commands: ``--order 1`` for ``order=1``."""
    for spoken, written in _SPECIAL.items():
        message = message.replace(spoken, written)

    def option(match: re.Match[str]) -> str:
        name, value = match[1], match[2].strip("'\"")
        return f"--{_RENAMED.get(name, name).replace('_', '-')} " + (f"'{value}'" if " " in value else value)

    return _ASSIGNED.sub(option, message)


def describe_failure(error: CadSweepError) -> dict[str, Any]:
    """The error as ``--json`` prints it.

    Returns
    -------
    dict
        ``type``: the class of the error; ``message``: all of it, one line; ``hint``: the part that says what to try,
        empty where there is none; ``faces``: ids of the faces that it names, ascending.
    """
    message = in_command_words(" ".join(str(error).split()))
    advice = _ADVICE.search(message)
    said = " ".join([message, *getattr(error, "reasons", ())])
    faces = {int(number) for match in _FACE.finditer(said) for number in re.findall(r"\d+", match[1])}
    faces |= {int(face) for _, face in getattr(error, "faces", ())}
    return {
        "type": type(error).__name__,
        "message": message,
        "hint": "" if advice is None else advice[1].strip(),
        "faces": sorted(faces),
    }
