"""What got slower between two commits: ``python benchmarks/compare.py OLD NEW [--turns 3] [-- arguments of cad.py]``.

Both are checked out beside each other and run through the same benchmark in turns, so that a machine that slows down
slows both; the least of each figure counts.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

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


def figures(tree: Path, arguments: list[str]) -> tuple[dict[str, float], dict[str, str]]:
    """Seconds by name, from one turn of ``cad.py`` with the package of a tree, and what became of every part."""
    command = [sys.executable, str(HERE / "cad.py"), "--json", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    # A session of its own: what is ended here would leave the processes of its parts behind.
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            answer, _ = process.communicate()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    data = json.loads(answer)
    found = {f"{row['part']}, {what}": row[what] for row in data["parts"] if "all" in row for what in ("load", "all")}
    found |= {f"start-up, {name}": seconds for name, seconds in (data["start"] or {}).items()}
    return found, {row["part"]: outcome(row) for row in data["parts"]}


def outcome(row: dict[str, Any]) -> str:
    """What became of a part: a time says little where this has changed."""
    if "hexes" in row:
        return f"{row['hexes']:,} hexes"
    return "refused" if "refused" in row else str(row["failed"])


def main() -> int:
    """Measure both in turns, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--turns", type=int, default=3)
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    options = parser.parse_args(words[:split])
    # As an error, so that the folders with the commits are removed.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    least: list[dict[str, float]] = [{}, {}]
    became: list[dict[str, str]] = [{}, {}]
    with checked_out(options.old) as old, checked_out(options.new) as new:
        for turn in range(options.turns + 1):  # the first one compiles, and does not count
            for j, tree in enumerate((old, new)):
                found, became[j] = figures(tree, words[split + 1 :])
                for name, seconds in found.items() if turn else ():
                    least[j][name] = min(seconds, least[j].get(name, seconds))
    return report(least, became)


def report(least: list[dict[str, float]], became: list[dict[str, str]]) -> int:
    """Print the figures of both and what became otherwise; return 1 where one got slower or has no answer any more."""
    worse = 0
    for name in (name for name in least[1] if name in least[0]):  # a part without an answer has no figure: see below
        ratio = least[1][name] / least[0][name]
        worse += ratio > SLOWER
        print(
            f"{name:32s} {least[0][name]:8.2f} s {least[1][name]:8.2f} s  {ratio:5.2f}{'  slower' * (ratio > SLOWER)}"
        )
    for part in became[0]:
        if became[0][part] != became[1][part]:
            lost = "hexes" in became[0][part] and "hexes" not in became[1][part]
            worse += lost
            print(f"{part:32s} {became[0][part]} -> {became[1][part]}{'  lost' * lost}")
    return int(worse > 0)


if __name__ == "__main__":
    sys.exit(main())
