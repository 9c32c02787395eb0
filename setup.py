"""What ``pyproject.toml`` cannot say: a wheel holds the machine code of the loops that numba compiles.

So a wheel is for one Python and one kind of machine. ``pip install .`` makes one, and so has it too; a folder that is
installed to be edited has not, and compiles when a loop is first used. Where ``CADSWEEP_PURE=1`` is set, or for
machines that :mod:`cadsweep.processor` does not know, the wheel is for all, and compiles like that.
"""

import os
import platform
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

sys.path.insert(0, str(Path(__file__).parent))
from cadsweep.processor import BASELINE

MADE = platform.system() == "Linux" and platform.machine() in BASELINE and os.environ.get("CADSWEEP_PURE") != "1"
GLIBC = "manylinux_2_17"
"""Machine code asks of the C library what ``scripts/check_wheel.py`` lists, all of it older than this."""


class Compiled(build_py):
    """The package, and beside it the machine code, made from the package as it will be installed."""

    def run(self) -> None:
        super().run()
        if MADE and not self.editable_mode:
            package = Path(self.build_lib) / "cadsweep"
            self.announce(f"compiling loops for {BASELINE[platform.machine()][0]}: about a minute", level=2)
            subprocess.run([sys.executable, "scripts/compile_kernels.py", str(package)], check=True)


class Tagged(bdist_wheel):
    """A wheel with machine code has no module that is linked with anything, so its C library may be an old one."""

    def finalize_options(self) -> None:
        if MADE and not self.plat_name:
            self.plat_name = f"{GLIBC}_{platform.machine()}"
        super().finalize_options()


class Platform(Distribution):
    """A distribution for one Python and machine."""

    def has_ext_modules(self) -> bool:
        return MADE


setup(distclass=Platform, cmdclass={"build_py": Compiled, "bdist_wheel": Tagged})
