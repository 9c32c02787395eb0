"""Kept machine code does what freshly compiled code does, and is there without numba's compiler."""

import importlib
import os
import platform
import subprocess
import sys
from pathlib import Path

from numba import types

from cadsweep import compiled, processor

ROOT = Path(__file__).parents[1]

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


WITH_FOLDER = """
import logging, sys
from pathlib import Path
import numpy as np
from numba import types
from cadsweep import compiled, processor

logging.basicConfig(format="%(message)s", stream=sys.stdout)
logging.getLogger("cadsweep.compiled").setLevel("INFO")
compiled.FOLDER = Path("machine_code")
import loops
"""

MAKE = (
    WITH_FOLDER
    + """
compiled.FOLDER.mkdir()
compiled.put_machine_code(loops.doubled, (types.float64[::1],), compiled.FOLDER)
"""
)

LOAD = (
    WITH_FOLDER
    + """
print(loops.doubled(np.arange(3.0)))
"""
)

SAID = "compiling loops for this machine, "


def test_loop_of_the_package_is_compiled_again_only_for_another_numba_source_or_processor(tmp_path):
    (tmp_path / "loops.py").write_text(LOOPS)

    def run(code, **environment):
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}", **environment},
        )
        return done.stdout.splitlines()

    def caching_in(name):
        return {"NUMBA_CACHE_DIR": str(tmp_path / name)}

    baseline = dict(zip(("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"), processor.BASELINE[platform.machine()], strict=True))
    run(MAKE, **caching_in("made"), **baseline)
    assert run(LOAD, **caching_in("a")) == ["[0. 2. 4.]"]

    older = "processor.BASELINE = {}\n"
    assert run(LOAD.replace("import loops\n", older + "import loops\n"), **caching_in("b")) == [
        f"{SAID}once",
        "[0. 2. 4.]",
    ]
    other = "from numba.core import caching; caching.numba.__version__ = '0.1'\nimport loops\n"
    assert run(LOAD.replace("import loops\n", other), **caching_in("c")) == [f"{SAID}once", "[0. 2. 4.]"]
    (tmp_path / "loops.py").write_text(LOOPS.replace("2 * values", "3 * values"))
    assert run(LOAD, **caching_in("d")) == [f"{SAID}once", "[0. 3. 6.]"]
    assert run(LOAD, **caching_in("d")) == ["[0. 3. 6.]"]


def test_loops_are_compiled_where_nothing_can_be_written(tmp_path):
    (tmp_path / "loops.py").write_text(LOOPS)
    nowhere = "from numba.core.caching import CacheImpl; CacheImpl._locator_classes = []\nimport loops\n"
    said = subprocess.run(
        [sys.executable, "-c", LOAD.replace("import loops\n", nowhere)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}"},
    ).stdout
    assert said.splitlines() == [f"{SAID}and no folder can be written to keep them in", "[0. 2. 4.]"]


def test_what_a_wheel_compiles_are_loops_with_their_arguments():
    lines = (ROOT / "cadsweep" / "signatures.txt").read_text().splitlines()
    assert lines == sorted(set(lines))
    for line in lines:
        home, _, asked = line.partition(" ")
        module, _, name = home.partition(":")
        loop = getattr(importlib.import_module(module), name)
        assert loop in compiled.kept_loops, line
        signature = eval(asked, {**vars(types), "bool": types.boolean})
        assert len(signature) == loop.py_func.__code__.co_argcount, line
