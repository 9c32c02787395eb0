"""Results of any size: the arrays of a value go through a file, the rest as a pickle.

The file lies in memory where there is room; the reader maps it privately, so that a mesh of gigabytes
costs no copy, and its arrays are writable. The file has no name any more once it is mapped.
"""

from __future__ import annotations

import mmap
import os
import pickle
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ALIGNMENT = 64
"""Bytes: a line of the processor's cache, and what numpy's own arrays are aligned to."""


@dataclass(frozen=True, kw_only=True)
class Packed:
    """A value on its way: a pickle, and where the bytes of its arrays lie.

    Attributes
    ----------
    pickle : bytes
    path : str or None
        File of the arrays' bytes, None where there are none.
    spans : tuple of (int, int)
        Start and length of every array in the file.
    """

    pickle: bytes
    path: str | None
    spans: tuple[tuple[int, int], ...]


def pack(value: Any, folders: Sequence[Path]) -> Packed:
    """Write the arrays of a value into the first of the folders that has room for them."""
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps(value, protocol=5, buffer_callback=buffers.append)
    blocks = [buffer.raw() for buffer in buffers]
    spans, total = [], 0
    for block in blocks:
        spans.append((total, block.nbytes))
        total += -(-block.nbytes // ALIGNMENT) * ALIGNMENT
    if total == 0:
        return Packed(pickle=data, path=None, spans=tuple(spans))
    for folder in folders:
        if folder == folders[-1] or shutil.disk_usage(folder).free > 1.1 * total:
            path = folder / "result"
            try:
                _write(path, blocks, spans, total)
            except OSError:
                path.unlink(missing_ok=True)
                if folder == folders[-1]:
                    raise
            else:
                return Packed(pickle=data, path=str(path), spans=tuple(spans))
    raise AssertionError("the last folder either takes the result or raises")


def _write(path: Path, blocks: list[memoryview], spans: list[tuple[int, int]], total: int) -> None:
    with open(path, "xb", buffering=0) as file:
        for block, (start, _) in zip(blocks, spans, strict=True):
            file.seek(start)
            view = block
            while view.nbytes:
                view = view[file.write(view) :]
        os.ftruncate(file.fileno(), total)


def unpack(packed: Packed) -> Any:
    """The value again; its arrays share the pages of the file, and keep them."""
    if packed.path is None:
        return pickle.loads(packed.pickle, buffers=[bytearray() for _ in packed.spans])
    with open(packed.path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        pages = mmap.mmap(file.fileno(), size, flags=mmap.MAP_PRIVATE, prot=mmap.PROT_READ | mmap.PROT_WRITE)
    os.unlink(packed.path)
    whole = memoryview(pages)
    return pickle.loads(packed.pickle, buffers=[whole[start : start + length] for start, length in packed.spans])
