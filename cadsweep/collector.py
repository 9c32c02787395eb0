"""Python's collector of garbage, kept away from what libraries make when they are imported.

Foundation; imports nothing that takes time.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_resting() -> Iterator[None]:
    """Let nobody look for garbage in the block, nor soon among what it has made.

    OpenCASCADE and numba make some hundred thousand objects that all stay. Looking through them takes a tenth of their
    import, and the first look afterwards would go through all of them at once. For what is done once in a process:
    whoever does this in a loop has no garbage of older objects collected.
    """
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        if gc.get_freeze_count() == 0:  # otherwise the program has set objects aside itself
            gc.freeze()  # frozen and given back at once, all objects count as old
            gc.unfreeze()
        gc.enable()
