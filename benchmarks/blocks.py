"""Random blocks meshed as columns: blocks.py [--seeds FROM-TO] [--features N] [--size S] [--snap STEP] [--json OUT]

Each block has pockets and bosses from both sides at random places, as `generators.block` makes them; nothing is cut
into cells of several directions. A line a block: hexahedra, columns, worst scaled Jacobian, seconds of processor time,
or the refusal; then the rate. The finished mesh is checked again from its hexes alone, as in parts.py.
"""

from __future__ import annotations

import argparse
import json
import logging
import time
from pathlib import Path

from generators import block
from parts import judge

import cadsweep as cs


def mesh_one(seed: int, *, features: int, size: float | None, snap: float | None) -> dict[str, object]:
    """Figures of one block."""
    part = block(seed, features, snap=snap)
    start = time.process_time()
    row: dict[str, object] = {"seed": seed}
    try:
        mesh = cs.sweep_mesh(part, size=size, decompose=False)
        fault = judge(mesh)
        row |= {
            "ok": not fault,
            "fault": fault,
            "n_hexes": mesh.n_hexes,
            "n_columns": mesh.info["sweeps"][0].get("columns", 1),
            "min_scaled_jacobian": float(mesh.info["quality"].min_scaled_jacobian),
        }
    except cs.CadSweepError as error:
        row |= {"ok": False, "fault": f"{type(error).__name__}: {error}"}
    return row | {"seconds": round(time.process_time() - start, 1)}


def main() -> None:
    """Mesh the blocks and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0-49")
    parser.add_argument("--features", type=int, default=30)
    parser.add_argument("--size", type=float)
    parser.add_argument("--snap", type=float)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    logging.disable(logging.WARNING)
    first, last = (int(word) for word in arguments.seeds.split("-"))
    rows = []
    for seed in range(first, last + 1):
        row = mesh_one(seed, features=arguments.features, size=arguments.size, snap=arguments.snap)
        rows.append(row)
        what = (
            f"{row['n_hexes']} hexes, {row['n_columns']} columns, worst {row['min_scaled_jacobian']:.3f}"
            if row["ok"]
            else row["fault"]
        )
        print(f"{'ok' if row['ok'] else '--'} {seed}: {what}, {row['seconds']} s", flush=True)
    print(f"{sum(bool(row['ok']) for row in rows)} of {len(rows)} meshed")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
