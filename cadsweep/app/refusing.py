"""A refusal on the page: the faces and cells in question, and what helps, which was tried before it is offered.

Place in the flow: called by :mod:`.meshing`; trials are made by a child process.
"""

from __future__ import annotations

import asyncio
import re
from dataclasses import dataclass
from typing import Any

from ..errors import CadSweepError
from .desk import Desk
from .entities import PartData
from .jobs import Job
from .wishes import Asked, Wish

SECONDS = 60.0
"""After which nothing more is tried, and what is under way is ended."""
_LOOK_EVERY = 0.25
_MOST_FACES = 200
_MOST_TRIES = 6
_BLAMED = 2
"""Faces in question that are left out or cut along to see whether that helps."""
_FINER = 30
"""Part of the part's size that is tried as the size where none is asked for."""
_FACE = re.compile(r"\bfaces?:? ((?:\d+)(?:(?:, | and )\d+)*)")
_WORDS = re.compile(r"\b(suppress|cuts)=\[([^\]]*)\]")
_SIZE = re.compile(r"\bsize(?: of |=| )([\d.]+(?:e-?\d+)?)")


@dataclass(frozen=True, kw_only=True)
class Try:
    """Something that may help: what its button says, and the wishes with it."""

    label: str
    asked: Asked


def questioned(error: CadSweepError, part: PartData) -> list[str]:
    """Keys of the faces that a refusal names by number or carries, of the solids that it names."""
    said = re.sub(r"\bThere are: .*$", "", str(error), flags=re.DOTALL)
    carried: list[tuple[int | None, int]] = [
        (None, int(n)) for m in _FACE.finditer(said) for n in re.findall(r"\d+", m[1])
    ]
    carried += [face if isinstance(face, tuple) else (None, face) for face in getattr(error, "faces", ())]
    named = [solid.solid for solid in part.solids if solid.name in getattr(error, "solids", ())]
    solids = named or range(len(part.solids))
    keys = [
        f"face:{solid}:{face}"
        for cell, face in carried
        for solid in ([cell] if cell is not None and not named else solids)
    ]
    return [key for key in dict.fromkeys(keys) if key in part.entities][:_MOST_FACES]


def find_tries(error: CadSweepError, asked: Asked, part: PartData, faces: list[str]) -> list[Try]:
    """What may help, the likeliest first: what the refusal says, the faces in question, other sizes."""
    text = " ".join(error.message.split())
    found: dict[str, Asked] = {}
    for match in _WORDS.finditer(text):
        kind, verb = ("suppress", "leave out") if match[1] == "suppress" else ("cut", "cut along")
        words = re.findall(r"'([^']*)'", match[2])
        wished = asked
        for word in words:
            wished = wished.with_wish(Wish(kind=kind, value=word))
        if words:
            found[f"{verb} {', '.join(words)}"] = wished
    for match in _SIZE.finditer(text):
        found[f"take size {match[1]}"] = asked.with_whole("size", float(match[1]))
    for key in faces[:_BLAMED]:
        word = part.id_word(key)
        found.setdefault(f"leave out {word}", asked.with_wish(Wish(kind="suppress", on=(key,))))
        if part.entities[key].shape == "plane":
            found.setdefault(f"cut along {word}", asked.with_wish(Wish(kind="cut", on=(key,))))
    size = asked.whole.get("size")
    half = float(f"{(size / 2 if size else part.size / _FINER):.2g}")
    found.setdefault(f"take size {half:g}", asked.with_whole("size", half))
    if size:
        found["take no size"] = asked.with_whole("size", None)
    return [Try(label=label, asked=wished) for label, wished in found.items() if wished != asked][:_MOST_TRIES]


async def try_out(desk: Desk, job: Job, tries: list[Try]) -> None:
    """Make a mesh with each, and offer those that have one as they are found."""
    assert desk.part is not None
    options = [one.asked.options(desk.part, desk.session.params) for one in tries]
    watching = asyncio.get_running_loop().create_task(_watch(desk, job, tries))
    try:
        await asyncio.wait_for(desk.jobs.work(job, "try_out", desk.source, options), SECONDS)
    except TimeoutError:
        job.end()
    finally:
        watching.cancel()
        _offer(desk, job, tries, over=True)


async def _watch(desk: Desk, job: Job, tries: list[Try]) -> None:
    while True:
        _offer(desk, job, tries, over=False)
        await asyncio.sleep(_LOOK_EVERY)


def _offer(desk: Desk, job: Job, tries: list[Try], *, over: bool) -> None:
    """Show the buttons of those that help, and how far the trials have come."""
    if desk.trying is not job or desk.state.refusal is None:
        return
    answers = [stage.name for stage in job.stages if stage.name.startswith(("yes ", "no "))]
    helps = [int(answer.split()[1]) for answer in answers if answer.startswith("yes ")]
    if over:
        said = "" if helps else "None of what could be tried helps."
    else:
        said = f"Trying what may help: {len(answers)} of {len(tries)} ..."
    desk.helps = [tries[j] for j in helps]
    rows: list[dict[str, Any]] = [{"label": one.label} for one in desk.helps]
    desk.state.refusal = {**desk.state.refusal, "tries": rows, "trying": said}
    desk.state.flush()
