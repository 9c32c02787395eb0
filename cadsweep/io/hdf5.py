"""Reading HDF5 that may be damaged: no array is larger than its file can hold."""

from __future__ import annotations

import h5py
import numpy as np

from ..errors import InputError

_MOST_COMPRESSED = 1100
"""Times that deflate makes data smaller, at the most."""


def load(data: h5py.Dataset) -> np.ndarray:
    """Return a dataset's values.

    Raises
    ------
    InputError
        It claims more bytes than the file can hold.
    """
    room = data.file.id.get_filesize() * (1 if data.chunks is None else _MOST_COMPRESSED)
    if data.size * data.dtype.itemsize > room:
        raise InputError(f"its array {data.name} claims {data.size} values, more than the file can hold: it is damaged")
    return data[()]
