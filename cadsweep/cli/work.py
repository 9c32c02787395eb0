"""What the worker process of a command does: plain data in, plain data out.

Every function takes ``on_progress``. Nothing here prints.
"""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..brep import Part
from ..errors import CadSweepError, NotSweepableError
from ..mesh import HexMesh
from ..progress import Progress

if TYPE_CHECKING:
    from ..pipeline.finished.family import Family


def mesh_file(
    source: str,
    output: str | None,
    *,
    options: dict[str, Any],
    writing: dict[str, Any] | None = None,
    stream: bool = False,
    nodes: str | None = None,
    family: int | None = None,
    on_progress: Progress,
) -> dict[str, Any]:
    """Mesh a part into a file (None: into none), and return the figures of ``cadsweep mesh --json``.

    With `family` it is the coarsest of that many nested meshes, whose files are numbered. `nodes` is a numpy file for
    the points alone: the corners of the hexes as they were before they were refined.
    """
    from ..io import check_destination, write
    from ..pipeline import sweep_mesh

    if output is not None:
        output = os.path.abspath(output)  # a script may change the working folder
        if output.endswith(".sweep.npz"):
            from ..io.atomic import check_place
            from ..pipeline import write_factors

            check_place(Path(output))
            return summarise(write_factors(source, output, on_progress=on_progress, **options))
        check_destination(output)
    if stream and output is not None:
        from ..pipeline import stream_mesh

        return plain(stream_mesh(source, output, on_progress=on_progress, **options))
    mesh = sweep_mesh(source, on_progress=on_progress, **options)
    if output is not None:
        on_progress("write", None)
        start = time.perf_counter()
        write(mesh, output, on_progress=on_progress, **(writing or {}))
        seconds = {**mesh.info.get("seconds", {}), "write": time.perf_counter() - start}
        mesh = replace(mesh, info={**mesh.info, "seconds": seconds})
    if nodes is not None:
        from ..io.atomic import replaced_file

        with replaced_file(Path(nodes)) as file:
            np.save(file, mesh.points[mesh.info.get("coarse_nodes", np.unique(mesh.hexes[:, :8]))])
    if family:
        return {**summarise(mesh), **_write_family(mesh, output, family, writing or {}, on_progress)}
    return summarise(mesh)


def family_path(output: str, level: int) -> str:
    """The file of a mesh that is refined `level` times: ``elbow.vtu``, ``elbow_1.vtu``, ``elbow_2.vtu``."""
    path = Path(output)
    return str(path.with_name(f"{path.stem}_{level}{path.suffix}")) if level else output


def _write_family(
    mesh: HexMesh, output: str | None, n_meshes: int, writing: dict[str, Any], on_progress: Progress
) -> dict[str, Any]:
    from ..io import write
    from ..pipeline import make_family

    on_progress("refine", None)
    made = make_family(mesh, n_meshes)
    rows = []
    for level, one in enumerate(made.meshes):
        if level and output is not None:
            on_progress("write", None)
            write(one, family_path(output, level), on_progress=on_progress, **writing)
        figures = summarise(one)
        keys = ("n_nodes", "n_hexes", "min_scaled_jacobian", "mean_scaled_jacobian", "volume")
        rows.append({"file": output and family_path(output, level), **{key: figures[key] for key in keys}})
    return {"family": plain(rows), **_convergence(made)}


def _convergence(family: Family) -> dict[str, Any]:
    from dataclasses import asdict

    found = {name: asdict(one) for name, one in family.convergence.items()}
    return plain({"convergence": found, "convergence_lines": str(family).splitlines()})


def expand_file(
    factors: str, output: str, *, writing: dict[str, Any] | None = None, on_progress: Progress
) -> dict[str, Any]:
    """Multiply a file of factors out to a mesh file."""
    from ..io import check_destination, write
    from ..pipeline import expand

    check_destination(output)
    on_progress("expand", None)
    mesh = expand(factors)
    on_progress("write", 0.0)
    write(mesh, output, on_progress=on_progress, **(writing or {}))
    return summarise(mesh)


def summarise(mesh: HexMesh) -> dict[str, Any]:
    """The figures that every mesh is announced with."""
    report = mesh.info.get("quality") or mesh.quality()
    return plain(
        {
            "way": mesh.info.get("way"),
            "n_nodes": mesh.n_nodes,
            "n_hexes": mesh.n_hexes,
            "min_scaled_jacobian": report.min_scaled_jacobian,
            "mean_scaled_jacobian": report.mean_scaled_jacobian,
            "n_inverted": report.n_inverted,
            "jacobian_ratio": report.jacobian_ratio,
            "jacobian_bound": report.jacobian_bound,
            "valid": report.valid,
            "boundaries": {name: len(quads) for name, quads in mesh.boundaries.items()},
            "interfaces": {name: len(quads) for name, quads in mesh.interfaces.items()},
            "parts": {name: len(hexes) for name, hexes in mesh.parts.items()},
            "volume": report.volume,
            "cad_volume": mesh.info.get("cad_volume"),
            "distance": mesh.info.get("distance"),
            "curved_distance": mesh.info.get("curved_distance"),
            "seconds": mesh.info.get("seconds", {}),
            "sweeps": mesh.info.get("sweeps", []),
            "material": mesh.info.get("material"),
            "rows": mesh.info.get("rows", ()),
            "notes": mesh.info.get("notes", []),
        }
    )


def _in_model_units(part: Part, tables: dict[str, list[dict[str, Any]]]) -> None:
    for edge in tables["edges"]:
        edge["length"] *= part.scale
        edge["middle"] = part.to_model(np.asarray(edge["middle"]))
    for face in tables["faces"]:
        face["area"] *= part.scale**2
        face["center"] = part.to_model(np.asarray(face["center"]))
    for sweep in tables["sweeps"]:
        sweep["length"] *= part.scale


def describe_part(
    source: str,
    *,
    params: dict[str, Any] | None,
    part: str | None = None,
    touch: float | None = None,
    cut_overlaps: bool = False,
    only: Sequence[str] | None = None,
    skip: Sequence[str] | None = None,
    suppress: Sequence[str] = (),
    caps: tuple[Any, Any] = (None, None),
    on_progress: Progress,
) -> dict[str, Any]:
    """Faces, edges, sweeps and reasons of a part, as ``cadsweep info --json`` prints them; `caps`: source, target."""
    from ..blends import find_blends
    from ..cad import find_contacts
    from ..pipeline import load
    from ..pipeline.attempts import open_and_find
    from ..pipeline.columns.stacking import describe_stacks
    from ..pipeline.complexes.planning import describe_plan
    from ..pipeline.directions import other_directions
    from ..pipeline.parts import resolve_cap
    from ..pipeline.run import Run
    from ..recognition import describe, describe_edges, find_sweeps

    on_progress("cad", None)
    loaded = load(
        source,
        params=params,
        part=part,
        only=only,
        skip=skip,
        touch=touch,
        cut_overlaps=cut_overlaps,
        on_progress=lambda share: on_progress("cad", share),
    )
    loaded = _without(loaded, suppress)
    on_progress("recognition", None)
    as_loaded = loaded
    if len(loaded.solids) == 1:
        # A full ring is cut open, needless divisions are undone; a refusal is said below, face by face.
        with contextlib.suppress(NotSweepableError):
            loaded, _ = open_and_find(loaded, *caps)
    chosen = [resolve_cap(loaded, cap) for cap in caps]
    data: dict[str, Any] = {"name": loaded.name, "notes": loaded.notes, "names": loaded.names, "solids": []}
    data.update(faces=[], edges=[], blends=[], sweeps=[], rejected=[], stacks=[], no_stacks=[])
    for index, solid in enumerate(loaded.solids):
        found: Any
        try:
            found, error = find_sweeps(solid, source=chosen[0], target=chosen[1]), None
        except NotSweepableError as refusal:
            found, error = refusal, refusal.message
        tables = describe(solid, found)
        if error is None and caps == (None, None):
            for other in other_directions(loaded, found):
                tables["sweeps"] += describe(other.solid, [other])["sweeps"]
        tables["edges"] = describe_edges(solid, None if error is not None else found[0])
        tables["blends"] = [blend.described(solid) for blend in find_blends(solid)]
        _in_model_units(loaded, tables)
        for name, rows in tables.items():
            data[name] += [{"solid": index, **row} for row in rows]
        volume = solid.volume * loaded.scale**3
        known = {"name": solid.name or loaded.name, "material": solid.material, "color": solid.color}
        data["solids"].append({**known, "volume": volume, "error": error})
        alone = as_loaded if len(loaded.solids) == 1 else _one_of(loaded, index)
        if caps == (None, None) and (error is not None or len(loaded.solids) == 1):
            rows, reasons = describe_stacks(alone, found if error is None else ())
            data["stacks"] += [{"solid": index, **row} for row in rows]
            data["no_stacks"] += [{"solid": index, "reason": reason} for reason in reasons]
    data["contacts"] = [
        {
            "solids": [loaded.models[j].name for j in contact.models],
            "kind": contact.kind,
            "area": contact.area * loaded.scale**2,
            "faces": [[face for _, face in sides] for sides in contact.faces],
        }
        for contact in find_contacts(loaded)
    ]
    data["plan"] = None
    if len(loaded.solids) > 1:
        on_progress("plan", None)
        data["plan"] = describe_plan(loaded, Run(on_progress=on_progress))
    return plain(data)


def _without(part: Part, features: Sequence[str]) -> Part:
    """The part without the features that the user does not want."""
    from .. import cad

    return cad.suppress(part, features) if features else part


def _one_of(part: Part, index: int) -> Part:
    """One solid of a part by itself, with the outlines of its neighbours on it."""
    return replace(part, solids=(part.solids[index],), owners=(0,), models=(part.models[part.owners[index]],))


def cut_file(
    source: str,
    output: str,
    *,
    cuts: list[str],
    params: dict[str, Any] | None,
    part: str | None,
    touch: float | None,
    suppress: Sequence[str] = (),
    on_progress: Progress,
) -> dict[str, Any]:
    """Cut a part into cells that sweep, and write them as solids; returns the cells and the cuts."""
    from ..cad import write_step
    from ..io.atomic import check_place
    from ..pipeline import decompose, load

    output = os.path.abspath(output)  # a script may change the working folder
    check_place(Path(output))
    on_progress("cad", None)
    loaded = _without(load(source, params=params, part=part, touch=touch), suppress)
    on_progress("decomposition", None)
    cells = decompose(loaded, cuts=cuts)
    on_progress("write", None)
    names = write_step(cells, Path(output))
    return plain(
        {
            "cells": [
                {
                    "name": name,
                    "part": cells.models[owner].name,
                    "volume": solid.volume * cells.scale**3,
                    "n_faces": len(solid.faces),
                }
                for name, owner, solid in zip(names, cells.owners, cells.solids, strict=True)
            ],
            "cuts": [{"kind": cut.kind, "reason": cut.reason, "place": cut.place} for cut in cells.cuts],
            "notes": cells.notes,
        }
    )


def check_file(path: str, *, on_progress: Progress) -> dict[str, Any]:
    """Every figure of a mesh file, and the report's text."""
    from ..io import read

    on_progress("read", None)
    mesh = read(path)
    on_progress("quality", None)
    report = mesh.quality()
    return {**plain(report.to_dict()), "valid": bool(report.valid), "text": str(report)}


def view_file(path: str, *, screenshot: str | None, options: dict[str, Any], on_progress: Progress) -> None:
    """Show a mesh file in a window, or write a picture of it."""
    from ..io import read

    on_progress("read", None)
    mesh = read(path)
    on_progress("view", None)
    mesh.plot(screenshot=screenshot, **options)


def report_file(
    source: str, output: str, *, options: dict[str, Any], command: str, family: int | None = None, on_progress: Progress
) -> dict[str, Any]:
    """Mesh a part, write the page about it, and about `family` nested meshes, and return the figures of the mesh."""
    from ..io.atomic import check_place
    from ..pipeline import make_family, sweep_mesh
    from ..report import write_report

    output = os.path.abspath(output)  # a script may change the working folder
    check_place(Path(output))
    try:
        mesh = sweep_mesh(source, on_progress=on_progress, **options)
    except CadSweepError as refusal:
        _write_refusal(refusal, source, output, options, command)
        raise
    nested, told = None, {}
    if family:
        on_progress("refine", None)
        made = make_family(mesh, family)
        nested, told = (made.meshes, made.convergence), _convergence(made)
    on_progress("report", None)
    write_report(mesh, output, command=command, family=nested)
    return {**summarise(mesh), **told}


def _write_refusal(refusal: CadSweepError, source: str, output: str, options: dict[str, Any], command: str) -> None:
    """Write the page about the part that is refused, and add to the refusal where it is."""
    from ..pipeline import load
    from ..report import write_refusal
    from .failure import describe_failure

    try:
        part = load(
            source, **{name: options[name] for name in ("params", "part", "touch", "cut_overlaps") if name in options}
        )
    except CadSweepError:
        return  # it is the model that cannot be read: there is nothing to show
    told = describe_failure(refusal)
    write_refusal(
        part,
        output,
        reason=told["what"],
        faces_in_question=told["faces"],
        where=told["where"],
        hint=told["hint"] if refusal.try_ else "",
        reasons=told["reasons"],
        command=command,
        left=getattr(refusal, "left", ()),
    )
    refusal.args = (f"{refusal.what}; {Path(output).name} shows the faces in question",)


def plain(value: Any) -> Any:
    """A value that JSON knows: arrays become lists, numpy numbers Python's, what is not finite ``None``."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
