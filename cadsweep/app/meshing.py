"""Making the mesh in a process of its own, watching it, ending it; a refusal, and what to try.

Place in the flow: works at the desk.
"""

from __future__ import annotations

import asyncio
from typing import Any

from ..errors import CadSweepError
from .desk import Desk
from .jobs import Job, StoppedError
from .refusing import find_tries, questioned, try_out
from .skins import make_view

_LOOK_EVERY = 0.25


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
        desk.trigger("take_try", self._take_try)

    def _forget(self) -> None:
        if self._desk.job is not None:
            self._desk.job.end()
        self._end_trials()
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
        self._end_trials()
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
        """Show a refusal: faces and cells in question on the part, what it says, and what helps, once that is tried."""
        desk = self._desk
        assert desk.part is not None
        text, lines = " ".join(error.message.split()), str(error).splitlines()
        desk.questioned = questioned(error, desk.part)
        desk.scene.mark_cell(list(getattr(error, "left", ())))
        desk.state.refusal = {
            "lines": lines,
            "all": text if text != " ".join(lines) else "",
            "reasons": list(getattr(error, "reasons", ()))[:40],
            "tries": [],
            "trying": "",
            "marked": bool(getattr(error, "left", ())),
        }
        self._show("part")
        desk.happened("picked")
        tries = find_tries(error, desk.session.asked, desk.part, desk.questioned)
        desk.trying = Job()
        desk.start(try_out(desk, desk.trying, tries))

    def _end_trials(self) -> None:
        """What was refused is asked no more: end what is tried for it, and take its cell away."""
        desk = self._desk
        trying, desk.trying, desk.helps = desk.trying, None, []
        if trying is not None:
            trying.end()
        desk.scene.mark_cell([])

    def _take_try(self, row: int) -> None:
        """Take a wish that was seen to help."""
        self._desk.session.ask(self._desk.helps[int(row)].asked)
        self._desk.happened("wishes")


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
