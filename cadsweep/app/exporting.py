"""Taking away: meshes in any format, the report, the command line, the script, the session.

Place in the flow: works at the desk; files are written by a child process into the server's temporary folder, and
handed down to the browser.
"""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from ..io import FORMATS
from ..isolation import leftovers
from .desk import Desk
from .files import Files
from .opening import SESSION
from .taking import to_command, to_script

_ONE_PROCESS = (".pvtu",)
"""Formats of runs over several processes."""


class Exporting:
    """Writes what is asked for by its file name."""

    def __init__(self, desk: Desk, files: Files) -> None:
        self._desk, self._files = desk, files
        formats = [
            {"suffix": suffix, "text": f"{suffix}: {text}"}
            for suffix, text in FORMATS.items()
            if suffix not in _ONE_PROCESS
        ]
        desk.state.update({"formats": formats, "format": ".inp", "command": "", "script": "", "stem": "part"})
        desk.on("wishes", self._show)
        desk.trigger("format", self._set_format)

    @property
    def stem(self) -> str:
        """The name of files without a suffix."""
        desk = self._desk
        name = Path(desk.session.source).stem if desk.session.source else (desk.part.name if desk.part else "part")
        return name.removesuffix(".cadsweep") or "part"

    def _set_format(self, suffix: str) -> None:
        if suffix not in FORMATS:
            raise InputError(f"there is no format '{suffix}'")
        self._desk.state.format = suffix
        self._show()

    def _show(self) -> None:
        desk = self._desk
        if desk.part is None:
            return
        options = desk.session.asked.options(desk.part, desk.session.params)
        suffix = str(desk.state.format)
        output = "polyMesh" if suffix == ".polymesh" else self.stem + suffix
        source = desk.session.source
        desk.state.update(
            {
                "command": to_command(source, output, options) if source else "",
                "script": to_script(source, output, options),
                "stem": self.stem,
            }
        )

    async def make(self, name: str) -> Path:
        """Write a file of this name: the suffix says what it is.

        Raises
        ------
        CadSweepError
            There is no mesh yet, or the format cannot hold it.
        """
        desk = self._desk
        if desk.part is None:
            raise InputError("open a part first")
        place = self._files.new_place(name)
        if name.endswith(SESSION):
            place.write_text(desk.session.to_json(), encoding="utf-8")
            return place
        if name.endswith(".py"):
            place.write_text(str(desk.state.script), encoding="utf-8")
            return place
        if place.suffix.lower() not in (*FORMATS, ".html") and place.name != "polyMesh":
            raise InputError(f"there is no format '{place.suffix}'")
        if desk.mesh is None:
            raise InputError("make the mesh first")
        await desk.jobs.read(
            "write_mesh", desk.mesh, str(place), command=str(desk.state.command), remove=leftovers(place)
        )
        return place
