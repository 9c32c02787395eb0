"""A swept mesh as a file of factors, ``.sweep.npz``: megabytes for a mesh of any number of layers.

Place in the flow: ``pipeline`` saves a :class:`~cadsweep.blocks.block.FactoredMesh` here and makes the same mesh
again, bit for bit, without CAD or gmsh.

The file is a numpy archive: the arrays of the factored sweep (:mod:`cadsweep.projection.storage`), the owner of
every boundary quad, the nodes that smoothing moved, and one JSON text with the names.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..cells import SweptStructure
from ..errors import InputError, no_such_file
from ..projection import FactoredSweep
from .block import FactoredMesh

_PREFIX = "mesh_"


def factor_arrays(factored: FactoredMesh) -> dict[str, Any]:
    """The arrays of a numpy archive of `factored`."""
    structure = factored.structure
    text = {
        "owner_names": factored.owner_names,
        "part": factored.part,
        "periodic": structure.periodic,
        "scale": factored.scale,
        "info": {key: value for key, value in factored.info.items() if key != "quality"},
    }
    arrays: dict[str, Any] = {
        "source_owners": factored.source_owners.astype(np.int32),
        "target_owners": factored.target_owners.astype(np.int32),
        "side_owners": factored.side_owners.astype(np.int32),
        "moved_nodes": factored.moved_nodes,
        "moved_points": factored.moved_points,
        "offset": factored.offset,
        "text": np.array(json.dumps(text)),
    }
    return {**factored.sweep.to_arrays(), **{_PREFIX + name: array for name, array in arrays.items()}}


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


def has_factors(arrays: Mapping[str, Any]) -> bool:
    """Whether arrays are, or have among them, those of :func:`factor_arrays`."""
    return _PREFIX + "text" in arrays


def factored_of_arrays(arrays: dict[str, Any]) -> FactoredMesh:
    """The factors again."""
    text = json.loads(str(arrays[_PREFIX + "text"]))
    sweep = FactoredSweep.of_arrays(arrays)
    return FactoredMesh(
        sweep=sweep,
        structure=SweptStructure(
            quads=sweep.quads,
            loops=sweep.loops,
            n_nodes=sweep.n_nodes,
            n_layers=sweep.n_layers,
            periodic=bool(text["periodic"]),
        ),
        owner_names=tuple(tuple(names) for names in text["owner_names"]),
        source_owners=arrays[_PREFIX + "source_owners"].astype(np.int64),
        target_owners=arrays[_PREFIX + "target_owners"].astype(np.int64),
        side_owners=arrays[_PREFIX + "side_owners"].astype(np.int64),
        moved_nodes=arrays[_PREFIX + "moved_nodes"],
        moved_points=arrays[_PREFIX + "moved_points"],
        part=text["part"],
        scale=float(text["scale"]),
        offset=arrays[_PREFIX + "offset"],
        info=text["info"],
    )
