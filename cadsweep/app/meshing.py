"""Making the mesh in a process of its own, watching it, ending it; a refusal, and what to try.

Place in the flow: works at the desk.
"""

from __future__ import annotations

import asyncio
import re
from typing import Any

from ..errors import CadSweepError
from .desk import Desk
from .jobs import Job, StoppedError
from .skins import make_view

_LOOK_EVERY = 0.25
_MOST_FACES = 200
_FACE = re.compile(r"\bfaces?:? ((?:\d+)(?:(?:, | and )\d+)*)")
_SUPPRESS = re.compile(r"suppress=\[([^\]]*)\]")
_SIZE = re.compile(r"\bsize (?:of )?([\d.]+(?:e-?\d+)?)")


class Meshing:
    """One mesh at a time."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        desk.state.update(
            {"meshing": False, "stages": [], "job_seconds": 0, "refusal": None, "showing": "part", "has_mesh": False}
        )
        desk.state.update({"stale": False, "questioned": [], "mesh_notes": []})
        desk.on("part", self._forget)
        desk.on("wishes", self._show_stale)
        desk.trigger("mesh", lambda: desk.start(self._mesh()))
        desk.trigger("end", self._end)
        desk.trigger("show", self._show)

    def _forget(self) -> None:
        if self._desk.job is not None:
            self._desk.job.end()
        self._desk.state.update({"has_mesh": False, "refusal": None, "showing": "part", "stages": [], "stale": False})
        self._desk.scene.set_surface("mesh", None)

    def _show_stale(self) -> None:
        self._desk.state.stale = self._desk.made is not None and self._desk.made != self._desk.session.asked

    def _end(self) -> None:
        if self._desk.job is not None:
            self._desk.job.end()

    def _show(self, what: str) -> None:
        if what == "mesh" and self._desk.view is None:
            return
        self._desk.state.showing = what
        self._desk.scene.show_part(what == "part")
        self._desk.happened("look")
        self._desk.push()

    async def _mesh(self) -> None:
        desk = self._desk
        if desk.part is None or desk.job is not None:
            return
        asked = desk.session.asked
        options = asked.options(desk.part, desk.session.params)
        desk.job = job = Job()
        desk.questioned = []
        desk.state.update({"meshing": True, "refusal": None, "tab": "mesh", "message": ""})
        watching = asyncio.get_running_loop().create_task(self._watch(job))
        try:
            mesh, distances = await desk.jobs.work(job, "make_mesh", desk.source, options)
            desk.state.stages = [*_stages(job), {"name": "looking at it", "seconds": "", "done": False, "share": ""}]
            desk.state.flush()
            view = await desk.jobs.compute(lambda: make_view(mesh, distances))
        except StoppedError:
            desk.say("The run was ended; nothing is left of it.")
            return
        except CadSweepError as error:
            self._refuse(error)
            return
        finally:
            watching.cancel()
            desk.job = None
            desk.state.update({"meshing": False, "stages": _stages(job)})
            desk.state.flush()
        desk.mesh, desk.view, desk.made = mesh, view, asked
        desk.state.update({"has_mesh": True, "tab": "look", "mesh_notes": list(mesh.info.get("notes", []))})
        self._show_stale()
        desk.happened("mesh")
        self._show("mesh")
        desk.happened("picked")

    async def _watch(self, job: Job) -> None:
        while True:
            self._desk.state.update({"stages": _stages(job), "job_seconds": round(job.seconds, 1)})
            self._desk.state.flush()
            await asyncio.sleep(_LOOK_EVERY)

    def _refuse(self, error: CadSweepError) -> None:
        """Show a refusal: the faces in question on the part, what it says, and what to try as buttons."""
        desk = self._desk
        assert desk.part is not None
        text, lines = " ".join(error.message.split()), str(error).splitlines()
        desk.questioned = _questioned(error, desk)
        desk.state.refusal = {
            "lines": lines,
            "all": text if text != " ".join(lines) else "",
            "reasons": list(getattr(error, "reasons", ()))[:40],
            "tries": _tries(text, desk),
        }
        self._show("part")
        desk.happened("picked")


def _stages(job: Job) -> list[dict[str, Any]]:
    """A row for each stage; one that says after a comma what it is at is one row, however often it says so."""
    rows: list[dict[str, Any]] = []
    last = len(job.stages) - 1
    for j, stage in enumerate(job.stages):
        name, _, at = stage.name.partition(", ")
        if not rows or rows[-1]["name"] != name:
            rows.append({"name": name, "seconds": 0.0})
        under_way = j == last and stage.ended is None
        share = f"{stage.fraction:.0%}" if under_way and stage.fraction not in (None, 0.0, 1.0) else ""
        rows[-1].update(
            seconds=rows[-1]["seconds"] + stage.seconds, done=not under_way, share=share or (at if under_way else "")
        )
    return [{**row, "seconds": f"{row['seconds']:.1f}"} for row in rows]


def _questioned(error: CadSweepError, desk: Desk) -> list[str]:
    """Keys of the faces that a refusal names by number or carries, of the solids that it names."""
    assert desk.part is not None
    said = re.sub(r"\bThere are: .*$", "", str(error), flags=re.DOTALL)
    carried = [(None, int(n)) for m in _FACE.finditer(said) for n in re.findall(r"\d+", m[1])]
    carried += [face if isinstance(face, tuple) else (None, face) for face in getattr(error, "faces", ())]
    named = [solid.solid for solid in desk.part.solids if solid.name in getattr(error, "solids", ())]
    solids = named or range(len(desk.part.solids))
    keys = [
        f"face:{solid}:{face}"
        for cell, face in carried
        for solid in ([cell] if cell is not None and not named else solids)
    ]
    return [key for key in dict.fromkeys(keys) if key in desk.part.entities][:_MOST_FACES]


def _tries(text: str, desk: Desk) -> list[dict[str, str]]:
    """What to try, as a label and the trigger's arguments."""
    found = []
    for match in _SUPPRESS.finditer(text):
        for words in re.findall(r"'([^']*)'", match[1]):
            found.append({"label": f"leave out {words}", "kind": "suppress", "words": words})
    for match in _SIZE.finditer(text):
        found.append({"label": f"take size {match[1]}", "kind": "whole_size", "words": match[1]})
    assert desk.part is not None
    for key in desk.questioned[:2]:
        word = desk.part.id_word(key)
        found.append({"label": f"leave {word} out", "kind": "suppress", "words": word})
        if desk.part.entities[key].shape == "plane":
            found.append({"label": f"cut along {word}", "kind": "cut", "words": word})
    size = desk.session.asked.whole.get("size")
    if size and not any(one["kind"] == "whole_size" for one in found):
        half = f"{size / 2:g}"
        found.append({"label": f"take size {half}", "kind": "whole_size", "words": half})
    return found[:6]
