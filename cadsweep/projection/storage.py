"""A factored sweep as a file of a few megabytes: arrays in a compressed ``.npz``, nothing that follows from the rest.

Place in the flow: :meth:`FactoredSweep.save` and :meth:`FactoredSweep.load`.
"""

from __future__ import annotations

import zipfile
from os import PathLike

import numpy as np

from ..errors import InputError

FORMAT = "cadsweep factored sweep 2"


def write(arrays: dict[str, np.ndarray], path: str | PathLike[str]) -> None:
    """Write the arrays of a sweep at exactly `path`."""
    with open(path, "wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def read(path: str | PathLike[str]) -> dict[str, np.ndarray]:
    """Read what :func:`write` wrote.

    Raises
    ------
    InputError
        The file is damaged, or of another kind.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as a factored sweep ({error})") from error
    if str(arrays.get("format")) != FORMAT:
        raise InputError(f"{path}: not a factored sweep of this version (wanted {FORMAT!r})")
    return arrays
