"""Files that the browser hands up, and those that it is handed down: the page writes nowhere else.

Place in the flow: two addresses beside those of trame. What is handed up is the file that the user chose in the
browser's own dialogue; what is handed down lies in the server's temporary folder until the server ends, and goes where
the browser puts what it downloads.
"""

from __future__ import annotations

import asyncio
import secrets
import zipfile
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..errors import CadSweepError

UP, DOWN, MAKE = "/hand-up", "/hand-down", "/make"
MOST_BYTES = 2**31
"""Of a file that is handed up."""


class Files:
    """What is handed up and down.

    Parameters
    ----------
    folder : Path
        Of this server alone.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._down: dict[str, Path] = {}
        self._up: dict[str, Path] = {}

    def new_place(self, name: str) -> Path:
        """Where a file of this name may be written: a folder of its own."""
        place = self._folder / secrets.token_hex(8)
        place.mkdir()
        return place / (Path(name).name or "file")

    def offer(self, path: Path) -> str:
        """The address under which the browser gets a file, or a folder as a zip file."""
        if path.is_dir():
            packed = path.parent / f"{path.name}.zip"
            with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
                for one in sorted(path.rglob("*")):
                    archive.write(one, one.relative_to(path.parent))
            path = packed
        key = secrets.token_hex(8)
        self._down[key] = path
        return f"{DOWN}/{key}/{quote(path.name)}"

    def taken(self, key: str) -> Path | None:
        """The file that was handed up under a key, once."""
        return self._up.pop(key, None)

    def add_routes(self, app: Any, make: Callable[[str], Awaitable[Path]]) -> None:
        """Register the addresses; `make` writes what is asked for by its file name, and says where."""
        from aiohttp import web

        async def made(request: Any) -> Any:
            try:
                path = await make(request.query.get("name", ""))
            except CadSweepError as error:
                return web.Response(status=422, text=" ".join(str(error).split()))
            return web.json_response({"address": await asyncio.to_thread(self.offer, path)})

        async def up(request: Any) -> Any:
            place = self.new_place(request.query.get("name", "part"))
            n_bytes = 0
            with place.open("wb") as stream:
                async for chunk in request.content.iter_chunked(2**18):
                    n_bytes += len(chunk)
                    if n_bytes > MOST_BYTES:
                        stream.close()
                        place.unlink()
                        return web.Response(status=413, text="The file is too large.")
                    stream.write(chunk)
            key = secrets.token_hex(8)
            self._up[key] = place
            return web.json_response({"key": key})

        async def down(request: Any) -> Any:
            path = self._down.get(request.match_info["key"])
            if path is None or not path.is_file():
                return web.Response(status=404, text="There is no such file any more.")
            name = quote(path.name)
            return web.FileResponse(path, headers={"Content-Disposition": f"attachment; filename*=UTF-8''{name}"})

        app.router.add_post(MAKE, made)
        app.router.add_post(UP, up)
        app.router.add_get(DOWN + "/{key}/{name}", down)
