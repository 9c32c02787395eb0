"""Parts that nobody prepared: how many get a mesh, a reason, a wrong one, none, or one too late.

    python benchmarks/unprepared.py --folder ../shared/parts/real --odd 60

Every model is meshed without a hint in a process of its own, and the mesh judged as in parts.py. *Wrong blame* is a
refusal that calls a model damaged which OpenCASCADE finds valid; *late* is more than 60 seconds of processor time.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import signal
from collections import Counter
from pathlib import Path
from typing import Any

from parts import judge

import cadsweep as cs

LATE = 60.0
"""Seconds of processor time after which an answer is late."""
ENDED = 180
"""Seconds of processor time after which a model's process is ended."""
_BLAME = re.compile(r"damaged|repair|runs into itself|not closed|not manifold|off its face")


def valid(shape: Any) -> bool:
    """Whether OpenCASCADE finds nothing wrong with a shape."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    return bool(BRepCheck_Analyzer(shape).IsValid())


def answer(source: Any, shape: Any) -> str:
    """What becomes of a part: a word for it, and details."""
    try:
        mesh = cs.sweep_mesh(source)
    except cs.CadSweepError as error:
        said = " | ".join(str(error).splitlines())
        blamed = _BLAME.search(error.message) and (shape is None or valid(shape))
        return f"{'wrong blame' if blamed else 'reason'}: {type(error).__name__}: {said}"
    except Exception as error:  # what is not ours is a crash to whoever calls
        return f"crash: {type(error).__name__}: {error}"
    fault = judge(mesh)
    return f"wrong mesh: {fault}" if fault else f"mesh: {mesh.n_hexes} {mesh.quality().min_scaled_jacobian:.2f}"


def in_a_process(source: Any, shape: Any) -> tuple[str, float]:
    """The answer, and the processor time that it took, of a copy of this process."""
    ours, theirs = os.pipe()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (ENDED, ENDED))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.write(theirs, answer(source, shape).encode()[:4000])
        os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as stream:
        said = stream.read().decode("utf-8", "replace")
    _, status = os.waitpid(child, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if said:
        return said, took
    how = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else str(status)
    return f"{'none' if took >= ENDED - 1 else 'crash'}: {how}", took


def main() -> None:
    """Mesh the parts of a folder and a number of odd models, and count."""
    from odd_models import odd_model

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, help="with STEP files of valid solids")
    parser.add_argument("--odd", type=int, default=0, help="number of odd models")
    parser.add_argument("--first", type=int, default=0, help="number of the first odd model")
    args = parser.parse_args()
    models = [(path.stem, str(path), None) for path in sorted(args.folder.glob("*.st*p"))] if args.folder else []
    for number in range(args.first, args.first + args.odd):
        name, shape = odd_model(number)
        models.append((name, _Wrapped(shape), shape))
    counts: Counter[str] = Counter()
    for name, source, shape in models:
        said, took = in_a_process(source, shape)
        counts[said.split(":")[0]] += 1
        counts["late"] += took > LATE
        print(f"{name:32s} {took:6.1f} s  {said}", flush=True)
    print(", ".join(f"{n} {word}" for word, n in sorted(counts.items())), "of", len(models))


class _Wrapped:
    """A shape as :func:`cadsweep.load` takes those of any program."""

    def __init__(self, shape: Any) -> None:
        self.wrapped = shape


if __name__ == "__main__":
    main()
