"""What child processes do for the page: plain data and arrays in and out.

Every function takes ``on_progress``. A worker keeps the part that it read last, so that selectors and estimates need
not read it again.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import cad
from ..arrays import FloatArray, IntArray
from ..brep import Part
from ..errors import CadSweepError
from ..mesh import HexMesh
from ..progress import Progress
from .entities import Entity, PartData

log = logging.getLogger(__name__)

_kept: dict[Any, Part] = {}
"""The part that was read last, by what it was read from."""
MOST_TANGENT = 0.02
"""Radians off a half turn up to which the faces at an edge are tangent: what an eye takes for smooth."""
_CHORDS = 32
_SEARCH = 5.0
"""Seconds for which cuts are looked for where it is only tried whether there is a mesh."""


def _part(source: Any, params: Mapping[str, Any] | None) -> Part:
    from ..pipeline import load

    if isinstance(source, str):
        found = os.stat(source)
        known: Any = (source, found.st_mtime_ns, found.st_size, repr(params))
    else:
        known = "object"
    if known not in _kept:
        _kept.clear()
        _kept[known] = load(source, params=dict(params) if params else None)
    return _kept[known]


def describe(source: Any, *, params: Mapping[str, Any] | None = None, on_progress: Progress) -> PartData:
    """Read a part, and say what there is to see and to pick."""
    on_progress("reading the part", None)
    part = _part(source, params)
    on_progress("drawing it", None)
    entities: dict[str, Entity] = {}
    chains: dict[str, FloatArray] = {}
    points, normals, triangles, owners = list[FloatArray](), list[FloatArray](), list[IntArray](), list[IntArray]()
    n_points = n_faces = 0
    for j, solid in enumerate(part.solids):
        model = part.models[part.owners[j]]
        entities[f"solid:{j}"] = Entity(
            key=f"solid:{j}",
            name=model.name,
            shape="solid",
            measure=float(solid.volume * part.scale**3),
            place=_place(part, np.mean([face.center for face in solid.faces], axis=0)),
            color=(solid.color or "")[:7],
        )
        for face, (own, corners) in zip(solid.faces, cad.find_facets(solid), strict=True):
            entities[f"face:{j}:{face.id}"] = Entity(
                key=f"face:{j}:{face.id}",
                name=face.name or "",
                shape=face.kind,
                measure=float(face.area * part.scale**2),
                place=_place(part, face.center),
                neighbours=tuple(f"edge:{j}:{edge}" for edge in dict.fromkeys(face.edges)),
                color=(face.color or "")[:7],
            )
            places = part.to_model(own)
            points.append(places)
            normals.append(_normals(places, corners))
            triangles.append(corners + n_points)
            owners.append(np.full(len(corners), n_faces))
            n_points, n_faces = n_points + len(own), n_faces + 1
        for edge in solid.edges:
            key = f"edge:{j}:{edge.id}"
            entities[key] = Entity(
                key=key,
                name=edge.name or "",
                shape=edge.kind,
                measure=float(edge.length * part.scale),
                place=_place(part, edge.midpoint),
                neighbours=tuple(f"face:{j}:{face}" for face in edge.faces),
                tangent=bool(abs(edge.dihedral - np.pi) < MOST_TANGENT),
            )
            at = np.linspace(0.0, 1.0, 2 if edge.kind == "line" else _CHORDS + 1)
            chains[key] = part.to_model(edge.curve.evaluate(at))
    return PartData(
        name=part.name,
        entities=entities,
        points=np.concatenate(points),
        normals=np.concatenate(normals),
        triangles=np.concatenate(triangles),
        owners=np.concatenate(owners),
        chains=chains,
        notes=part.notes,
        volume=float(sum(model.volume for model in part.models) * part.scale**3),
        names=part.names,
    )


def _place(part: Part, point: FloatArray) -> tuple[float, float, float]:
    x, y, z = part.to_model(np.asarray(point, dtype=np.float64)).tolist()
    return x, y, z


def _normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Unit normals (n, 3) at the points of one face's facets: those of the facets around, by area."""
    a, b, c = (points[triangles[:, j]] for j in range(3))
    of_facets = np.cross(b - a, c - a)
    found = np.zeros_like(points)
    for j in range(3):
        np.add.at(found, triangles[:, j], of_facets)
    lengths = np.linalg.norm(found, axis=1, keepdims=True)
    return np.divide(found, lengths, out=found, where=lengths > 0)


def select(
    source: Any, words: str, *, kind: str, params: Mapping[str, Any] | None = None, on_progress: Progress
) -> list[str]:
    """Keys of what a selector, a name or an id chooses, in all solids that have such."""
    from dataclasses import replace

    from ..errors import InputError

    part = _part(source, params)
    choose = cad.select_edges if kind == "edge" or words.startswith("edges:") else cad.select_faces
    what = "edge" if choose is cad.select_edges else "face"
    found, missing = [], InputError("the part has no solids")
    for j, solid in enumerate(part.solids):
        one = replace(part, solids=(solid,), owners=(0,), models=(part.models[part.owners[j]],))
        try:
            found += [f"{what}:{j}:{chosen}" for chosen in choose(one, words)]
        except InputError as error:
            missing = error
    if not found:
        raise missing
    return found


def make_mesh(
    source: Any, options: Mapping[str, Any], *, on_progress: Progress
) -> tuple[HexMesh, dict[str, FloatArray]]:
    """Mesh the part, and measure how far the quads of its boundaries are from the CAD."""
    from ..pipeline import sweep_mesh
    from .distances import find_distances

    mesh = sweep_mesh(source, on_progress=on_progress, **options)
    on_progress("distances", None)
    return mesh, find_distances(mesh, _part(source, options.get("params")))


def write_mesh(mesh: HexMesh, path: str, *, command: str, on_progress: Progress) -> None:
    """Write a mesh in the format of a suffix, or the report about it."""
    on_progress("writing", None)
    if Path(path).suffix == ".html":
        from ..report import write_report

        write_report(mesh, path, command=command)
        return
    from ..io import write

    write(mesh, path, on_progress=on_progress)


def try_out(source: Any, options: Sequence[Mapping[str, Any]], *, on_progress: Progress) -> None:
    """Mesh the part with each of some options; says of each by its number whether it has a mesh."""
    from ..pipeline import sweep_mesh

    for j, own in enumerate(options):
        part = _part(source, own.get("params"))
        asked = {**own, "params": None, "decompose_time": _SEARCH}
        try:
            sweep_mesh(part, **asked)
        except CadSweepError as error:
            log.info("%s does not help: %s", own, error)
            on_progress(f"no {j}", None)
        else:
            on_progress(f"yes {j}", None)


def estimate(source: Any, options: Mapping[str, Any], *, on_progress: Progress) -> str:
    """What the mesh is expected to be, in a line."""
    from ..pipeline.expecting import expect

    on_progress("estimate", None)
    return str(expect(_part(source, options.get("params")), **{**options, "params": None}))
