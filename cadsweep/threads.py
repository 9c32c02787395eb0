"""Work shared by a few threads: chunks of an array, and one thing beside another.

The compiled loops release the interpreter's lock, so plain threads share the work. (numba's own
parallel loops may not be entered by two threads at once on every threading layer, and take several
times as long to compile.)
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")

CHUNK = 32_768
"""Rows that are worked on at once."""

LIGHT = 8 * CHUNK
"""Rows at once where each takes a nanosecond or ten: fewer are done before a second thread has begun."""

MOST_THREADS = 8
"""Beyond a few, threads wait for memory."""


def n_threads() -> int:
    """Processors that this process may use, at most `MOST_THREADS`."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(usable, MOST_THREADS)


def map_chunks(work: Callable[[slice], T], n: int, *, chunk: int = CHUNK) -> Iterator[T]:
    """Yield ``work(chunk)`` for consecutive slices of ``range(n)``, in order, whatever the number of threads."""
    chunks = [slice(first, min(first + chunk, n)) for first in range(0, n, chunk)]
    threads = min(n_threads(), len(chunks))
    if threads <= 1:
        yield from map(work, chunks)
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="chunks") as pool:
        # A few at a time: results wait in memory until they are asked for.
        wave = 4 * threads
        for first in range(0, len(chunks), wave):
            yield from pool.map(work, chunks[first : first + wave])


@contextmanager
def beside(work: Callable[[], T], *, pays: bool = True) -> Iterator[Callable[[], T]]:
    """Do `work` in a thread while the block runs, and give the block a function that waits for its result.

    What either raises is raised as if `work` had been done first.

    Parameters
    ----------
    work : callable
    pays : bool
        Whether there is so much to do that a thread is worth its start; else `work` is done first.
    """
    if not pays or n_threads() == 1:
        result = work()
        yield lambda: result
        return
    with ThreadPoolExecutor(1, thread_name_prefix="beside") as pool:
        running = pool.submit(work)
        try:
            yield running.result
        finally:
            running.result()
