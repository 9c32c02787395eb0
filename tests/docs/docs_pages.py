"""The pages of the documentation as things to run: fenced blocks, commands, links.

A block is read as its page says: with ``title="name"`` it is a file that the reader saves; ``python`` is run, all
blocks of a page in one namespace; ``sh`` is run line by line. ``# exits with 1`` behind a command says how it ends. A
block under ``<!-- not run: reason -->`` is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.joinpath("docs").rglob("*.md")])
_FENCE = re.compile(
    r"^(?:<!-- not run: (?P<why>[^>]+) -->\n+)?```(?P<lang>\w*)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<text>.*?)^```",
    re.MULTILINE | re.DOTALL,
)
_LINK = re.compile(r"(?<!`)\]\(\s*([^)\s]+)\)")
_SPAN = re.compile(r"`(cadsweep [a-z]+ [^`]+)`")


@dataclass(frozen=True, kw_only=True)
class Block:
    """A fenced block of a page."""

    lang: str
    title: str | None
    text: str
    line: int
    not_run: str | None


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page, in order."""
    text = page.read_text()
    return [
        Block(
            lang=found["lang"],
            title=found["title"],
            text=found["text"],
            line=text.count("\n", 0, found.start()) + 1,
            not_run=found["why"],
        )
        for found in _FENCE.finditer(text)
    ]


def links(page: Path) -> Iterator[str]:
    """The targets of all links and pictures of a page."""
    yield from (found[1] for found in _LINK.finditer(_FENCE.sub("", page.read_text())))


def inline_commands(page: Path) -> Iterator[str]:
    """Commands in running text, and in blocks that are not run."""
    text = page.read_text()
    for found in _SPAN.finditer(_FENCE.sub("", text)):
        yield " ".join(found[1].split())
    for block in blocks(page):
        if block.not_run or block.lang == "":
            yield from (line.strip() for line in block.text.splitlines() if line.strip().startswith("cadsweep "))


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub and MkDocs make them."""
    headings = re.findall(r"^#+ (.+)$", _FENCE.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
