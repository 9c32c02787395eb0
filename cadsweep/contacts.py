"""How the solids of an assembly and their contacts are spoken of.

Foundation: parts that share nodes have an interface ``a__b`` a contact; parts that were meshed each by itself have two
boundaries, ``a__b_1`` on the first and ``a__b_2`` on the second.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence


def solids_of(contact: str, parts: Collection[str]) -> tuple[str, str] | None:
    """The two parts that a contact ``a__b`` is between; None where the name is no contact's."""
    words = contact.split("__")
    for k in range(1, len(words)):
        first, second = "__".join(words[:k]), "__".join(words[k:])
        if first in parts and second in parts:
            return first, second
    return None


def separate_contacts(boundaries: Collection[str], parts: Collection[str]) -> dict[str, tuple[str, str]]:
    """Contacts that are two boundaries, ``a__b_1`` and ``a__b_2``: the parts of each, by ``a__b``."""
    found = {}
    for name in boundaries:
        stem = name[:-2]
        if name.endswith("_1") and f"{stem}_2" in boundaries:
            solids = solids_of(stem, parts)
            if solids is not None:
                found[stem] = solids
    return found


def say_leave_out(names: Sequence[str], among: Sequence[str]) -> str:
    """How to mesh a model without some of its solids; nothing where that leaves none."""
    others = [name for name in among if name not in names]
    if not names or not others:
        return ""
    option, said = ("skip", names) if len(names) <= len(others) else ("only", others)
    words = ",".join(dict.fromkeys(said))
    rest = "the other solid" if len(others) == 1 else f"the other {len(others)} solids"
    return f"{option}={words.split(',')} (--{option} {words}) meshes {rest}"
