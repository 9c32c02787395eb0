"""What the site does with links that leave ``docs/``, and with the pages that live beside it.

On a code host the pages link to models, tests and modules of the checkout. The site takes each file that is linked to
along, under ``files/``; ``CONTRIBUTING.md`` and ``CHANGELOG.md`` become pages.
"""

from __future__ import annotations

import re
from pathlib import Path
from posixpath import normpath, relpath
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
PAGES = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
_LINK = re.compile(r"\]\((?!\w+:|#)\s*([^)\s#]+)(#[^)]*)?\)")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages from beside ``docs/``, with their links as seen from inside."""
    for name, page in PAGES.items():
        text = _LINK.sub(lambda match: f"]({relpath(match[1], 'docs')}{match[2] or ''})", (ROOT / name).read_text())
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Point links at files outside ``docs/`` to their copies in the site; folders are no link there."""
    here = str(Path(page.file.src_uri).parent)

    def replaced(match: re.Match[str]) -> str:
        target = normpath(f"docs/{here}/{match[1]}")
        if target.startswith("docs/"):
            return match[0]
        if target in PAGES:
            return f"]({relpath(PAGES[target], here)}{match[2] or ''})"
        if (ROOT / target).is_dir():
            return f"]({relpath(_listed(target, config, files), here)})"
        copy = f"files/{target}"
        if files.get_file_from_path(copy) is None:
            # A browser shows text; a page of its own would be rendered.
            files.append(File.generated(config, copy, content=(ROOT / target).read_bytes()))
        return f"]({relpath(copy, here)})"

    return _LINK.sub(replaced, markdown)


def _listed(folder: str, config: Any, files: Any) -> str:
    """Add a list of a folder's files; returns where it is."""
    name = f"files/{folder}/index.txt"
    if files.get_file_from_path(name) is None:
        entries = sorted(path.name for path in (ROOT / folder).iterdir() if not path.name.startswith(("_", ".")))
        files.append(File.generated(config, name, content="\n".join(entries) + "\n"))
    return name
