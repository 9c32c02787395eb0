"""Machine code that is kept answers as numba does, bit for bit, in a process that never imports numba."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cadsweep.compiled import Kernel, machine_code
from cadsweep.compiled.kernels import kind_of
from cadsweep.quality.conformity import _scan_hexes
from cadsweep.quality.hulls import hulls_apart
from cadsweep.quality.kernels import measure_hexes
from cadsweep.quality.structure import _follows_structure
from cadsweep.quality.surface_kernels import facet_slack

HEXES = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
RNG = np.random.default_rng(1)
POINTS = np.array([(x, y, z) for z in range(3) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]) + RNG.random((12, 3)) / 9


def calls() -> list[tuple[Kernel, tuple]]:
    """Loops that between them have every kind of argument and of result, and memory of their own."""
    return [
        (measure_hexes, (POINTS, HEXES, np.zeros((8, 2)))),  # nothing; allocates
        (_scan_hexes, (HEXES, 12, np.zeros(12, dtype=np.bool_))),  # four numbers
        (_follows_structure, (HEXES, HEXES[:1, :4], 4, 2, False)),  # yes or no
        (hulls_apart, (POINTS[:4].copy(), POINTS[8:].copy(), 1e-9)),  # allocates, and calls others
        (facet_slack, (POINTS, HEXES[:, :4].copy(), np.full(8, -1), 0.5)),  # two numbers; libm
    ]


def answers() -> list[str]:
    """All bits of what the calls return, and of the arrays that they fill."""
    found = []
    for kernel, args in calls():
        result = kernel(*args)
        found.append(repr(result) + "".join(a.tobytes().hex() for a in args if isinstance(a, np.ndarray)))
    return found


def test_a_process_without_numba_gets_the_same_bits():
    for kernel, args in calls():
        kernel.dispatcher(*args)
        machine_code.keep(kernel.function, kind_of(args), kernel.dispatcher)
    run = subprocess.run(
        [sys.executable, "-m", __name__], capture_output=True, text=True, cwd=Path(__file__).parents[2], check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.split("\n")[:-1] == answers()


@pytest.mark.parametrize(
    "value", [POINTS[:, :2], POINTS.T, None, (1, 2), np.int32(3)], ids=["strided", "turned", "none", "tuple", "int32"]
)
def test_other_arguments_are_left_to_numba(value):
    def function():
        """A function that nothing is kept of."""

    assert machine_code.load(function, (kind_of(value),)) is None


def test_calls_go_to_numba_where_a_process_has_it():
    import numba  # noqa: F401

    flags = np.zeros(12, dtype=np.bool_)
    n_dispatched = len(_scan_hexes.dispatcher.overloads)
    assert _scan_hexes(HEXES.astype(np.int32), 12, flags)[0] == 0
    assert len(_scan_hexes.dispatcher.overloads) == n_dispatched + 1


if __name__ == "__main__":
    print(*answers(), sep="\n")
    assert "numba" not in sys.modules
