"""What the machine has to give.

Foundation; imports nothing that takes time.
"""

from __future__ import annotations

import os

GIGABYTE = 1e9


def free_memory() -> float:
    """Memory that a run may take, GB: nine tenths of what the machine and the container have free."""
    free = _available_memory()
    for limit_file, used_file in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        limit, used = _read_number(limit_file), _read_number(used_file)
        if limit is not None and used is not None:
            free = min(free, max(limit - used, 0.0))
    return 0.9 * free / GIGABYTE


def resident_memory(pid: int) -> int | None:
    """Memory that a process holds, bytes; None where there is no such process."""
    try:
        with open(f"/proc/{pid}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):  # gone, or a system without such files
        import psutil

        try:
            return int(psutil.Process(pid).memory_info().rss)
        except psutil.NoSuchProcess:
            return None


def _available_memory() -> float:
    """What the kernel could give, bytes; Linux says it in a file, and psutil takes a while to import."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            return next(1024.0 * int(line.split()[1]) for line in file if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        import psutil

        return float(psutil.virtual_memory().available)


def _read_number(path: str) -> float | None:
    try:
        with open(path, encoding="ascii") as file:
            return float(file.read())
    except (OSError, ValueError):  # no such control group, or no limit ("max")
        return None
