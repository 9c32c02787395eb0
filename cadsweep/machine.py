"""What the machine has to give.

Foundation; imports nothing that takes time.
"""

from __future__ import annotations

GIGABYTE = 1e9


def free_memory() -> float:
    """Memory that a run may take, GB: nine tenths of what the machine and the container have free."""
    import psutil

    free = float(psutil.virtual_memory().available)
    for limit_file, used_file in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        limit, used = _read_number(limit_file), _read_number(used_file)
        if limit is not None and used is not None:
            free = min(free, max(limit - used, 0.0))
    return 0.9 * free / GIGABYTE


def _read_number(path: str) -> float | None:
    try:
        with open(path, encoding="ascii") as file:
            return float(file.read())
    except (OSError, ValueError):  # no such control group, or no limit ("max")
        return None
