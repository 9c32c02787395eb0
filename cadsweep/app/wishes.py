"""What is asked of picked things and of the whole part, as values, and the options of ``sweep_mesh`` that it comes to.

Place in the flow: the page's fields become wishes; :mod:`.session` keeps them; meshing, command and script all take the
options from here, so that they say the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import InputError
from ..options import SweepOptions
from .entities import PartData

KINDS = ("name", "size", "count", "bias", "walls", "partner", "suppress", "cut")
TAKES = {
    "name": ("face", "edge"),
    "size": ("solid", "face", "edge"),
    "count": ("edge",),
    "bias": ("edge",),
    "walls": ("face",),
    "partner": ("face",),
    "suppress": ("solid", "face"),
    "cut": ("face",),
}
"""What can be picked for each kind of wish."""
WHOLE = ("size", "tolerance", "layers", "order", "max_hexes")
_MOST_NAMED = 6


@dataclass(frozen=True, kw_only=True)
class Wish:
    """One wish.

    Attributes
    ----------
    kind : str
        Of `KINDS`.
    on : tuple of str
        Keys of what it is about, in the order in which they were picked; empty where `value` says it in words.
    value : str, float, int, dict or None
        The name, size or count; ``{"ratio", "towards"}``; ``{"first", "growth", "n"}``; of what is cut along or left
        out in words, those.
    """

    kind: str
    on: tuple[str, ...] = ()
    value: Any = None

    def replaces(self, other: Wish) -> bool:
        """Whether it stands in another one's place: the same kind of wish for the same things."""
        words = not self.on and self.value != other.value
        return self.kind == other.kind and set(self.on) == set(other.on) and not words


@dataclass(frozen=True, kw_only=True)
class Asked:
    """All wishes at one time.

    Attributes
    ----------
    wishes : tuple of Wish
    whole : mapping
        Options of the whole by name, of `WHOLE`.
    """

    wishes: tuple[Wish, ...] = ()
    whole: Mapping[str, Any] = field(default_factory=dict)

    def with_wish(self, wish: Wish) -> Asked:
        """With one more, in the place of the one that it replaces."""
        kept = tuple(other for other in self.wishes if not wish.replaces(other))
        return Asked(wishes=(*kept, wish), whole=self.whole)

    def without(self, number: int) -> Asked:
        """Without one of them."""
        return Asked(wishes=self.wishes[:number] + self.wishes[number + 1 :], whole=self.whole)

    def with_whole(self, name: str, value: Any) -> Asked:
        """With another option of the whole; None takes it away."""
        whole = {**self.whole, name: value}
        return Asked(wishes=self.wishes, whole={key: one for key, one in whole.items() if one is not None})

    def given_names(self) -> dict[str, str]:
        """The names that wishes give, by key; the last one holds."""
        return {key: str(wish.value) for wish in self.wishes if wish.kind == "name" for key in wish.on}

    def options(self, part: PartData, params: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Options of ``sweep_mesh``, and no others than are asked for."""
        made = _Making(part, self)
        for wish in self.wishes:
            _TAKE[wish.kind](made, wish)
        options: dict[str, Any] = dict(self.whole)
        for name in ("names", "sizes", "counts", "biases", "wall_layers", "periodic", "suppress", "skip", "cuts"):
            if made.found.get(name):
                options[name] = made.found[name]
        if params:
            options["params"] = dict(params)
        return options


class _Making:
    """Options as they come together, and the words for what they are about."""

    def __init__(self, part: PartData, asked: Asked) -> None:
        self.part = part
        self.found: dict[str, Any] = {}
        self._names = asked.given_names()
        self._taken = {entity.name for entity in part.entities.values()} | set(self._names.values())
        by_name: dict[str, list[str]] = {}
        for key, name in self._names.items():
            by_name.setdefault(name, []).append(key)
        for name, keys in by_name.items():
            self._give(name, keys)
        self._alone = {name for name, keys in by_name.items() if len(keys) == 1}

    def _give(self, name: str, keys: Sequence[str]) -> None:
        words = [self.part.id_word(key) for key in keys]
        self.found.setdefault("names", {})[name] = words[0] if len(words) == 1 else words

    def word(self, key: str) -> str:
        """A word that means one entity alone, for whatever option: its name, its number, or a name made for it."""
        entity = self.part.entities[key]
        if entity.kind == "solid":
            return entity.name
        if self._names.get(key) in self._alone:
            return self._names[key]
        if self.part.has_own_name(key) and entity.name not in self._names.values():
            return entity.name
        if len(self.part.solids) == 1:
            return f"{entity.kind} {entity.id}"
        # Numbers are those of each solid: of several, a face that a wish is about gets a name.
        made = f"{self.part.solids[entity.solid].name}_{entity.kind}_{entity.id}"
        while made in self._taken:
            made += "_"
        self._names[key] = made
        self._alone.add(made)
        self._taken.add(made)
        self._give(made, [key])
        return made

    def sized(self, key: str) -> str:
        """The word as `sizes` wants it: that of a face and of an edge told apart."""
        kind = self.part.entities[key].kind
        return self.word(key) if kind == "solid" else f"{kind}s:{self.word(key)}"


def _each(option: str, *, sized: bool = False) -> Callable[[_Making, Wish], None]:
    def take(made: _Making, wish: Wish) -> None:
        for key in wish.on:
            word = made.sized(key) if sized else made.word(key)
            made.found.setdefault(option, {})[word] = wish.value

    return take


def _take_partner(made: _Making, wish: Wish) -> None:
    first, second = wish.on
    made.found.setdefault("periodic", {})[made.word(first)] = made.word(second)


def _take_suppress(made: _Making, wish: Wish) -> None:
    if not wish.on:
        made.found.setdefault("suppress", []).append(wish.value)
    for key in wish.on:
        solid = made.part.entities[key].kind == "solid"
        word = made.word(key) if solid else made.part.id_word(key)
        made.found.setdefault("skip" if solid else "suppress", []).append(word)


def _take_cut(made: _Making, wish: Wish) -> None:
    words = [made.part.id_word(key) for key in wish.on] or [wish.value]
    made.found.setdefault("cuts", []).extend(words)


_TAKE: dict[str, Callable[[_Making, Wish], None]] = {
    "name": lambda made, wish: None,  # taken before all others, which may use it
    "size": _each("sizes", sized=True),
    "count": _each("counts"),
    "bias": _each("biases"),
    "walls": _each("wall_layers"),
    "partner": _take_partner,
    "suppress": _take_suppress,
    "cut": _take_cut,
}


def make_wish(kind: str, picked: Sequence[str], fields: Mapping[str, Any], part: PartData) -> Wish:
    """A wish from what is picked and what the fields of the page hold.

    Raises
    ------
    InputError
        What is picked cannot be asked this, or a field does not hold what it should; the message is for beside it.
    """
    on = tuple(key for key in picked if part.entities[key].kind in TAKES[kind])
    if not on:
        raise InputError(f"pick {' or '.join(f'a {one}' if one != 'edge' else 'an edge' for one in TAKES[kind])} first")
    if kind == "name":
        name = str(fields.get("name", "")).strip()
        if not name:
            raise InputError("a name has one letter at least")
        return Wish(kind=kind, on=on, value=name)
    if kind == "partner":
        if len(on) != 2:
            raise InputError(f"pick two faces, whose meshes are to answer each other; {len(on)} is picked")
        return Wish(kind=kind, on=on)
    if kind in ("suppress", "cut"):
        return Wish(kind=kind, on=on)
    return Wish(kind=kind, on=on, value=_VALUES[kind](fields))


def number(text: Any, what: str, *, whole: bool = False) -> float | int:
    """A number of a field.

    Raises
    ------
    InputError
        It is none, or not positive, or not whole where it has to be.
    """
    try:
        value = float(str(text).strip().replace(",", "."))
    except ValueError:
        raise InputError(
            f"{what} is a number, not '{str(text).strip()}'" if str(text).strip() else f"{what} is missing"
        ) from None
    if not math.isfinite(value) or value <= 0:
        raise InputError(f"{what} is more than 0")
    if whole and value != int(value):
        raise InputError(f"{what} is a whole number")
    return int(value) if whole else value


def _bias(fields: Mapping[str, Any]) -> dict[str, Any]:
    towards = str(fields.get("towards", "")).strip() or "both"
    return {"towards": towards, "ratio": number(fields.get("ratio"), "the ratio")}


def _walls(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "first": number(fields.get("first"), "the first height"),
        "growth": number(fields.get("growth"), "the growth"),
        "n": number(fields.get("n"), "the number of layers", whole=True),
    }


_VALUES: dict[str, Callable[[Mapping[str, Any]], Any]] = {
    "size": lambda fields: number(fields.get("size"), "the size"),
    "count": lambda fields: number(fields.get("count"), "the count", whole=True),
    "bias": _bias,
    "walls": _walls,
}


def check_options(options: Mapping[str, Any]) -> None:
    """Refuse what ``sweep_mesh`` would refuse before it looks at the part.

    Raises
    ------
    InputError
    """
    SweepOptions(**options)


def say(wish: Wish, part: PartData, names: Mapping[str, str]) -> str:
    """A wish in a line."""
    what = ", ".join(names.get(key) or part.label(key) for key in wish.on[:_MOST_NAMED])
    more = f" and {len(wish.on) - _MOST_NAMED} more" if len(wish.on) > _MOST_NAMED else ""
    what += more
    value = wish.value
    if wish.kind == "name":
        plain = ", ".join(f"{part.entities[key].kind} {part.entities[key].id}" for key in wish.on[:_MOST_NAMED])
        return f"{plain}{more} {'are' if len(wish.on) > 1 else 'is'} called {value}"
    if wish.kind == "walls":
        return f"{what}: {value['n']} wall layers, first {value['first']:g}, growth {value['growth']:g}"
    if wish.kind == "bias":
        return f"{what}: finer towards {value['towards']}, ratio {value['ratio']:g}"
    if wish.kind == "partner":
        return f"{what}: meshed alike"
    if wish.kind in ("suppress", "cut"):
        return f"{'left out' if wish.kind == 'suppress' else 'cut along'}: {what or value}"
    return f"{what}: {wish.kind} {value:g}"
