"""A refusal in at most three short lines: what cannot be had, where, and what to try.

Place in the flow: foundation, beside :mod:`.errors`, whose root keeps the three apart and asks here for its words. What
does not fit goes clause by clause; all of it stays in ``CadSweepError.message``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

MOST_LINES = 3
"""Lines of a refusal: more are not read."""
MOST_IN_LINE = 142
"""Characters of a line: three, with ``cadsweep:`` and options that are longer on the command line, are below 450."""

_CLAUSE = re.compile(r"(?<=[;.:?])\s+(?=[^\s\d])|(?<=,)\s+(?=as |so |and |but |or |which |where )")
"""Between two clauses of a sentence; numbers of a place stay together."""
_WORD = re.compile(r"[;,]?\s+")


def in_lines(what: str, where: str = "", try_: str = "") -> list[str]:
    """At most three lines of at most :data:`MOST_IN_LINE` characters.

    Parameters
    ----------
    what : str
        What cannot be had, and why: a sentence that may end with a place and with advice of its own.
    where, try_ : str
        The place, and what to try; lines of their own.

    Examples
    --------
    >>> in_lines("'pin' is no sweep", "face 3 (cone at 0, 0, 4)", "cut it there")
    ["'pin' is no sweep", 'where: face 3 (cone at 0, 0, 4)', 'try: cut it there']
    """
    first = " ".join(what.split())
    rest = [f"{word}{' '.join(text.split())}" for word, text in (("where: ", where), ("try: ", try_)) if text]
    return [*_folded(first, MOST_LINES - len(rest)), *(shortened(line, MOST_IN_LINE) for line in rest)]


def _folded(text: str, n_lines: int) -> list[str]:
    """A sentence in so many lines, each of whole clauses as far as that can be; some in the middle are left out."""
    clauses = _CLAUSE.split(text)
    while len(clauses) > 2 and len(_filled(clauses)) > n_lines:
        del clauses[-2]  # the last says what to try
    lines = _filled(clauses)
    if len(lines) > n_lines:
        lines = [*lines[: n_lines - 1], shortened(" ".join(lines[n_lines - 1 :]), MOST_IN_LINE)]
    return lines


def _filled(clauses: Sequence[str]) -> list[str]:
    """Clauses in lines of :data:`MOST_IN_LINE` characters; one that is longer goes on in the next."""
    lines: list[str] = []
    for clause in clauses:
        if lines and len(lines[-1]) + 1 + len(clause) <= MOST_IN_LINE:
            lines[-1] += f" {clause}"
            continue
        line = ""
        for word in clause.split(" "):
            if line and len(line) + 1 + len(word) > MOST_IN_LINE:
                lines.append(line)
                line = word
            else:
                line = f"{line} {word}" if line else word
        lines.append(line)
    return [shortened(line, MOST_IN_LINE) for line in lines]


def shortened(text: str, most: int) -> str:
    """A text of at most `most` characters that ends with a whole word.

    Examples
    --------
    >>> shortened("face 1, face 2, face 3", 14)
    'face 1, …'
    """
    if len(text) <= most:
        return text
    ends = [match.start() for match in _WORD.finditer(text, 0, most - 1)]
    end = ends[-1] if ends and ends[-1] > most // 2 else most - 2
    return f"{text[:end].rstrip(' ,;(')}, …" if text[end : end + 1] in ",;" else f"{text[:end].rstrip(' ,;(')} …"


__all__ = ["MOST_IN_LINE", "MOST_LINES", "in_lines", "shortened"]
