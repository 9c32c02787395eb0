"""A swept mesh as a file of factors, ``.sweep.npz``: megabytes for a mesh of any number of layers.

Place in the flow: ``pipeline`` saves a :class:`~cadsweep.blocks.block.FactoredMesh` here and makes the same mesh
again, bit for bit, without CAD or gmsh.

The file is a numpy archive: the arrays of the factored sweep (:mod:`cadsweep.projection.storage`), the owner of
every boundary quad, the nodes that smoothing moved, and one JSON text with the names.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, no_such_file


@contextmanager
def reading(path: str | PathLike[str]) -> Iterator[dict[str, Any]]:
    """All arrays of a file, for somebody who makes a mesh of them.

    Raises
    ------
    InputError
        The file is missing, damaged, or something else.
    """
    if Path(path).is_file() and not zipfile.is_zipfile(path):  # numpy would talk of pickles
        raise InputError(f"{path}: not a file of sweep factors (.sweep.npz), or a damaged one; write or copy it again")
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        yield arrays
    except FileNotFoundError:
        raise InputError(no_such_file(path)) from None
    except (OSError, KeyError, ValueError, EOFError, TypeError, IndexError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{path}: not a file of sweep factors, or a damaged one ({error}); write or copy it again"
        ) from error
