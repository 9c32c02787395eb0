"""How fast meshes are written, against ``ndarray.tofile`` of as many bytes, flushed to the disk as well.

    python benchmarks/writing.py [--hexes 1000000] [--repeat 5] [--json]

Both write to a new file in turn, and the medians are compared. Ours is the whole promise: the file is written without a
name, flushed to the disk, read back, compared, and put in place. The plain way writes and flushes; how long it takes
when it leaves the flushing to the system is told beside it.

Then, by the processor's time, which a busy machine does not stretch: hexahedra a second written, without and with the
reading back. The goal is 2e6 for binary formats, or a quarter of the disk's rate where that is less, and 3e5 for text.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from cadsweep import io
from cadsweep.cells import side_quads, sweep_hexes
from cadsweep.mesh import HexMesh

BINARY = {".vtu", ".vtkhdf", ".msh", ".cgns", ".med", ".e", ".exo", ".re2", ".xyz"}


def make_box(n_hexes: int) -> HexMesh:
    """A cube of about so many hexes with its six sides named."""
    n = max(1, round(n_hexes ** (1 / 3)))
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    ids = np.arange(x.size).reshape(x.shape)
    quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1).reshape(-1, 4)
    loop = np.concatenate([ids[:-1, 0], ids[-1, :-1], ids[:0:-1, -1], ids[0, :0:-1]])
    sides = np.split(side_quads([loop], x.size, n), 4, axis=1)
    layers = [np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=-1) for z in np.linspace(0, 1, n + 1)]
    return HexMesh(
        points=np.concatenate(layers),
        hexes=sweep_hexes(quads, x.size, n),
        boundaries={"source": quads[:, ::-1], "target": quads + n * x.size}
        | {f"side_{j}": side.reshape(-1, 4) for j, side in enumerate(sides, 1)},
    )


def measure(mesh: HexMesh, suffix: str, folder: Path, repeat: int) -> dict[str, float | str]:
    """Medians of writing a mesh, and of ``tofile`` of as many bytes with and without a flush, seconds."""
    ours: list[float] = []
    flushed: list[float] = []
    cached: list[float] = []
    path, bare = folder / ("polyMesh" if suffix == ".polymesh" else f"mesh{suffix}"), folder / "plain.bin"
    mesh.write(path)  # loops that are compiled are, and the caches of both are filled
    files = list(path.iterdir()) if path.is_dir() else [path]
    values = np.random.default_rng(0).random(sum(file.stat().st_size for file in files) // 8)
    for _ in range(repeat):
        _remove(path)
        start = time.perf_counter()
        mesh.write(path)
        ours.append(time.perf_counter() - start)
        bare.unlink(missing_ok=True)
        start = time.perf_counter()
        with bare.open("wb") as stream:
            values.tofile(stream)
            cached.append(time.perf_counter() - start)
            os.fsync(stream.fileno())
        flushed.append(time.perf_counter() - start)
    rates = {}
    for name, verify in (("rate", False), ("checked_rate", True)):
        start = time.process_time()
        mesh.write(path, verify=verify)
        rates[name] = mesh.n_hexes / (time.process_time() - start)
    goal = min(2e6, 0.25 * mesh.n_hexes / statistics.median(flushed)) if suffix in BINARY else 3e5
    seconds, reference = statistics.median(ours), statistics.median(flushed)
    return {
        "suffix": suffix,
        "megabytes": values.nbytes / 1e6,
        "seconds": seconds,
        "tofile_seconds": reference,
        "cached_seconds": statistics.median(cached),
        "ratio": seconds / reference,
        **rates,
        "goal": goal,
    }


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hexes", type=int, default=1_000_000)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--suffixes", nargs="+", default=[".vtkhdf", ".msh", ".vtu"], choices=list(io.FORMATS))
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    mesh = make_box(options.hexes)
    with tempfile.TemporaryDirectory(dir=".") as folder:
        rows = [measure(mesh, suffix, Path(folder), options.repeat) for suffix in options.suffixes]
    if options.json:
        json.dump({"n_hexes": mesh.n_hexes, "files": rows}, sys.stdout, indent=2)
        return
    for row in rows:
        print(
            "{suffix:8} {megabytes:7.1f} MB {seconds:7.3f} s, flushed tofile {tofile_seconds:6.3f} s: {ratio:.1f} x "
            "(not flushed {cached_seconds:6.3f} s); "
            "{rate:.2g} hexes/s, checked {checked_rate:.2g}, goal {goal:.2g}".format(**row)
        )


if __name__ == "__main__":
    main()
