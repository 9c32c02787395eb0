"""What the parts of a page's control share: the session, the part, the mesh, the scene, and how the page is told.

Place in the flow: made by :mod:`.server`; :mod:`.opening`, :mod:`.wishing`, :mod:`.meshing`, :mod:`.looking` and
:mod:`.exporting` work at it, each of which registers the triggers that the page's elements pull.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from ..mesh import HexMesh
from .entities import PartData
from .jobs import Job, Jobs
from .scene import Scene
from .session import Session
from .skins import MeshView

log = logging.getLogger(__name__)


@dataclass(kw_only=True, eq=False)
class Desk:
    """The work on one part.

    Attributes
    ----------
    server : trame's server
    folder : Path
        Temporary, of this server alone: what was handed up, what is handed down.
    source : str or object
        What children are given to read: a path, or an object of the program that opened the page.
    part, mesh, view
        What is open; the mesh, and how it is looked at.
    made : Asked or None
        The wishes that the mesh was made with.
    picked : list of str
        Keys, in the order in which they were picked.
    trying, helps
        What is tried after a refusal, and what of it was seen to help.
    push : callable
        Sends what has changed in the scene to all pages.
    """

    server: Any
    folder: Path
    jobs: Jobs
    scene: Scene
    session: Session = field(default_factory=Session)
    source: Any = None
    part: PartData | None = None
    mesh: HexMesh | None = None
    view: MeshView | None = None
    made: Any = None
    job: Job | None = None
    picked: list[str] = field(default_factory=list)
    hovered: str | None = None
    questioned: list[str] = field(default_factory=list)
    trying: Job | None = None
    helps: list[Any] = field(default_factory=list)
    push: Callable[[], None] = lambda: None
    listeners: dict[str, list[Callable[[], None]]] = field(default_factory=dict)
    _tasks: set[asyncio.Task[None]] = field(default_factory=set)

    @property
    def state(self) -> Any:
        """trame's state: what every page shows."""
        return self.server.state

    def on(self, event: str, call: Callable[[], None]) -> None:
        """Call a function whenever something has happened: ``part``, ``wishes``, ``mesh``, ``picked``."""
        self.listeners.setdefault(event, []).append(call)

    def happened(self, event: str) -> None:
        """Tell those who wait for it."""
        for call in self.listeners.get(event, ()):
            call()

    def trigger(self, name: str, call: Callable[..., Any]) -> None:
        """Have a function called by the page; what goes wrong in it is said on the page, never as a traceback."""

        async def safely(*args: Any) -> None:
            with self.state:
                self.state.message = ""
            await self.guarded(lambda: call(*args))

        self.server.trigger(name)(safely)

    async def guarded(self, call: Callable[[], Any]) -> None:
        """Call, and say on the page what went wrong."""
        try:
            found = call()
            if isinstance(found, Awaitable):
                await found
        except CadSweepError as error:
            self.say(str(error), kind="error")
        except Exception as error:
            log.exception("the page")
            self.say(f"This was not foreseen ({type(error).__name__}); please report it with the part.", kind="error")
        self.state.flush()

    def say(self, text: str, *, kind: str = "note") -> None:
        """Show a line on the page until it is clicked away."""
        self.state.message = " ".join(text.split())
        self.state.message_kind = kind
        self.state.flush()

    def start(self, work: Awaitable[None]) -> None:
        """Begin something that takes longer than a request."""

        async def run() -> None:
            await self.guarded(lambda: work)

        task = asyncio.get_running_loop().create_task(run())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def recolor(self) -> None:
        """Show in the picture what is picked, under the pointer and in question."""
        self.scene.color_part(self.picked, self.hovered, dict.fromkeys(self.questioned))
        self.push()
