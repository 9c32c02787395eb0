"""Values of options that click does not know: what is out of range is wrong usage, exit code 2."""

from __future__ import annotations

import math
from typing import Any

import click

SCRIPT_SUFFIXES = (".py",)


class Positive(click.ParamType):
    """A positive, finite number; `infinite` allows ``inf``."""

    def __init__(self, *, infinite: bool = False) -> None:
        self.name = "number"
        self._infinite = infinite

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = float(value)
        except ValueError:
            self.fail(f"{value!r} is not a number", param, ctx)
        if not number > 0 or (math.isinf(number) and not self._infinite):
            self.fail(f"{value} is not a positive{'' if self._infinite else ', finite'} number", param, ctx)
        return number


class Bias(click.ParamType):
    """One ratio, or two with a comma between them: at the source end and at the target end."""

    name = "ratio[,ratio]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            ratios = tuple(float(word) for word in value.split(","))
        except ValueError:
            self.fail(f"{value!r} is neither a number nor two with a comma between them", param, ctx)
        if len(ratios) > 2:
            self.fail(f"{value!r} has more than two ratios", param, ctx)
        return ratios[0] if len(ratios) == 1 else ratios


class Numbers(click.ParamType):
    """Numbers with commas between them."""

    name = "number,number,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return tuple(float(word) for word in value.split(","))
        except ValueError:
            self.fail(f"{value!r} is no list of numbers with commas between them", param, ctx)


class Shard(click.ParamType):
    """``I/N``: the I-th of N parts, counted from 1."""

    name = "i/n"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        number, sign, of = value.partition("/")
        if not (sign and number.isdigit() and of.isdigit() and 1 <= int(number) <= int(of)):
            self.fail(f"{value!r} is not of the form I/N, with I from 1 to N", param, ctx)
        return int(number), int(of)


class Names(click.ParamType):
    """Names with commas between them."""

    name = "name,name,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        names = tuple(word.strip() for word in value.split(","))
        if not all(names):
            self.fail(f"{value!r} is no list of names with commas between them", param, ctx)
        return names


class Size(click.ParamType):
    """A length, or ``SOLID=LENGTH`` for one solid of an assembly; a pair of the name (None) and the length."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        if "=" in value:
            return Assignment(Positive()).convert(value, param, ctx)
        return None, Positive().convert(value, param, ctx)


class Grading(click.ParamType):
    """``RATIO@TOWARDS`` or ``first:LENGTH@TOWARDS``: a table as of the option `biases`."""

    name = "ratio@towards"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, Any]:
        if not isinstance(value, str):
            return dict(value)
        text, sign, towards = (word.strip() for word in value.partition("@"))
        kind = "first" if text.startswith("first:") else "ratio"
        if not sign or not towards:
            self.fail(f"{value!r} is not of the form RATIO@TOWARDS or first:LENGTH@TOWARDS", param, ctx)
        number = Positive().convert(text.removeprefix("first:"), param, ctx)
        return {"towards": _point_or_name(towards), kind: number}


class Place(click.ParamType):
    """``SIZE@PLACE:RADIUS``: a table as of the option `local_sizes`."""

    name = "size@place:radius"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, Any]:
        if not isinstance(value, str):
            return dict(value)
        text, sign, rest = (word.strip() for word in value.partition("@"))
        place, colon, radius = rest.rpartition(":")
        if not (sign and colon and place) or not _is_number(radius):
            self.fail(f"{value!r} is not of the form SIZE@PLACE:RADIUS, such as 0.5@10,0,5:3", param, ctx)
        return {"at": _point_or_name(place), "radius": float(radius), "size": Positive().convert(text, param, ctx)}


def _point_or_name(text: str) -> Any:
    words = text.split(",")
    return tuple(float(word) for word in words) if len(words) == 3 and all(map(_is_number, words)) else text


class Layers(click.ParamType):
    """``FIRST:GROWTH:N``: a table as of the option `wall_layers`."""

    name = "first:growth:n"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, Any]:
        if not isinstance(value, str):
            return dict(value)
        words = value.split(":")
        if len(words) != 3 or not words[2].isdigit():
            self.fail(f"{value!r} is not of the form FIRST:GROWTH:N, such as 0.05:1.2:8", param, ctx)
        first, growth = (Positive().convert(word, param, ctx) for word in words[:2])
        return {"first": first, "growth": growth, "n": int(words[2])}


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


class Assignment(click.ParamType):
    """``NAME=VALUE``, a pair; the value is made by `of`, and holds no ``=`` then. `prefix` goes before the name."""

    name = "name=value"

    def __init__(self, of: click.ParamType | None = None, *, prefix: str = "") -> None:
        self._of = of
        self._prefix = prefix

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        if isinstance(value, tuple):
            return value
        name, sign, text = value.partition("=") if self._of is None else value.rpartition("=")
        name = name.strip()
        if not sign or not name:
            self.fail(f"{value!r} is not of the form NAME=VALUE", param, ctx)
        return self._prefix + name.removeprefix(self._prefix), (
            text if self._of is None else self._of.convert(text, param, ctx)
        )


def parse_parameter(text: str) -> Any:
    """A script parameter as Python would read it: number, truth value, quoted text; else the text itself."""
    import ast

    try:
        value = ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return {"true": True, "false": False}.get(text.lower(), text)
    return value if isinstance(value, int | float | str | bool | tuple | list) else text


def parse_cap(text: str | None) -> Any:
    """A cap as the user gives it: an id, several with commas, or a name or selector."""
    if text is None:
        return None
    words = [word.strip() for word in text.split(",")]
    if all(word.isdigit() for word in words):
        ids = [int(word) for word in words]
        return ids[0] if len(ids) == 1 else ids
    return text


def is_script(path: str) -> bool:
    """Whether an input is a program."""
    return path.lower().endswith(SCRIPT_SUFFIXES)
