"""What placing the nodes of a sweep costs, against filling the same array once.

Run: ``python benchmarks/projection.py [--nodes 1e5 1e6 1e7 5e7] [--repeats 5]``

Every ratio is of two times measured in one run, each the best of several, into memory that has been touched before;
the fill is ``out.fill(1.0)``, on one thread. Peak memory is that of ``points()`` into a fresh array, by tracemalloc,
over the result's own size.
"""

from __future__ import annotations

import argparse
import time
import tracemalloc
from collections.abc import Callable

import numpy as np

from cadsweep.projection import FactoredSweep, project_layers
from cadsweep.projection.fitting import fit_from_caps, fit_steps


def best(work: Callable[[], object], repeats: int) -> float:
    """Least time of several runs, in seconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def square_section(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A domed square of n x n quads: points, quads, boundary loop."""
    u = np.linspace(-1.0, 1.0, n + 1)
    x, y = np.meshgrid(u, u)
    points = np.stack([x, y, 0.2 * (1 - x**2) * (1 - y**2)], axis=-1).reshape(-1, 3)
    ids = np.arange(len(points)).reshape(n + 1, n + 1)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    loop = np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])
    return points, quads, loop


def bent_rings(points: np.ndarray, loop: np.ndarray, n_layers: int, *, n_shapes: int) -> tuple[np.ndarray, np.ndarray]:
    """Rings on a quarter bend and the target cap; `n_shapes` waves of the boundary that no affine map makes."""
    t = np.linspace(0.0, 1.0, n_layers + 1)[:, None, None]
    angle = 0.5 * np.pi * t
    zero = np.zeros_like(angle)
    R = np.concatenate(
        [
            np.concatenate([zero + 1, zero, zero], axis=2),
            np.concatenate([zero, np.cos(angle), -np.sin(angle)], axis=2),
            np.concatenate([zero, np.sin(angle), np.cos(angle)], axis=2),
        ],
        axis=1,
    )
    center = np.array([0.0, 4.0, 0.0])
    ring = np.broadcast_to(points[loop], (n_layers + 1, len(loop), 3)).copy()
    for j in range(n_shapes):
        wave = 0.03 * np.sin((2 + j) * np.pi * points[loop, 1])[:, None] * np.array([1.0, 0.0, 0.0])
        ring += t ** (1 + j) * (1 - 0.3 * j * t) * wave
    rings = (ring - center) @ R.transpose(0, 2, 1) + center
    target = (points - center) @ R[-1].T + center
    target[loop] = rings[-1]
    return rings, target


def sweep_of(n_nodes: float, *, strategy: str, n_shapes: int) -> FactoredSweep:
    """A sweep of about `n_nodes` nodes with layers of 10,000 (1,024 below a million)."""
    side = 99 if n_nodes >= 1e6 else 31
    points, quads, loop = square_section(side)
    n_layers = max(2, round(n_nodes / len(points)) - 1)
    rings, target = bent_rings(points, loop, n_layers, n_shapes=n_shapes)
    return project_layers(points, quads, rings, loops=[loop], strategy=strategy, target_points=target)


def place_ratio(sweep: FactoredSweep, repeats: int) -> tuple[float, float, int]:
    """Time to place all nodes over the time to fill the array, the fill in seconds, and r."""
    out = np.zeros((len(sweep.rings), sweep.n_nodes, 3))
    sweep.points(out=out)
    place, fill = [], []
    for _ in range(repeats):  # in turn, so that both meet the machine in the same mood
        fill.append(best(lambda: out.fill(1.0), 1))
        place.append(best(lambda: sweep.points(out=out), 1))
    return min(place) / min(fill), min(fill), sweep.basis.shape[1]


def peak_ratio(sweep: FactoredSweep) -> float:
    """Peak memory of making all points, over their own size."""
    tracemalloc.start()
    points = sweep.points()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / points.nbytes


def fit_ratios(repeats: int) -> dict[str, float]:
    """All fits of 1,000 layers with a ring of 1,000 nodes, over the fill of 1e7 nodes."""
    points, _, loop = square_section(250)
    rings, _ = bent_rings(points, loop, 1000, n_shapes=2)
    out = np.zeros((1000, 10_000, 3))
    fill = best(lambda: out.fill(1.0), repeats)
    loops = [np.arange(len(loop))]
    works: dict[str, Callable[[], object]] = {
        f"{functional} from the source": lambda f=functional: fit_from_caps(rings, loops, f, caps=(0,))  # type: ignore[misc]
        for functional in "FGH"
    }
    works["H from both caps"] = lambda: fit_from_caps(rings, loops, "H", caps=(0, -1))
    works["H from layer to layer"] = lambda: fit_steps(rings, loops, "H")
    return {name: best(work, repeats) / fill for name, work in works.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=float, nargs="+", default=[1e5, 1e6, 1e7, 5e7])
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    print("place all nodes / fill the same array")
    print(f"{'nodes':>10} {'caps':>7} {'modes':>6} {'r':>3} {'ratio':>6} {'fill, s':>8} {'peak':>5}")
    for n_nodes in options.nodes:
        for strategy, n_shapes in (("source", 0), ("source", 4), ("both", 0), ("both", 4)):
            sweep = sweep_of(n_nodes, strategy=strategy, n_shapes=n_shapes)
            ratio, fill, r = place_ratio(sweep, options.repeats)
            peak = peak_ratio(sweep)
            print(f"{n_nodes:>10.0e} {strategy:>7} {sweep.n_modes:>6} {r:>3} {ratio:>6.2f} {fill:>8.4f} {peak:>5.2f}")
    print("\nall fits of 1,000 layers with a ring of 1,000 nodes / fill of 1e7 nodes")
    for name, ratio in fit_ratios(options.repeats).items():
        print(f"{name:>24} {ratio:>6.2f}")


if __name__ == "__main__":
    main()
