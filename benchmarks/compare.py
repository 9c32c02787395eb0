"""What got slower between two commits: ``python benchmarks/compare.py OLD NEW``.

Both are checked out beside each other and run through the same benchmark in turns, so that a machine that slows down
slows both; the least of each figure counts.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
SLOWER = 1.1
"""Ratio from which a figure is called slower: processor time differs by less from turn to turn."""


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """A folder with the commit's files, removed at the end."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "tree"
        subprocess.run(["git", "worktree", "add", "--quiet", "--detach", str(folder), commit], check=True, cwd=HERE)
        try:
            yield folder
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", str(folder)], check=True, cwd=HERE)


def figures(tree: Path, arguments: list[str]) -> dict[str, float]:
    """Seconds by name, from one turn of ``cad.py`` with the package of a tree."""
    answer = subprocess.run(
        [sys.executable, str(HERE / "cad.py"), "--json", *arguments],
        env={**os.environ, "PYTHONPATH": str(tree)},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    data = json.loads(answer.stdout)
    found = {f"{row['part']}, {what}": row[what] for row in data["parts"] if "all" in row for what in ("load", "all")}
    return found | {f"start-up, {name}": seconds for name, seconds in (data["start"] or {}).items()}


def main() -> int:
    """Print every figure of both and their ratio; return 1 where one got slower."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="for cad.py, after --")
    options = parser.parse_args()
    passed = [argument for argument in options.arguments if argument != "--"]
    least: list[dict[str, float]] = [{}, {}]
    with checked_out(options.old) as old, checked_out(options.new) as new:
        for tree in (old, new):
            figures(tree, passed)  # compiles
        for _ in range(options.turns):
            for known, tree in zip(least, (old, new), strict=True):
                for name, seconds in figures(tree, passed).items():
                    known[name] = min(seconds, known.get(name, seconds))
    slower = 0
    for name, seconds in least[1].items():
        ratio = seconds / least[0][name]
        slower += ratio > SLOWER
        print(f"{name:32s} {least[0][name]:8.2f} s {seconds:8.2f} s  {ratio:5.2f}{'  slower' * (ratio > SLOWER)}")
    return int(slower > 0)


if __name__ == "__main__":
    sys.exit(main())
