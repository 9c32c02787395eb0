"""The command line and the Python script that make the mesh of a session, bit for bit.

Place in the flow: options of ``sweep_mesh`` (:mod:`.wishes`) go in, text comes out.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from typing import Any


def to_command(source: str, output: str, options: Mapping[str, Any]) -> str:
    """The command that makes the mesh, ready to be pasted into a shell.

    Parameters
    ----------
    source, output : str
    options : mapping
        Of ``sweep_mesh``, as :meth:`cadsweep.app.wishes.Asked.options` makes them.
    """
    words = ["cadsweep", "mesh", source, "-o", output]
    for name, value in options.items():
        words += _FLAGS[name](value)
    return shlex.join(words)


def to_script(source: str, output: str, options: Mapping[str, Any]) -> str:
    """The Python script that makes the mesh and writes it; `source` empty: a part that the script must make itself."""
    lines = ["import cadsweep as cs", ""]
    if not source:
        lines += ["part = ...  # the object that the page was opened with", ""]
    lines += ["mesh = cs.sweep_mesh(", f"    {source!r}," if source else "    part,"]
    lines += [f"    {name}={_written(name, value)}," for name, value in options.items()]
    return "\n".join([*lines, ")", f"mesh.write({output!r})", "print(mesh.quality())", ""])


def _written(name: str, value: Any) -> str:
    if name == "wall_layers":
        rows = [f"{word!r}: cs.WallLayers({_keywords(one)})" for word, one in value.items()]
        return "{" + ", ".join(rows) + "}"
    if name == "biases":
        rows = [f"{word!r}: cs.EdgeBias({_keywords(one)})" for word, one in value.items()]
        return "{" + ", ".join(rows) + "}"
    return repr(value)


def _keywords(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key}={value!r}" for key, value in values.items())


def _plain(flag: str) -> Callable[[Any], list[str]]:
    return lambda value: [flag, _text(value)]


def _repeated(flag: str) -> Callable[[Any], list[str]]:
    return lambda values: [word for value in values for word in (flag, _text(value))]


def _assigned(flag: str, text: Callable[[Any], str] | None = None) -> Callable[[Any], list[str]]:
    write = text or _text
    return lambda values: [word for key, value in values.items() for word in (flag, f"{key}={write(value)}")]


def _text(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def _names(values: Mapping[str, Any]) -> list[str]:
    pairs = [
        (name, one) for name, chosen in values.items() for one in ([chosen] if isinstance(chosen, str) else chosen)
    ]
    return [word for name, one in pairs for word in ("--name", f"{name}={one}")]


def _sizes(values: Mapping[str, float]) -> list[str]:
    words = []
    for key, value in values.items():
        kind, colon, rest = key.partition(":")
        flag = {"faces": "--face-size", "edges": "--edge-size"}.get(kind if colon else "", "--size")
        words += [flag, f"{rest if flag != '--size' else key}={value!r}"]
    return words


def _walls(value: Mapping[str, Any]) -> str:
    return f"{value['first']!r}:{value['growth']!r}:{value['n']}"


def _bias(value: Mapping[str, Any]) -> str:
    return f"{value['ratio']!r}@{value['towards']}"


_FLAGS: dict[str, Callable[[Any], list[str]]] = {
    "size": _plain("--size"),
    "tolerance": _plain("--tolerance"),
    "layers": _plain("--layers"),
    "order": _plain("--order"),
    "max_hexes": _plain("--max-hexes"),
    "names": _names,
    "sizes": _sizes,
    "counts": _assigned("--edge-count"),
    "biases": _assigned("--edge-bias", _bias),
    "wall_layers": _assigned("--wall-layers", _walls),
    "periodic": _assigned("--periodic"),
    "suppress": _repeated("--suppress"),
    "cuts": _repeated("--cut"),
    "skip": lambda values: ["--skip", ",".join(values)],
    "params": _assigned("--param", lambda value: repr(value) if isinstance(value, str) else _text(value)),
}
