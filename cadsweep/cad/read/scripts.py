"""CadQuery scripts, run through ``cadquery.cqgi``.

Place in the flow: one of the readers. A script is a program: it runs with the rights of the caller,
and nothing here confines it. What it prints goes to the log, so that the caller's own output stays
clean.
"""

from __future__ import annotations

import ast
import contextlib
import io
import logging
import math
import sys
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from ...errors import CadError, InputError, did_you_mean
from .model import Model
from .objects import read_object

logger = logging.getLogger(__name__)

_MOST_LOGGED = 10_000
"""Characters of a script's output that reach the log."""

_MODULE = "__cqgi__"

_TYPES = {
    "NumberParameterType": "number",
    "StringParameterType": "text",
    "BooleanParameterType": "True or False",
    "TupleParameterType": "tuple",
}


def run_script(path: Path, params: Mapping[str, Any]) -> Model:
    """Run a script and read the one object that it shows.

    Parameters
    ----------
    path : Path
    params : mapping
        Values for the script's parameters (top-level assignments of constants). Numbers may be
        given as text.

    Raises
    ------
    InputError
        The script has no such parameter, a value does not fit, or the script is no Python, raises,
        exits, shows several objects, or shows none and has no ``result``.
    CadError
        What it shows is empty.
    """
    from cadquery import cqgi

    try:
        text = path.read_text(encoding="utf-8-sig")
    except (UnicodeDecodeError, OSError) as error:
        raise InputError(f"{path}: the script cannot be read: {error}.") from error
    with _captured_output(path), _beside(path):
        try:
            script = cqgi.parse(text)
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None)
            raise InputError(f"{path}{_at(line)}: this is no Python: {getattr(error, 'msg', error)}.") from error
        _add_parameters(script, cqgi)
        values = _checked(path, script.metadata.parameters, params)
        try:
            result = script.build(build_parameters=values)
        except SystemExit as error:
            raise InputError(
                f"{path}{_at(_script_line(error, cqgi.CQSCRIPT))}: the script ends the program "
                f"(exit code {error.code}) before it shows an object."
            ) from error
    if not result.success:
        raised = result.exception
        line = _script_line(raised, cqgi.CQSCRIPT)
        raise InputError(f"{path}{_at(line)}: the script raises {type(raised).__name__}: {_short(raised)}") from raised
    model = _shown(path, result.results or _result_of(result.env))
    if not result.results:
        model.notes.append("the script shows nothing: its variable 'result' is taken")
    return model


def list_parameters(path: Path) -> dict[str, tuple[str, Any]]:
    """Parameters of a script: name to type and default value."""
    from cadquery import cqgi

    with _captured_output(path):
        script = cqgi.parse(path.read_text(encoding="utf-8-sig"))
        _add_parameters(script, cqgi)
    found = script.metadata.parameters
    return {name: (_type_name(p), p.default_value) for name, p in found.items()}


def _add_parameters(script: Any, cqgi: Any) -> None:
    """Make parameters of what cqgi passes over: negative numbers, and assignments with a type."""
    kinds = {bool: cqgi.BooleanParameterType, str: cqgi.StringParameterType}
    for node in script.ast_tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if (
            not isinstance(node, (ast.Assign, ast.AnnAssign))
            or len(targets) != 1
            or not isinstance(targets[0], ast.Name)
        ):
            continue
        value = node.value
        if (
            isinstance(value, ast.UnaryOp)
            and isinstance(value.op, ast.USub)
            and isinstance(value.operand, ast.Constant)
        ):
            number = value.operand.value
            if isinstance(number, bool) or not isinstance(number, (int, float)):
                continue
            value = node.value = ast.copy_location(ast.Constant(-number), value)
        elif not isinstance(node, ast.AnnAssign):
            continue
        if isinstance(value, ast.Constant) and type(value.value) in (bool, str, int, float):
            kind = kinds.get(type(value.value), cqgi.NumberParameterType)
            parameter = cqgi.InputParameter.create(value, targets[0].id, kind, value.value)
            script.metadata.add_script_parameter(parameter)


def _result_of(names: Mapping[str, Any]) -> list[Any]:
    """What a script calls ``result``, as CadQuery's documentation does, as if it were shown."""
    if names.get("result") is None:
        return []
    return [SimpleNamespace(shape=names["result"], options={})]


def _shown(path: Path, results: list[Any]) -> Model:
    if not results:
        raise InputError(f"{path}: the script shows nothing. End it with show_object(result).")
    if len(results) > 1:
        raise InputError(
            f"{path}: the script shows {len(results)} objects, and cadsweep meshes one. Keep one show_object call; "
            "solids that belong together can be one cq.Assembly."
        )
    shown = results[0].shape
    try:
        model = read_object(shown)
    except (InputError, CadError) as error:
        raise type(error)(f"{path}: {error}") from error
    if model is None:
        raise InputError(
            f"{path}: the script shows a {type(shown).__name__}, which is no shape. "
            "Show a Workplane, Shape or Assembly."
        )
    model.source = str(path)
    options = results[0].options
    name = options.get("name") if isinstance(options, dict) else None
    model.name = name if isinstance(name, str) and name.strip() else model.name or path.stem
    if model.name == "part":
        model.name = path.stem
    return model


def _checked(path: Path, parameters: Mapping[str, Any], params: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the right type, or an error that lists what there is."""
    values = {}
    for name, value in params.items():
        if name not in parameters:
            raise InputError(
                f"{path}: the script has no parameter '{name}'{did_you_mean(name, parameters)}. {_listing(parameters)}"
            )
        parameter = parameters[name]
        try:
            values[name] = _converted(parameter, value)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"{path}: {value!r} does not fit the parameter '{name}' ({_type_name(parameter)}): {error}. "
                f"{_listing(parameters)}"
            ) from error
    return values


def _converted(parameter: Any, value: Any) -> Any:
    kind = parameter.varType.__name__
    if kind == "NumberParameterType":
        return _number(parameter.default_value, value)
    if kind == "BooleanParameterType":
        words = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
        if str(value).strip().lower() not in words:
            raise ValueError("give True or False")
        return words[str(value).strip().lower()]
    if kind == "TupleParameterType":
        if isinstance(value, str):
            value = [part.strip() for part in value.strip("()[] ").split(",") if part.strip()]
        if len(value) != len(parameter.default_value):
            raise ValueError(f"give {len(parameter.default_value)} values")
        return tuple(
            _number(old, new) if isinstance(old, (int, float)) and not isinstance(old, bool) else new
            for old, new in zip(parameter.default_value, value, strict=True)
        )
    if not isinstance(value, str):
        raise TypeError("give a text")
    return value


def _number(default: Any, value: Any) -> int | float:
    if isinstance(value, bool):
        raise ValueError("give a number")
    number = float(value)
    if not math.isfinite(number):
        raise ValueError("the number must be finite")
    # A count must stay whole: range(4.0) raises in the script. Text tells "4" from "4.0".
    if isinstance(default, int) and number.is_integer():
        return int(number)
    return number


def _type_name(parameter: Any) -> str:
    return _TYPES.get(parameter.varType.__name__, "value")


def _listing(parameters: Mapping[str, Any]) -> str:
    if not parameters:
        return "It has no parameters: parameters are constants assigned at the script's top level."
    parts = [f"{name} = {p.default_value!r} ({_type_name(p)})" for name, p in parameters.items()]
    return "Its parameters: " + ", ".join(parts) + "."


def _script_line(error: BaseException | None, filename: str) -> int | None:
    if error is None:
        return None
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == filename]
    return lines[-1] if lines else getattr(error, "lineno", None)


def _at(line: int | None) -> str:
    return "" if line is None else f", line {line}"


def _short(error: BaseException | None) -> str:
    text = " ".join(str(error).split()) or "no message"
    text = text if len(text) <= 300 else text[:297] + "..."
    if type(error).__module__.startswith("OCP."):  # its messages name its own classes at best
        text += "; mostly a length, radius or height there is 0 or too large for the shape"
    return text


class _Capped(io.TextIOBase):
    """A text stream that keeps its first characters and counts the rest."""

    def __init__(self) -> None:
        self.kept: list[str] = []
        self.size = 0

    def writable(self) -> bool:
        return True

    def write(self, text: str) -> int:
        room = _MOST_LOGGED - self.size
        if room > 0:
            self.kept.append(text[:room])
        self.size += len(text)
        return len(text)


@contextlib.contextmanager
def _captured_output(path: Path) -> Iterator[None]:
    stream = _Capped()
    try:
        with contextlib.redirect_stdout(stream), contextlib.redirect_stderr(stream):
            yield
    finally:
        text = "".join(stream.kept).strip()
        if text:
            more = f" ... ({stream.size} characters in all)" if stream.size > _MOST_LOGGED else ""
            logger.info("%s prints: %s%s", path, text, more)


@contextlib.contextmanager
def _beside(path: Path) -> Iterator[None]:
    """Let the script import modules from its own folder, and find its own, as Python would.

    ``dataclasses`` looks up the module of a class by name, and cqgi runs a script as ``__cqgi__``.
    """
    folder = str(path.resolve().parent)
    sys.path.insert(0, folder)
    before = sys.modules.get(_MODULE)
    sys.modules[_MODULE] = ModuleType(_MODULE)
    try:
        yield
    finally:
        with contextlib.suppress(ValueError):
            sys.path.remove(folder)
        if before is None:
            sys.modules.pop(_MODULE, None)
        else:
            sys.modules[_MODULE] = before
