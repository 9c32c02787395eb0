"""Which thresholds nothing notices: thresholds.py FOLDER [FOLDER ...] [--room ROOM] [--most N] [--json FILE]

Numbers in capitals at module level are halved, and doubled, a whole room at once, over parts that mesh in a few
seconds; where a mesh changes (its way, its hexahedra, its worst one), the group is halved until single numbers are
left. A number that no part notices either way should be derived from another one, or leave.

Folders hold STEP and BREP files; --most takes the N parts of them that mesh fastest. Numbers within compiled loops are
frozen when these are compiled, and are not reached. --json keeps what is known, and that is not run again.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import logging
import multiprocessing
import resource
import sys
import time
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

import cadsweep as cs

PACKAGE = Path(cs.__file__).parent
SUFFIXES = (".step", ".stp", ".brep")
LIMIT = 30
"""Seconds of the processor that a part may take."""


class Threshold(NamedTuple):
    """A number, and the module whose name it is."""

    module: str
    name: str

    @property
    def room(self) -> str:
        """The room that the module is in."""
        return self.module.split(".")[1]


def thresholds(room: str) -> list[Threshold]:
    """All numbers of a room that stand in capitals at module level."""
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(["cadsweep", *path.relative_to(PACKAGE).with_suffix("").parts])
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not (isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)):
                continue
            target, value = node.targets[0], node.value.value
            is_number = isinstance(value, int | float) and not isinstance(value, bool) and value
            if isinstance(target, ast.Name) and target.id.isupper() and is_number:
                found.append(Threshold(module, target.id))
    return [one for one in found if one.room == room or not room]


def scale(group: Sequence[Threshold], factor: float) -> None:
    """Multiply thresholds in the module that has them and in all that have imported them."""
    for module, name in group:
        old = getattr(importlib.import_module(module), name)
        new = type(old)(max(1, round(old * factor))) if isinstance(old, int) else old * factor
        for known in list(sys.modules.values()):
            if getattr(known, "__name__", "").startswith("cadsweep") and vars(known).get(name) == old:
                setattr(known, name, new)


def _child(path: Path, group: Sequence[Threshold], factor: float, answer: Connection) -> None:
    logging.disable(logging.CRITICAL)
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 1))
    scale(group, factor)
    try:
        mesh = cs.sweep_mesh(path)
    except cs.CadSweepError as error:
        answer.send([type(error).__name__])
    else:
        answer.send([str(mesh.record.way), mesh.n_hexes, round(float(mesh.info["quality"].min_scaled_jacobian), 3)])


def look(path: Path, group: Sequence[Threshold] = (), factor: float = 1.0) -> list[Any]:
    """What is seen of a part's mesh, made in a process of its own."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_child, args=(path, group, factor, theirs))
    child.start()
    theirs.close()
    try:
        return list(ours.recv())
    except EOFError:
        return ["ended"]
    finally:
        child.join()


def unnoticed(group: Sequence[Threshold], factor: float, usual: dict[Path, list[Any]]) -> list[Threshold]:
    """Those of a group that no part notices: all of them, or what is left of its halves."""
    if not group:
        return []
    if all(look(path, group, factor) == seen for path, seen in usual.items()):
        return list(group)
    half = len(group) // 2
    return unnoticed(group[:half], factor, usual) + unnoticed(group[half:], factor, usual) if half else []


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--room", default="", help="one room alone, as surface")
    parser.add_argument("--most", type=int, default=40)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    known: dict[str, list[str]] = {}
    if asked.json and asked.json.exists():
        known = json.loads(asked.json.read_text(encoding="utf-8"))
    for module in {one.module for one in thresholds(asked.room)}:
        importlib.import_module(module)
    spent: dict[Path, float] = {}
    usual: dict[Path, list[Any]] = {}
    for path in [path for folder in asked.folders for path in sorted(folder.iterdir()) if path.suffix in SUFFIXES]:
        begun = time.perf_counter()
        usual[path] = look(path)
        spent[path] = time.perf_counter() - begun
    quick = sorted((path for path in usual if len(usual[path]) > 1), key=lambda path: spent[path])[: asked.most]
    usual = {path: usual[path] for path in quick}
    print(f"{len(usual)} parts, {sum(spent[path] for path in quick):.0f} s a look at all")
    for room in sorted({one.room for one in thresholds(asked.room)}):
        own = thresholds(room)
        if room not in known:
            halved = set(unnoticed(own, 0.5, usual))
            known[room] = [f"{one.module}.{one.name}" for one in unnoticed(own, 2.0, usual) if one in halved]
            if asked.json:
                asked.json.write_text(json.dumps(known, indent=0), encoding="utf-8")
        print(
            f"{room}: {len(known[room])} of {len(own)} are noticed by no part: {', '.join(known[room]) or '-'}",
            flush=True,
        )


if __name__ == "__main__":
    main()
