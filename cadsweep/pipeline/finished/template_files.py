"""Meshes with what others need to be like them, as ``.sweep.npz`` files.

Place in the flow: ``cadsweep mesh -o base.sweep.npz`` writes them, ``--like`` and ``cadsweep expand`` read them. A mesh
of blocks is kept as their factors (:mod:`cadsweep.blocks.cell_files`), any other as its arrays; of solids that do not
touch the file holds one after another, each with a number before its names. Pairs of nodes on periodic faces stand
beside any of them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import Any, BinaryIO

import numpy as np

from ...arrays import FloatArray, IntArray, small_ints
from ...blocks.cell_files import cells_as_arrays, cells_from_arrays
from ...blocks.files import reading
from ...brep import Units
from ...mesh import HexMesh
from ...projection.carried import MeshedFace
from ...quality.conformity import row_keys
from ..origin import DesignChoice
from .graphs import Graph
from .template import AnyTemplate, DesignTemplate, FactoredCells, GroupsTemplate, Template, make_template

_CELLS, _GROUPS, _DESIGN, _PAIRS = "cells_", "groups_", "design_", "pairs_"
_DESIGN_TEXT = ("names", "labels", "solids")
_UV, _FACTORS, _SCALE = "uv_", "factors_", "scale"


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
        own = _own(arrays, _CELLS) or _own(arrays, _GROUPS) or _own(arrays, _DESIGN)
        return replace(_mesh_of_arrays(own), periodic=_own(arrays, _PAIRS))


def _arrays(template: AnyTemplate) -> dict[str, Any]:
    if isinstance(template, Template):
        return {_CELLS + name: array for name, array in _template_arrays(template).items()}
    if isinstance(template, DesignTemplate):
        known = {"choice": template.choice, **{name: getattr(template, name) for name in _DESIGN_TEXT}}
        every = {"design": np.array(json.dumps(known)), **_mesh_arrays(template.mesh)}
        every |= {f"0_{name}": array for name, array in _arrays(template.design).items()}
        return {_DESIGN + name: array for name, array in every.items()}
    text = {"groups": [names for names, _ in template.groups], "solids": template.solids}
    arrays: dict[str, Any] = {"groups": np.array(json.dumps(text)), **_mesh_arrays(template.mesh)}
    for number, (_, own) in enumerate(template.groups):
        arrays |= {f"{number}_{name}": array for name, array in _arrays(own).items()}
    return {_GROUPS + name: array for name, array in arrays.items()}


def _own(arrays: dict[str, Any], prefix: str) -> dict[str, Any]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}


def _template(arrays: dict[str, Any], path: str) -> AnyTemplate:
    cells, groups = _own(arrays, _CELLS), _own(arrays, _GROUPS)
    if cells:
        return _template_of_arrays(cells)
    if groups:
        text = json.loads(str(groups["groups"]))
        return GroupsTemplate(
            groups=tuple(
                (_tuples(names), _template(_own(groups, f"{number}_"), path))
                for number, names in enumerate(text["groups"])
            ),
            mesh=_mesh_of_arrays(groups),
            solids=text["solids"],
        )
    designs = _own(arrays, _DESIGN)
    if designs:
        known = json.loads(str(designs["design"]))
        return DesignTemplate(
            design=_template(_own(designs, "0_"), path),
            mesh=_mesh_of_arrays(designs),
            choice=DesignChoice(*_tuples(known["choice"])),
            **{name: _tuples(known[name]) for name in _DESIGN_TEXT},
        )
    raise KeyError("no faces of a model")


def _template_arrays(template: Template) -> dict[str, Any]:
    """A template as arrays."""
    factored = template.factored
    text = {
        "graph": {name: getattr(template.graph, name) for name in Graph.__dataclass_fields__},
        "outside": sorted(template.outside.items()),
        "between": sorted(template.between.items()),
        "patches": sorted(template.patches.items()),
        "first_faces": template.first_faces,
        "first": template.first,
        "solids": template.solids,
        "faces": list(template.faces),
        "edges": list(template.edges),
        "answers": sorted(template.answers.items()),
        "twins": None if template.twins is None else sorted(template.twins.items()),
        "is_swept": template.is_swept,
        "choice": template.choice if _is_plain(template.choice) else (None, None),
    }
    arrays: dict[str, Any] = {
        "text": np.array(json.dumps(text)),
        "hex_solids": _runs_of(template.hex_solids),
        "quads": small_ints(template.quads),
        "quad_faces": template.quad_faces,
        "vertices": template.vertices,
    }
    arrays |= _mesh_arrays(template.mesh, placed=factored is None)
    for kind in ("boundaries", "interfaces"):
        for j, quads in enumerate(getattr(template.mesh, kind).values()):
            rows = _rows_in(template.quads, quads)
            if rows is not None:
                arrays[f"{kind}_{j}"] = _runs_of(rows - np.arange(len(rows)))
    if factored is None:
        arrays["points"] = template.points
    else:
        arrays |= {_FACTORS + name: array for name, array in cells_as_arrays(factored.cells).items()}
        arrays |= {_SCALE: np.array(factored.units.scale), "offset": factored.units.offset}
    arrays |= {f"{_UV}{face}": meshed.uv for face, meshed in template.faces.items() if meshed.uv is not None}
    for edge, (nodes, fractions) in template.edges.items():
        arrays[f"on_{edge}"], arrays[f"at_{edge}"] = nodes, fractions
    return arrays


def _is_plain(value: Any) -> bool:
    try:
        json.dumps(value)
    except TypeError:
        return False
    return True


def _template_of_arrays(own: Mapping[str, Any]) -> Template:
    """The template again."""
    text = json.loads(str(own["text"]))
    own = {**own, "quads": own["quads"].astype(np.int64)}
    quads, ids, hex_solids = own["quads"], own["quad_faces"], own["hex_solids"]
    factored = _factored_of_arrays(own)
    if factored is not None:
        points, placed, hexes = factored.placed()
        mesh = _named(own, placed, hexes)
    else:
        points, mesh = own["points"], _mesh_of_arrays(own)
    twins = text.get("twins")
    return Template(
        points=points,
        mesh=mesh,
        graph=Graph(**{name: _tuples(value) for name, value in text["graph"].items()}),
        hex_solids=_values_of_runs(hex_solids) if hex_solids.ndim == 2 else hex_solids,
        quads=quads,
        quad_faces=ids,
        faces={face: _meshed_face(quads[ids == face], points, own.get(f"{_UV}{face}")) for face in text["faces"]},
        edges={edge: (own[f"on_{edge}"], own[f"at_{edge}"]) for edge in text["edges"]},
        vertices=own["vertices"],
        outside={face: tuple(names) for face, names in text["outside"]},
        between={face: tuple(names) for face, names in text["between"]},
        patches={face: tuple(map(tuple, names)) for face, names in text.get("patches", ())},
        first_faces=tuple(text["first_faces"]),
        first=tuple(text["first"]),
        solids=text["solids"],
        factored=factored,
        answers=dict(text.get("answers", ())),
        twins=None if twins is None else dict(twins),
        is_swept=text.get("is_swept", False),
        choice=tuple(text.get("choice", (None, None))),
    )


def _meshed_face(quads: IntArray, points: FloatArray, uv: FloatArray | None) -> MeshedFace:
    """A meshed face again, from its quads and its parameters."""
    nodes, local = np.unique(quads, return_inverse=True)
    return MeshedFace(nodes=nodes, quads=local.reshape(-1, 4), points=points[nodes], uv=uv)


def _mesh_arrays(mesh: HexMesh, *, placed: bool = True) -> dict[str, Any]:
    """A mesh of order 1 as arrays, for a numpy archive; without nodes and hexes where it is not `placed`."""
    named = {kind: getattr(mesh, kind) for kind in ("boundaries", "interfaces", "parts")}
    text = {
        "names": {kind: list(own) for kind, own in named.items()},
        "info": {key: value for key, value in mesh.info.items() if key not in ("quality", "coarse_nodes")},
    }
    rows = {f"{kind}_{j}": ids for kind, own in named.items() for j, ids in enumerate(own.values())}
    rows |= {f"parts_{j}": _runs_of(ids - np.arange(len(ids))) for j, ids in enumerate(mesh.parts.values())}
    own = {"model_points": mesh.points, "hexes": mesh.hexes} if placed else {}
    return {"mesh": np.array(json.dumps(text)), **own, **rows}


def _mesh_of_arrays(own: Mapping[str, Any]) -> HexMesh:
    """The mesh again."""
    factored = _factored_of_arrays(own)
    points, hexes = (own["model_points"], own["hexes"]) if factored is None else factored.placed()[1:]
    return _named(own, points, hexes)


def _named(own: Mapping[str, Any], points: FloatArray, hexes: IntArray) -> HexMesh:
    text = json.loads(str(own["mesh"]))
    named: dict[str, Any] = {
        kind: {name: own[f"{kind}_{j}"] for j, name in enumerate(names)} for kind, names in text["names"].items()
    }
    for kind, every in named.items():
        for name, ids in every.items():
            if ids.ndim == 2 and ids.shape[1] == 2:  # older files have the quads and hexes themselves
                values = _values_of_runs(ids)
                rows = values + np.arange(len(values))
                every[name] = rows if kind == "parts" else own["quads"][rows].astype(np.int64)
    return HexMesh(points=points, hexes=hexes, info=text["info"], **named)


def _rows_in(quads: IntArray, some: IntArray) -> IntArray | None:
    """Where quads stand among all that faces have; None where one of them does not, or is turned otherwise."""
    if not len(quads) or not len(some):
        return None
    keys = row_keys(quads)
    order = np.argsort(keys, kind="stable")
    rows = order[np.minimum(np.searchsorted(keys[order], row_keys(some)), len(order) - 1)]
    return rows if np.array_equal(quads[rows], some) else None


def _runs_of(values: IntArray) -> IntArray:
    """Rows (value, how often it comes) of values in a row: a few rows, where millions of hexes are numbered in turn."""
    starts = np.flatnonzero(np.diff(values, prepend=values[:1] - 1))
    return np.stack([values[starts], np.diff(starts, append=len(values))], axis=1)


def _values_of_runs(runs: IntArray) -> IntArray:
    """The values again."""
    return np.repeat(runs[:, 0], runs[:, 1])


def _factored_of_arrays(own: Mapping[str, Any]) -> FactoredCells | None:
    """The factors of cells, where a file has them."""
    if _SCALE not in own:
        return None
    units = Units(float(own[_SCALE]), own["offset"])
    cells = {name.removeprefix(_FACTORS): array for name, array in own.items() if name.startswith(_FACTORS)}
    return FactoredCells(cells_from_arrays(cells), units)


def _tuples(value: Any) -> Any:
    """Lists of lists as tuples of tuples, as they were before JSON."""
    return tuple(_tuples(one) for one in value) if isinstance(value, list) else value
