"""The processor that a wheel's machine code is made for, and whether this one can run it."""

from __future__ import annotations

import platform

__all__ = ["BASELINE", "can_run"]

BASELINE = {
    "x86_64": (
        "x86-64-v3",
        "+avx,+avx2,+bmi,+bmi2,+cx16,+f16c,+fma,+lzcnt,+movbe,+popcnt,+sse3,+sse4.1,+sse4.2,+ssse3",
    ),
    "aarch64": ("generic", "+neon"),
}
"""By machine, a processor's name and features as LLVM has them: what all since 2013 (Intel) and 2015 (AMD) can."""


def can_run(features: str) -> bool:
    """Whether a processor of these features, as LLVM writes them, can do what machine code of a wheel asks of it."""
    if platform.machine() not in BASELINE:
        return False
    _, needed = BASELINE[platform.machine()]
    return set(needed.split(",")) <= set(features.split(","))
