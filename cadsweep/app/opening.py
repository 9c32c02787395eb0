"""Opening a part or a session: what is a program is asked for first, what is damaged is said.

Place in the flow: works at the desk; the file is read by a child process.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import CadSweepError, InputError
from .desk import Desk
from .entities import tree_rows
from .files import Files
from .session import Session

SCRIPT = ".py"
SESSION = ".cadsweep.json"


class Opening:
    """Reads parts and sessions."""

    def __init__(self, desk: Desk, files: Files) -> None:
        self._desk, self._files = desk, files
        self._waiting: tuple[Any, Session] | None = None
        desk.state.update(
            {"phase": "empty", "source": "", "tree": [], "consent": "", "path": "", "part_name": "", "part_notes": []}
        )
        desk.trigger("open_path", lambda path: desk.start(self.open(str(path).strip().strip("'\""))))
        desk.trigger("open_up", lambda key: desk.start(self._open_up(str(key))))
        desk.trigger("consent", self._consent)
        desk.trigger("close_part", self._close)

    async def open(self, source: Any, session: Session | None = None) -> None:
        """Open a file, a session file, or an object."""
        if isinstance(source, str):
            if not source:
                raise InputError("name a file: its path, or choose it with the button")
            if source.endswith(SESSION) or source.endswith(".json"):
                await self._open_session(Path(source))
                return
            source = str(Path(source).expanduser().resolve())
        session = session or Session()
        session.source = source if isinstance(source, str) else ""
        if isinstance(source, str) and source.lower().endswith(SCRIPT):
            self._waiting = (source, session)
            self._desk.state.update({"phase": "consent", "consent": source})
            self._desk.state.flush()
            return
        await self._read(source, session)

    async def _open_up(self, key: str) -> None:
        path = self._files.taken(key)
        if path is None:
            raise InputError("the file has not arrived; choose it again")
        await self.open(str(path))

    async def _open_session(self, path: Path) -> None:
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"{path.name} cannot be read: {error}") from error
        session = Session.from_json(text)
        if not session.source:
            raise InputError("the session was of an object of a program: open it from there")
        if not Path(session.source).is_file():
            beside = path.parent / Path(session.source).name
            if not beside.is_file():
                raise InputError(f"the session is about {session.source}, which is not there any more")
            session.source = str(beside)
        await self.open(session.source, session)

    def _consent(self, agreed: bool) -> None:
        waiting, self._waiting = self._waiting, None
        self._desk.state.consent = ""
        if waiting is None or not agreed:
            self._desk.state.phase = "part" if self._desk.part else "empty"
            return
        self._desk.start(self._read(*waiting))

    async def _read(self, source: Any, session: Session) -> None:
        desk = self._desk
        name = Path(source).name if isinstance(source, str) else "the part"
        desk.state.update({"phase": "reading", "source": name, "message": ""})
        desk.state.flush()
        try:
            part = await desk.jobs.read("describe", source, params=session.params or None)
        except CadSweepError:
            desk.state.phase = "part" if desk.part else "empty"
            raise
        unknown = [key for wish in session.asked.wishes for key in wish.on if key not in part.entities]
        if unknown:
            desk.state.phase = "part" if desk.part else "empty"
            raise InputError(f"the session is about another part: there is no {unknown[0].replace(':', ' ')} in {name}")
        desk.source, desk.part, desk.session = source, part, session
        desk.mesh = desk.view = desk.made = None
        desk.picked, desk.hovered, desk.questioned = [], None, []
        desk.scene.set_part(part)
        desk.state.update(
            {
                "phase": "part",
                "tab": "ask",
                "part_name": part.name,
                "trame__title": f"{part.name} - cadsweep",
                "tree": tree_rows(part, session.asked.given_names()),
                "part_notes": list(part.notes),
                "n_solids": len(part.solids),
            }
        )
        desk.happened("part")
        desk.happened("wishes")
        desk.happened("picked")
        desk.push()
        desk.state.flush()

    def _close(self) -> None:
        self._desk.state.phase = "empty"
