"""How many parts of a set mesh, how well and how fast: parts.py (FOLDER | --machined N) [--from K] [--every K]

The set is a folder, or the first N random parts of `machined.py`, written as STEP files to --keep or a folder that is
deleted; --only takes those whose names contain one of some words. Every STEP, BREP and script file is meshed as it is,
without a hint, each in a process of its own, which is ended after --limit seconds of processor time (0: never): a part
that is out of time counts as refused. A line a part: hexahedra, worst scaled Jacobian, cells, seconds of processor
time, or the refusal; then the rates and all refusals. The finished mesh is checked again from its hexes alone: every
corner Jacobian positive, every quad used once or twice, the volume within 2 % of the CAD's.

--json FILE keeps the figures after every part; the same command with --resume goes on where it was ended.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import logging
import multiprocessing
import resource
import signal
import tempfile
import time
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median

import numpy as np

import cadsweep as cs
from cadsweep.cells import HEX_FACES

SUFFIXES = (".step", ".stp", ".brep", ".py")


def judge(mesh: cs.HexMesh) -> str:
    """What is wrong with a mesh, by its corners and quads alone; empty where nothing is."""
    corners = mesh.points[mesh.hexes[:, :8]]
    ahead = np.array([(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)])
    edges = corners[:, ahead] - corners[:, :, None]
    if (np.linalg.det(edges) <= 0).any():
        return "a corner Jacobian is not positive"
    quads = np.sort(mesh.hexes[:, HEX_FACES].reshape(-1, 4), axis=1)
    _, uses = np.unique(quads, axis=0, return_counts=True)
    if uses.max() > 2:
        return "a quad belongs to more than two hexahedra"
    volume, wanted = mesh.info["quality"].volume, mesh.info["cad_volume"]
    return "" if abs(volume - wanted) <= 0.02 * wanted else f"volume {volume:.6g} instead of {wanted:.6g}"


def mesh_one(path: Path) -> dict[str, object]:
    """Figures of one part."""
    start = time.process_time()
    row: dict[str, object] = {"part": path.stem}
    try:
        mesh = cs.sweep_mesh(path)
        fault = judge(mesh)
        row |= {
            "ok": not fault,
            "fault": fault,
            "n_hexes": mesh.n_hexes,
            "min_scaled_jacobian": float(mesh.info["quality"].min_scaled_jacobian),
            "n_cells": max(1, len(mesh.info.get("sweeps", []))),
            "cut": any(note.startswith("cut ") for note in mesh.info["notes"]),
        }
    except cs.CadSweepError as error:
        row |= {"ok": False, "fault": f"{type(error).__name__}: {error}"}
    return row | {"seconds": round(time.process_time() - start, 1)}


def _child(path: Path, limit: int, answer: Connection) -> None:
    logging.disable(logging.WARNING)
    if limit:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
    answer.send(mesh_one(path))


def mesh_apart(path: Path, limit: int) -> dict[str, object]:
    """The same in a process of its own: what crashes or does not end costs one part."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("spawn").Process(target=_child, args=(path, limit, theirs))
    child.start()
    theirs.close()
    row: dict[str, object] | None = None
    with contextlib.suppress(EOFError):  # it ended without an answer: said below
        row = ours.recv()
    child.join()
    if row is None:
        late = limit and child.exitcode in (-signal.SIGXCPU, -signal.SIGKILL)
        fault = f"out of time ({limit} s)" if late else f"the process ended with {child.exitcode}"
        row = {"part": path.stem, "ok": False, "fault": fault, "seconds": float(limit)}
    return row


def write_machined(folder: Path, seeds: range) -> list[Path]:
    """Random machined parts as STEP files."""
    import cadquery as cq
    from machined import machined

    paths = []
    for seed in seeds:
        paths.append(folder / f"machined_{seed:03d}.step")
        cq.exporters.export(machined(seed), str(paths[-1]))
    return paths


def main() -> None:
    """Mesh the set and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", help="a folder of parts")
    parser.add_argument("--machined", type=int, default=0, metavar="N", help="seeds below N instead of a folder")
    parser.add_argument("--keep", type=Path, help="where the parts of the seeds are written")
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="K", help="the first part")
    parser.add_argument("--every", type=int, default=1, metavar="K", help="take every K-th")
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="take those with such names")
    parser.add_argument("--limit", type=int, default=120, help="seconds of processor time a part; 0: none")
    parser.add_argument("--json", type=Path, help="where the figures are kept")
    parser.add_argument("--resume", action="store_true", help="leave out what --json has")
    arguments = parser.parse_args()
    if (arguments.folder is None) == (not arguments.machined):
        parser.error("either a folder or --machined N")
    if arguments.resume and arguments.json is None:
        parser.error("--resume needs --json")
    with tempfile.TemporaryDirectory() as scratch:
        if arguments.machined:
            folder = arguments.keep or Path(scratch)
            folder.mkdir(parents=True, exist_ok=True)
            files = write_machined(folder, range(arguments.first, arguments.machined, arguments.every))
        else:
            files = sorted(path for path in arguments.folder.iterdir() if path.suffix in SUFFIXES)
            files = files[arguments.first :: arguments.every]
        if arguments.only:
            files = [path for path in files if any(word in path.stem for word in arguments.only)]
        rows = json.loads(arguments.json.read_text()) if arguments.resume and arguments.json.exists() else []
        done = {row["part"] for row in rows}
        for path in files:
            if path.stem in done:
                continue
            row = mesh_apart(path, arguments.limit)
            rows.append(row)
            print(f"{'ok' if row['ok'] else '--'} {row['part']}: {_said(row)}, {row['seconds']} s", flush=True)
            if arguments.json:
                arguments.json.write_text(json.dumps(rows, indent=1))
    report(rows)


def _said(row: dict[str, object]) -> str:
    if not row["ok"]:
        return str(row["fault"])
    return f"{row['n_hexes']} hexes, worst {row['min_scaled_jacobian']:.3f}, {row['n_cells']} cells"


def report(rows: list[dict[str, object]]) -> None:
    """Print the rates, then every refusal."""
    if not rows:
        print("no parts")
        return
    good = [row for row in rows if row["ok"]]
    worst = [float(str(row["min_scaled_jacobian"])) for row in good]
    seconds = [float(str(row["seconds"])) for row in rows]
    print(f"{len(good)} of {len(rows)} meshed, {sum(bool(row['cut']) for row in good)} of them cut")
    if good:
        print(f"worst scaled Jacobian: least {min(worst):.3f}, median {median(worst):.3f}")
    print(f"seconds: median {median(seconds):.1f}, most {max(seconds):.1f}")
    for row in rows:
        if not row["ok"]:
            print(f"refused: {row['part']}: {_said(row)}")


if __name__ == "__main__":
    main()
