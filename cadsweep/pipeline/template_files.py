"""Meshes with what others need to be like them, as ``.sweep.npz`` files.

Place in the flow: ``cadsweep mesh -o base.sweep.npz`` writes them, ``--like`` and ``cadsweep expand`` read them. The
mesh of one sweep is kept as its factors (:mod:`cadsweep.blocks.files`), one of blocks as theirs
(:mod:`cadsweep.blocks.cell_files`), any other as its arrays; of solids that do not touch the file holds one after
another, each with a number before its names. Pairs of nodes on periodic faces stand beside any of them.
"""

from __future__ import annotations

import json
from dataclasses import replace
from os import PathLike
from typing import Any, BinaryIO

import numpy as np

from ..blocks.files import factor_arrays, factored_of_arrays, reading
from ..errors import InputError
from ..mesh import HexMesh
from .cells_template import CellsTemplate, cells_arrays, cells_of_arrays, mesh_arrays, mesh_of_arrays
from .template import (
    PREFIX,
    AnyTemplate,
    GroupsTemplate,
    Template,
    make_template,
    template_arrays,
    template_of_arrays,
    tuples,
)

_CELLS, _GROUPS, _PAIRS = "cells_", "groups_", "pairs_"


def save_template(mesh: HexMesh, stream: BinaryIO) -> None:
    """Write a mesh of order 1 so that others can be made like it."""
    arrays = _arrays(make_template(mesh, "a file of factors"))
    np.savez_compressed(stream, **arrays | {_PAIRS + names: nodes for names, nodes in mesh.periodic.items()})


def load_template(path: str | PathLike[str]) -> AnyTemplate:
    """Read what :func:`save_template` wrote.

    Raises
    ------
    InputError
        The file is missing, damaged, something else, or says nothing of the CAD model.
    """
    with reading(path) as arrays:
        return _template(arrays, str(path))


def load_mesh(path: str | PathLike[str]) -> HexMesh:
    """The mesh of a file; raises as :func:`load_template`."""
    with reading(path) as arrays:
        own = _own(arrays, _CELLS) or _own(arrays, _GROUPS)
        mesh = mesh_of_arrays(own) if own else factored_of_arrays(arrays).to_mesh()
        return replace(mesh, periodic=_own(arrays, _PAIRS))


def _arrays(template: AnyTemplate) -> dict[str, Any]:
    if isinstance(template, Template):
        return {**factor_arrays(template.factored), **template_arrays(template)}
    if isinstance(template, CellsTemplate):
        return {_CELLS + name: array for name, array in cells_arrays(template).items()}
    text = {"groups": [names for names, _ in template.groups], "solids": template.solids}
    arrays: dict[str, Any] = {"groups": np.array(json.dumps(text)), **mesh_arrays(template.mesh)}
    for number, (_, own) in enumerate(template.groups):
        arrays |= {f"{number}_{name}": array for name, array in _arrays(own).items()}
    return {_GROUPS + name: array for name, array in arrays.items()}


def _own(arrays: dict[str, Any], prefix: str) -> dict[str, Any]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}


def _template(arrays: dict[str, Any], path: str) -> AnyTemplate:
    cells, groups = _own(arrays, _CELLS), _own(arrays, _GROUPS)
    if cells:
        return cells_of_arrays(cells)
    if groups:
        text = json.loads(str(groups["groups"]))
        return GroupsTemplate(
            groups=tuple(
                (tuples(names), _template(_own(groups, f"{number}_"), path))
                for number, names in enumerate(text["groups"])
            ),
            mesh=mesh_of_arrays(groups),
            solids=text["solids"],
        )
    if PREFIX + "text" not in arrays:
        factored_of_arrays(arrays)  # which says what is wrong, if it is no such file
        raise InputError(f"{path}: this file of factors says nothing of the CAD model's faces; write it anew")
    return template_of_arrays(factored_of_arrays(arrays), arrays)
