"""Why a command failed, for programs and in the words of the command line.

Messages are sentences that end with what to try; programs get that apart, and the faces that a message names.
"""

from __future__ import annotations

import re
from typing import Any

from ..errors import CadSweepError

_VERBS = (
    "try|take|repair|use|see|ask|name|say|export|choose|give|leave|make|mesh|pass|raise|lower|install|list|write"
    r"|cut(?= (?:it|one|out|there|the)\b)"
    "|copy|remove|split|look|look for|save|show|select|keep|end|extrude|close|merge|model|vary|drop|allow|move|turn"
    "|check|change|free|wait|set|add|put|run|start|open|rename|call|divide|draw|read|fill|refine|match|join"
    "|did you mean|possible options|there are|there is a|known|wanted|pip install|its parameters"
    "|the solids are|shards are"
)
"""Words that begin the part of a message that says what to try, or lists what there is."""
_ADVICE = re.compile(rf"(?:^|[;:.,(]\s*|\bor\s+)(?<![\w-])((?:{_VERBS})(?![\w=-]).*)$", re.IGNORECASE | re.DOTALL)
_RULE = re.compile(
    r"(?:^|[;:,]\s+)([^;:,]*\b(?:must|should|needs?|goes? with|go with|belongs? to)\b.*|[^;:]+, not [^,]+)$", re.DOTALL
)
"""Advice of messages that say what has to be, and nothing else."""
_FACE = re.compile(r"\bfaces?:? ((?:\d+)(?:(?:, | and )\d+)*)")
_CHOICES = re.compile(r"\bThere are: .*$", re.DOTALL)
"""Faces that could be chosen are not in the way."""
_SPECIAL = {
    "allow_inverted=True": "--allow-inverted",
    "allow_coarse=True": "--allow-coarse",
    "smoothing=False": "--no-smoothing",
    "residual=False": "--no-residual",
    "decompose=False": "--no-decompose",
    "fitted=True": "--fitted",
    "isolated=True, ": "",
    "same_mesh=True": "same_mesh = true",
    "structured=True": "--structured",
}
_RENAMED = {
    "sizes": "face-size",
    "counts": "edge-count",
    "biases": "edge-bias",
    "local_sizes": "local-size",
    "params": "param",
    "cuts": "cut",
    "patch_types": "patch-type",
    "letters": "letter",
}
_NAMES = (
    "size|layers|bias|fractions|functional|strategy|source|target|part|order|nodes|refine|touch|tolerance|bridge|max_hexes"
    "|max_memory|timeout|screenshot|clip|crinkle|explode|limits|sizes|counts|rail_layers|biases|wall_layers|periodic"
    "|local_sizes|params|cuts|suppress|only|skip|interfaces|decompose_time|like|scale|units|patch_types|letters|max_blocks"
)
_VALUE = r"\[[^\]]*\]|'[^']*'|\"[^\"]*\"|\.\.\.|[^\s,;:()]*[^\s,;:().]"
_BOTH = re.compile(rf"\b[a-z_]+\s?=\s?(?:{_VALUE}|True)?(?: \((--[^()]*)\)|, or (--[a-z-]+))")
"""What is said for Python and for the command line: ``skip=['pin'] (--skip pin)``."""
_ASSIGNED = re.compile(rf"\b({_NAMES})\s?=(?:\s?({_VALUE}))?")
_LED = re.compile(rf"(^|[;.] )({_NAMES}):(?= )")
"""An option that leads a sentence about its value: ``counts: edge 3 ...``."""


_LEADING = {"sizes": "--size, --face-size or --edge-size"}


def in_command_words(message: str) -> str:
    """A message with options of Python's functions written as those of the commands: ``--order 1`` for ``order=1``."""
    message = _BOTH.sub(lambda match: match[1] or match[2], message)
    for spoken, written in _SPECIAL.items():
        message = message.replace(spoken, written)

    def flag(name: str) -> str:
        return f"--{_RENAMED.get(name, name).replace('_', '-')}"

    def option(match: re.Match[str]) -> str:
        values = (match[2] or "").strip("[]").split(", ") if (match[2] or "").startswith("[") else [match[2] or ""]
        values = [value.strip("'\"") for value in values]
        if match[1] in ("cuts", "suppress"):  # options that are repeated
            return " ".join(f"{flag(match[1])} '{value}'" for value in values)
        value = ",".join(values)
        return f"{flag(match[1])} '{value}'" if " " in value else f"{flag(match[1])} {value}".rstrip()

    message = _ASSIGNED.sub(option, message)
    return _LED.sub(lambda match: f"{match[1]}{_LEADING.get(match[2]) or flag(match[2])}:", message)


def describe_failure(error: CadSweepError) -> dict[str, Any]:
    """The error as ``--json`` prints it.

    Returns
    -------
    dict
        ``type``: the class of the error; ``message``: all of it, one line; ``what``, ``where``: what cannot be had, and
        the face or the place, empty where the message has it; ``hint``: the part that says what to try, or what has to
        be, empty where there is none; ``faces``: ids of the faces that are in the way, the worst first, or of all that
        it names; ``reasons``: the long form, a line for each face, direction, cell and cut that was looked at.
    """
    message = in_command_words(error.message)
    answer = {
        "type": type(error).__name__,
        "message": message,
        "what": in_command_words(error.what),
        "where": error.where,
        "hint": in_command_words(error.try_) or _hint(message),
        "reasons": [in_command_words(reason) for reason in error.reasons],
    }
    given = getattr(error, "faces", ())
    faces = [face for face in given if not isinstance(face, tuple)]
    faces = faces or sorted({int(face) for _, face in given})
    if not faces:
        said = " ".join([_CHOICES.sub("", message), *error.reasons])
        faces = sorted({int(number) for match in _FACE.finditer(said) for number in re.findall(r"\d+", match[1])})
    return {**answer, "faces": faces}


def describe_misuse(message: str) -> dict[str, Any]:
    """An error in how the command was called, as ``--json`` prints it."""
    message = " ".join(message.split())
    told = {"type": "UsageError", "message": message, "what": message, "where": "", "hint": _hint(message)}
    return {**told, "faces": [], "reasons": []}


def _hint(message: str) -> str:
    """The part of a message that says what to try, or what has to be."""
    found = _ADVICE.search(message) or _RULE.search(message)
    if found is None:
        return ""
    hint = found[1].strip()
    return in_command_words(hint.removesuffix(")") if hint.count(")") > hint.count("(") else hint)
