"""A page put together: the desk, those who work at it, and the template with its state.

Place in the flow: called by :mod:`.server` before it listens.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from .desk import Desk
from .exporting import Exporting
from .files import Files
from .jobs import Jobs
from .looking import Looking
from .meshing import Meshing
from .opening import Opening
from .scene import Scene
from .selecting import Selecting
from .wishing import Wishing


class PageDesk(Desk):
    """A desk with those who work at it."""

    files: Files
    opening: Opening
    exporting: Exporting

    async def open_source(self, source: Any) -> None:
        """Open what the command named."""
        await self.opening.open(source)


def make_desk(server: Any, folder: Path) -> PageDesk:
    """Put the page together on one of trame's servers; everything temporary is in `folder`."""
    from . import page

    server.enable_module(page)
    desk = PageDesk(server=server, folder=folder, jobs=Jobs(), scene=Scene())
    state = server.state
    state.update({"trame__title": "cadsweep", "theme": "light", "tab": "ask", "message": "", "message_kind": "note"})
    state.update({"helping": False})
    desk.files = Files(folder)
    desk.opening = Opening(desk, desk.files)
    Selecting(desk)
    Wishing(desk)
    Meshing(desk)
    Looking(desk)
    desk.exporting = Exporting(desk, desk.files)
    desk.trigger("say", lambda text, kind="note": desk.say(str(text), kind=str(kind)))
    desk.trigger("theme", lambda: _turn_theme(desk))
    desk.trigger("help", lambda: state.update({"helping": not state.helping}))
    _make_template(desk)
    return desk


def _turn_theme(desk: Desk) -> None:
    desk.state.theme = "light" if desk.state.theme == "dark" else "dark"
    desk.scene.set_theme(desk.state.theme)
    desk.push()


def _make_template(desk: Desk) -> None:
    from trame.ui.html import DivLayout
    from trame.widgets import vtk

    from .page import read_template

    with DivLayout(desk.server) as layout:
        layout.root.classes = "page"
        view = vtk.VtkLocalView(
            desk.scene.window,
            ref="view",
            interactor_settings=("interaction", _INTERACTION),
            view_state_change="$page.drawn($event)",
        )
        layout.root.clear()
        layout.root.add_child(read_template().replace("<!-- view -->", view.html))
    under_way: list[asyncio.TimerHandle] = []

    def push_now() -> None:
        under_way.clear()
        view.update()
        desk.state.flush()

    def push() -> None:
        # Several changes of one answer go out together.
        if not under_way:
            under_way.append(asyncio.get_running_loop().call_later(0.01, push_now))

    desk.push = push


_INTERACTION = [
    {"button": 1, "action": "Rotate"},
    {"button": 2, "action": "Pan"},
    {"button": 3, "action": "Pan"},
    {"button": 1, "action": "Pan", "shift": True},
    {"button": 1, "action": "Zoom", "control": True},
    {"button": 1, "action": "Zoom", "scrollEnabled": True, "dragEnabled": False},
]
