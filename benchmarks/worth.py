"""What each rule is worth: worth.py FOLDER [FOLDER ...] [--machined N] [--only ROW] [--limit S] [--json FILE]

Every part is meshed as it is, in a process of its own, and tells which rows of the tables of rules had a share in its
mesh (``mesh.record.rows``). Then one row after the other is switched off (``without=[row]``) over the parts in which it
had a share, and a line says what is lost: parts, worst and median scaled Jacobian, seconds of the processor. A row that
loses nothing should go; one that no part reaches is listed as such.

Folders hold STEP and BREP files and scripts; --machined adds the first N random parts of ``machined.py``. --json keeps
all figures, and what is in it already is not run again.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import resource
import tempfile
import time
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median
from typing import Any

import cadsweep as cs
from cadsweep.pipeline.tables import all_rows

SUFFIXES = (".step", ".stp", ".brep", ".py")


def mesh_one(path: Path, without: str | None) -> dict[str, Any]:
    """Figures of one part with all rows on, or all but one."""
    start = time.process_time()
    try:
        mesh = cs.sweep_mesh(path, without=[without] if without else [])
    except cs.CadSweepError as error:
        return {"worst": None, "why": type(error).__name__, "seconds": time.process_time() - start}
    worst = float(mesh.info["quality"].min_scaled_jacobian)
    return {"worst": worst, "rows": list(mesh.record.rows or ()), "seconds": time.process_time() - start}


def _child(path: Path, without: str | None, limit: int, answer: Connection) -> None:
    logging.disable(logging.WARNING)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
    answer.send(mesh_one(path, without))


def mesh_apart(path: Path, without: str | None, limit: int) -> dict[str, Any]:
    """The same in a process of its own, that is ended after `limit` seconds of the processor."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_child, args=(path, without, limit, theirs))
    child.start()
    theirs.close()
    try:
        return ours.recv()
    except EOFError:
        return {"worst": None, "why": "ended", "seconds": float(limit)}
    finally:
        child.join()


def written_machined(n: int, folder: Path) -> list[Path]:
    """The first random machined parts as STEP files."""
    paths = [folder / f"machined-{seed:03d}.step" for seed in range(n)]
    # CadQuery starts threads of OpenCASCADE, which no copy of this process could ask anything of again.
    child = multiprocessing.get_context("spawn").Process(target=_write_machined, args=(paths,))
    child.start()
    child.join()
    return paths


def _write_machined(paths: list[Path]) -> None:
    import cadquery as cq
    from machined import machined

    for seed, path in enumerate(paths):
        cq.exporters.export(machined(seed), str(path))


def say(row: str, before: list[dict[str, Any]], after: list[dict[str, Any]]) -> str:
    """One line: what is lost without a row, over the parts in which it had a share."""
    lost = sum(b["worst"] is not None and a["worst"] is None for b, a in zip(before, after, strict=True))
    both = [
        (b["worst"], a["worst"]) for b, a in zip(before, after, strict=True) if None not in (b["worst"], a["worst"])
    ]
    falls = [b - a for b, a in both]
    middle = median(falls) if falls else float("nan")
    seconds = sum(a["seconds"] for a in after) - sum(b["seconds"] for b in before)
    return (
        f"{row:44s} {len(before):5d} {lost:5d} {max(falls, default=float('nan')):8.3f} {middle:8.3f} "
        f"{sum(f < -0.02 for f in falls):6d} {seconds:+9.1f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--machined", type=int, default=0, metavar="N")
    parser.add_argument("--only", default="", help="rows whose names contain this")
    parser.add_argument("--limit", type=int, default=60, help="seconds of the processor a part")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    known: dict[str, dict[str, Any]] = {}
    if asked.json and asked.json.exists():
        known = json.loads(asked.json.read_text(encoding="utf-8"))

    def measured(path: Path, without: str | None) -> dict[str, Any]:
        key = f"{path.name} without {without}" if without else path.name
        if key not in known:
            known[key] = mesh_apart(path, without, asked.limit)
            if asked.json:
                asked.json.write_text(json.dumps(known, indent=0), encoding="utf-8")
        return known[key]

    with tempfile.TemporaryDirectory() as folder:
        paths = [path for given in asked.folders for path in sorted(given.iterdir()) if path.suffix in SUFFIXES]
        paths += written_machined(asked.machined, Path(folder))
        whole = {path: measured(path, None) for path in paths}
        meshed = [path for path in paths if whole[path]["worst"] is not None]
        print(f"{len(meshed)} of {len(paths)} parts mesh, in {sum(w['seconds'] for w in whole.values()):.0f} s")
        print(f"{'row':44s} parts  lost    worst   median better   seconds")
        unreached = []
        for row in all_rows():
            own = [path for path in meshed if row in whole[path]["rows"]]
            if asked.only not in row:
                continue
            if not own:
                unreached.append(row)
                continue
            print(say(row, [whole[path] for path in own], [measured(path, row) for path in own]), flush=True)
        print("no part reaches:", "; ".join(unreached) or "none")


if __name__ == "__main__":
    main()
