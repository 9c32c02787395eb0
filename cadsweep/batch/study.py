"""Read a study file; whatever is wrong with it is said before any case is begun."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, did_you_mean, no_such_file
from ..options import SweepOptions

MOST_CASES = 100_000
"""Cases of one study: a record and a folder each, more are a slip in a range."""

MOST_LETTERS = 120
"""Of a case's name in that of its folder: a file system takes 255, and solvers add their own."""

KEYS = ("script", "output", "format", "timeout", "max_memory", "same_mesh", "options", "grid", "cases")

# Not an option of a case: parameters have their own place, and memory and time bound the whole worker.
OPTIONS = tuple(field.name for field in dataclasses.fields(SweepOptions) if field.name not in ("params", "max_memory"))


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row of a study.

    Attributes
    ----------
    name : str
        Unique within the study: the user's, or the parameters and options that the case has for itself.
    key : str
        Hash of the script's text, the parameters and the options.
    params, options : dict
    named : bool
        Whether the name is the user's.
    """

    name: str
    key: str
    params: dict[str, Any]
    options: dict[str, Any]
    named: bool = False

    @property
    def folder(self) -> str:
        """Name of the case's folder: a changed script makes another one."""
        return f"{self.name[:MOST_LETTERS]}_{self.key[:8]}"


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study as read from its file.

    Attributes
    ----------
    script : Path
    folder : Path
        Where the results go.
    suffix : str or None
        Suffix of the mesh files, None for none.
    timeout : float
        Seconds a case.
    max_memory : float or None
        GB a case.
    cases : tuple of Case
    same_mesh : bool
        All cases have the mesh of the first.
    """

    script: Path
    folder: Path
    suffix: str | None
    timeout: float
    max_memory: float | None
    cases: tuple[Case, ...]
    same_mesh: bool = False


def read_study(path: Path) -> Study:
    """Read a study file.

    Raises
    ------
    InputError
        The file is missing, is no TOML, or asks for what does not exist; says which key.
    """
    try:
        with open(path, "rb") as file:
            table = tomllib.load(file)
    except FileNotFoundError:
        raise InputError(no_such_file(path)) from None
    except OSError as error:
        raise InputError(f"cannot read the study {path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{path} is not a TOML file: {error}") from error
    _known(table, KEYS, str(path))
    if not isinstance(table.get("script"), str):
        raise InputError(f"{path}: 'script' must name the CadQuery script, as in script = \"part.py\"")
    script = path.parent / table["script"]
    try:
        text = script.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: cannot read the script: {no_such_file(script)}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read the script {script}: {error.strerror}") from error
    options = _options(table.get("options", {}), f"{path}: [options]", whole=False)
    digest = hashlib.sha256(text).hexdigest()
    cases = list(_cases(table, options, digest, script.stem, str(path)))
    cases = _unique(cases, str(path))
    if any(case.params for case in cases) and script.suffix.lower() != ".py":
        raise InputError(f"{path}: parameters go with a CadQuery script (.py), and {script.name} is none")
    same = table.get("same_mesh", False)
    if not isinstance(same, bool):
        raise InputError(f"{path}: 'same_mesh' must be true or false, not {same!r}")
    if same:
        cases = _of_one_mesh(cases, str(path))
    return Study(
        same_mesh=same,
        script=script.resolve(),
        folder=(path.parent / _text(table, "output", f"{path.stem}_results", path)).resolve(),
        suffix=_suffix(_text(table, "format", "vtu", path)),
        timeout=_positive(table, "timeout", 3600.0, path),
        max_memory=_positive(table, "max_memory", None, path),
        cases=tuple(cases),
    )


def _known(table: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"{where}: there is no '{key}'{did_you_mean(key, keys)}", try_=f"one of {', '.join(keys)}")


def _text(table: Mapping[str, Any], key: str, default: str, path: Path) -> str:
    value = table.get(key, default)
    if not isinstance(value, str) or not value:
        raise InputError(f"{path}: '{key}' must be a text, not {value!r}")
    return value


def _suffix(name: str) -> str | None:
    return None if name == "none" else "." + name.lstrip(".")


def _positive(table: Mapping[str, Any], key: str, default: float | None, path: Path) -> Any:
    value = table.get(key, default)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise InputError(f"{path}: '{key}' must be a positive number, not {value!r}")
    return float(value)


def _options(table: Any, where: str, *, whole: bool = True) -> dict[str, Any]:
    """Options of ``sweep_mesh``, checked as it checks them; of those that others are added to, each by itself."""
    if not isinstance(table, dict):
        raise InputError(f"{where} must be a table")
    _known(table, OPTIONS, where)
    given: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in table.items()}
    if not whole:
        given.setdefault("order", 2)  # which all others go with
    try:
        SweepOptions(**given)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    return dict(table)


def _cases(table: Mapping[str, Any], common: dict[str, Any], digest: str, stem: str, where: str) -> Iterator[Case]:
    grid, singles = table.get("grid", {}), table.get("cases", [])
    if not isinstance(grid, dict) or not isinstance(singles, list) or not all(isinstance(c, dict) for c in singles):
        raise InputError(f"{where}: 'grid' must be a table [grid], and 'cases' a list of tables [[cases]]")
    if not grid and not singles:
        raise InputError(f"{where}: there are no cases; give a table [grid] or a list [[cases]]")
    if grid:
        yield from _grid(dict(grid), common, digest, stem, f"{where}: [grid]")
    for number, single in enumerate(singles, 1):
        at = f"{where}: case {number} of [[cases]]"
        values = dict(single)
        name = values.pop("name", None)
        if name is not None and (not isinstance(name, str) or not name.strip()):
            raise InputError(f"{at}: 'name' must be a text, not {name!r}")
        own = _options(values.pop("options", {}), f"{at}, options", whole=False)
        options = _options({**common, **own}, f"{at}, options")
        yield _case(values, options, digest, name or _spoken(values, own) or stem, named=name is not None, where=at)


def _grid(grid: dict[str, Any], common: dict[str, Any], digest: str, stem: str, where: str) -> Iterator[Case]:
    varied = grid.pop("options", {})
    if not isinstance(varied, dict):
        raise InputError(f"{where}: 'options' must be a table of lists")
    axes = {**grid, **{f"options.{key}": values for key, values in varied.items()}}
    for key, values in axes.items():
        if not isinstance(values, list) or not values:
            raise InputError(f"{where}: '{key}' must be a list of values, not {values!r}")
    _known(varied, OPTIONS, where)
    n_cases = math.prod(len(values) for values in axes.values())
    if n_cases > MOST_CASES:
        raise InputError(f"{where}: {n_cases:,} combinations are more than {MOST_CASES:,}; split the study")
    for combination in itertools.product(*axes.values()):
        chosen = dict(zip(axes, combination, strict=True))
        params = {key: value for key, value in chosen.items() if key in grid}
        own = {key: chosen[f"options.{key}"] for key in varied}
        options = {**common, **own}
        _options(options, f"{where}, {own}" if own else where)
        yield _case(params, options, digest, _spoken(params, own), named=False, where=where)


def _spoken(params: Mapping[str, Any], options: Mapping[str, Any]) -> str:
    """What is particular to a case, in words that a folder may have: ``bend_radius-30_angle-45``."""
    return "_".join(f"{key}-{_word(value)}" for key, value in {**params, **options}.items())


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return "x".join(_word(one) for one in value)
    if isinstance(value, dict):
        return "_".join(f"{key}-{_word(one)}" for key, one in value.items())
    return str(value)


def _case(params: dict[str, Any], options: dict[str, Any], digest: str, name: str, *, named: bool, where: str) -> Case:
    for key, value in params.items():
        if not isinstance(value, bool | int | float | str | list):
            raise InputError(f"{where}: '{key}' must be a number, a text, a truth value or a list, not {value!r}")
    try:
        said = json.dumps([digest, params, options], sort_keys=True)
    except TypeError as error:
        raise InputError(f"{where}: {error}") from error
    key = hashlib.sha256(said.encode()).hexdigest()
    safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip(".") or "case"
    return Case(name=safe, key=key, params=params, options=options, named=named)


def _of_one_mesh(cases: list[Case], where: str) -> list[Case]:
    """The cases of a study of one mesh, known also by the one that is its base."""
    first = cases[0]
    for case in cases:
        for key in {**first.options, **case.options}:
            if case.options.get(key) != first.options.get(key):
                raise InputError(
                    f"{where}: with same_mesh = true all cases have one mesh, and '{case.name}' asks for {key} = "
                    f"{case.options.get(key)!r} where '{first.name}' has {first.options.get(key)!r}; vary "
                    "parameters alone"
                )
    return [replace(case, key=hashlib.sha256(f"like {first.key}: {case.key}".encode()).hexdigest()) for case in cases]


def _unique(cases: list[Case], where: str) -> list[Case]:
    """Refuse what stands there twice; cases whose parameters read the same get their digests into their names."""
    seen: dict[str, Case] = {}
    named: dict[str, Case] = {}
    for case in cases:
        for known, key, said in ((seen, case.key, "are the same"), (named, case.name, "have the same name")):
            if known is named and not case.named:
                continue
            other = known.setdefault(key, case)
            if other is not case:
                raise InputError(
                    f"{where}: two cases {said} '{case.name}': {other.params} {other.options} and {case.params} "
                    f"{case.options}"
                )
    uses = Counter(case.name for case in cases)
    return [
        case if case.named or uses[case.name] == 1 else replace(case, name=f"{case.name}_{case.key[:8]}")
        for case in cases
    ]
