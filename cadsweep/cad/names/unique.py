"""Names of users become names that every format carries: unique, and made of ``[A-Za-z0-9_]``.

Place in the flow: the readers collect what users wrote (sub-shape names, tags, STEP labels); this
module decides what each face is called.

Rules, after ``assembly-mesh-plugin``: in an assembly a name becomes ``{part}_{name}``; a leading
``~`` drops the part's name; ``mat:NAME`` names a material. Names that differ only in case count as
equal, because solvers such as CalculiX do not tell them apart.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

MATERIAL_PREFIX = "mat:"
_MEANINGLESS = re.compile(
    r"^(none|null|=>\[.*|open cascade step translator.*|solid|(?-i:SHELL)|compound|face|shape|part)?$", re.I
)
"""OpenCASCADE writes SHELL; in small letters a shell is what somebody calls the part around a core."""
_MOST_TOLD = 5
"""Changed names that are told one by one."""
_UUID = re.compile(r"^[0-9a-f]{8}-([0-9a-f]{4}-){3}[0-9a-f]{12}$", re.I)


class Declared(NamedTuple):
    """Names by entity, declared name to user's name, and notes on what was changed."""

    by_entity: dict[int, tuple[str, ...]]
    originals: dict[str, str]
    notes: list[str]


def is_meaningful(name: str | None) -> bool:
    """Whether a label says something, and was not filled in by the program that wrote the file."""
    return (
        name is not None
        and name.strip() != ""
        and not _MEANINGLESS.match(name.strip())
        and not _UUID.match(name.strip())
    )


def is_given(name: str | None) -> bool:
    """Whether somebody gave an object this name: CadQuery fills in a UUID where nobody did."""
    return name is not None and name.strip() != "" and not _UUID.match(name.strip())


def join_part(part: str | None, name: str) -> str:
    """``{part}_{name}``; ``~name`` stands alone, as does a name whose part has none."""
    if name.startswith("~"):
        return name[1:]
    return f"{part}_{name}" if is_meaningful(part) else name


def plain(name: str, fallback: str = "name") -> str:
    """Write a name with ``[A-Za-z0-9_]`` alone: other scripts are transliterated, all else becomes ``_``.

    A digit at the beginning, which some solvers do not allow, gets an ``n`` before it.
    """
    if not name.isascii():
        from anyascii import anyascii

        name = anyascii(name)
    out = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]+", "_", name))
    if not re.search(r"[A-Za-z0-9]", out):
        return fallback
    # Underscores that the user wrote at the ends stay; those that stand for other signs there go.
    head, tail = name.startswith("_"), name.endswith("_")
    out = out if head else out.lstrip("_")
    out = out if tail else out.rstrip("_")
    return f"n{out}" if out[0].isdigit() else out


def make_plain_names(names: Iterable[str], fallback: str = "name") -> tuple[dict[str, str], list[str]]:
    """Give each distinct user's name its own plain name, in order; the second value holds notes.

    Names that need no change keep theirs, whatever comes before them.
    """
    names = list(dict.fromkeys(names))
    plain_names: dict[str, str] = {}
    taken: set[str] = set()
    for name in sorted(names, key=lambda name: plain(name, fallback) != name):
        base = candidate = plain(name, fallback)
        number = 2
        while candidate.casefold() in taken:
            candidate = f"{base}_{number}"
            number += 1
        taken.add(candidate.casefold())
        plain_names[name] = candidate
    return {name: plain_names[name] for name in names}, _say_written((name, plain_names[name]) for name in names)


def _say_written(names: Iterable[tuple[str, str]]) -> list[str]:
    """Notes on names that are written otherwise; of many the first few."""
    notes = [f"name '{old}' is written as '{new}'" for old, new in names if old != new]
    more = len(notes) - _MOST_TOLD
    return notes if more < 1 else [*notes[:_MOST_TOLD], f"{more} more names are written otherwise, too"]


def declare(groups: Sequence[tuple[str, Sequence[int]]], *, what: str = "face") -> Declared:
    """Decide the names of every entity.

    Parameters
    ----------
    groups : sequence of (name, entities)
        As the user gave them; a name may come more than once, its entities are united.
    what : str
        What the entities are, for the notes.

    Returns
    -------
    Declared
        An entity keeps all its names: first the one that names the fewest entities, then in the order given.
    """
    united: dict[str, dict[int, None]] = {}
    for name, entities in groups:
        united.setdefault(name, {}).update(dict.fromkeys(entities))
    united = {name: entities for name, entities in united.items() if entities}
    plain_names, changes = make_plain_names(united)
    by_entity: dict[int, tuple[str, ...]] = {}
    overlaps: dict[tuple[str, str], int] = {}
    for name in sorted(united, key=lambda name: len(united[name])):
        for entity in united[name]:
            own = by_entity.get(entity, ())
            for other in own:
                overlaps[other, plain_names[name]] = overlaps.get((other, plain_names[name]), 0) + 1
            by_entity[entity] = (*own, plain_names[name])
    notes = [f"the names '{one}' and '{other}' share {n} {what}(s)" for (one, other), n in overlaps.items()]
    return Declared(dict(sorted(by_entity.items())), {new: old for old, new in plain_names.items()}, notes + changes)


def number_repeated(names: Sequence[str | None], *, what: str) -> tuple[list[str], list[str]]:
    """Give every thing a plain name of its own: ``bolt_1``, ``bolt_2`` where two are called ``bolt``.

    Parameters
    ----------
    names : sequence of str or None
        As the user gave them; what has none is called after `what` and its number from 1.
    what : str

    Returns
    -------
    list of str
    list of str
        Notes on names that were changed.
    """
    written = [what if name is None else plain(name, what) for name in names]
    folded = [name.casefold() for name in written]
    groups: dict[str, list[int]] = {}
    for j, name in enumerate(folded):
        groups.setdefault(name, []).append(j)
    alone = {name for name, members in groups.items() if len(members) == 1 and names[members[0]] is not None}
    taken = set(alone)
    out = list(written)
    notes = _say_written((name, written[j]) for j, name in enumerate(names) if name is not None and folded[j] in alone)
    for name, members in groups.items():
        if name in alone:
            continue
        number = 1
        for j in members:
            while f"{name}_{number}" in taken:
                number += 1
            taken.add(f"{name}_{number}")
            out[j] = f"{written[j]}_{number}"
        if any(names[j] is not None for j in members):
            notes.append(
                f"{len(members)} solids are called '{written[members[0]]}': {out[members[0]]} to {out[members[-1]]}"
            )
    return out, notes


def declare_words(*words: tuple[str | None, str]) -> tuple[list[str | None], Declared]:
    """Decide the names of things that need not differ, such as a part and its material.

    Parameters
    ----------
    words : (name or None, fallback)

    Returns
    -------
    list of str or None
        The names as they are written.
    Declared
        What was changed, and why.
    """
    written = [None if name is None else plain(name, fallback) for name, fallback in words]
    changed = {new: old for new, (old, _) in zip(written, words, strict=True) if new is not None and old is not None}
    notes = _say_written((old, new) for new, old in changed.items())
    return written, Declared({}, {new: old for new, old in changed.items() if new != old}, notes)
