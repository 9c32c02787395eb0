"""The page itself: a template for Vue with trame's state, a style sheet, and what a browser alone can do.

``page.html`` shows the state and pulls triggers; ``page.js`` turns the pointer into lines of sight, keys into
triggers, and hands files up and down. Everything is served from this folder.
"""

from __future__ import annotations

from pathlib import Path

from ..._version import __version__

_FOLDER = Path(__file__).parent
_PLACE = f"__cadsweep_{__version__}"

serve = {_PLACE: str(_FOLDER / "static")}
styles = [f"{_PLACE}/page.css"]
scripts = [f"{_PLACE}/page.js"]
vue_use = ["cadsweep_page"]


def read_template() -> str:
    """The page's template; ``<!-- view -->`` stands where the picture goes."""
    return (_FOLDER / "page.html").read_text(encoding="utf-8")
