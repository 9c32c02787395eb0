"""Kept machine code does what freshly compiled code does, and is there without numba's compiler."""

import subprocess
import sys

LOOPS = """
from cadsweep.compiled import compiled

@compiled(cache=True, nogil=True)
def doubled(values):
    if len(values) == 0:
        raise ValueError("nothing to double")
    return 2 * values

@compiled(cache=True)
def total(values):
    twice, sum = doubled(values), 0.0
    for value in twice:
        sum += value
    return sum

@compiled()
def square_total(values):
    return total(values) ** 2
"""

USE = """
import sys
import numpy as np
from loops import *

print(doubled(np.arange(3.0)), doubled(np.arange(3)), total(np.arange(3.0)))
try:
    doubled(np.empty(0))
except ValueError as error:
    print(error)
print("without the compiler" if "numba.np.arraymath" not in sys.modules else "with the compiler")
print(square_total(np.arange(3.0)))
"""


def test_kept_loops_run_without_compiler_and_go_into_new_ones(tmp_path):
    (tmp_path / "loops.py").write_text(LOOPS)
    (tmp_path / "use.py").write_text(USE)
    first, second = (
        subprocess.run([sys.executable, tmp_path / "use.py"], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    )
    assert first.splitlines() == ["[0. 2. 4.] [0 2 4] 6.0", "nothing to double", "with the compiler", "36.0"]
    assert second == first.replace("with the compiler", "without the compiler")
