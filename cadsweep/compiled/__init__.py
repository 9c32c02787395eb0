"""Compiled loops: functions that numba compiles, and machine code of theirs that is run without numba.

Place in the flow: a foundation; whoever has a loop over numbers asks for :func:`compiled`. `kernels` says when numba is
needed, `machine_code` keeps and loads what it made. Needs numpy, numba and numba's own ``llvmlite``.
"""

from .kernels import Kernel, compiled

__all__ = ["Kernel", "compiled"]
