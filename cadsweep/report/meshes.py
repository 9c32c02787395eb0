"""The page about a mesh.

Place in the flow: after ``quality``; called by ``cadsweep report``.

Method: Python writes the data (quads, edges, colours) as typed arrays; the page switches between what is drawn already:
the outside by quality or by boundary, and cuts that lay the hexahedra of one half open.

Not handled: meshes whose outside has more quads than a browser turns at ease are drawn without cuts and
edges, and the page says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..cells import HEX_EDGES
from ..mesh import HexMesh
from ..quality import QualityReport
from ..quality.convergence import ConvergenceIndex, convergence_rows
from ..view import explode, kept_by_clip, mesh_colors, part_colors, skin
from .cards import figures, histogram, quality_of, verdict
from .page import listed, make_layout, table, write_page
from .traces import faces, lines, unique_edges

MOST_QUADS = 150_000
"""Quads of the outside above which cuts and edges are left out."""
MOST_BLOCKS = 60
"""Columns or cells that are drawn apart: of more nobody sees which is which."""


def write_report(
    mesh: HexMesh,
    path: str | PathLike[str],
    *,
    command: str | None = None,
    family: tuple[Sequence[HexMesh], Mapping[str, ConvergenceIndex]] | None = None,
) -> Path:
    """Write a page about a mesh that any browser opens, without a network.

    Parameters
    ----------
    mesh : HexMesh
    path : path
        Suffix ``.html``.
    command : str, optional
        What made the mesh; shown on the page.
    family : pair, optional
        Nested meshes, the coarsest first, and the convergence of their figures by name, of which a table is shown.

    Returns
    -------
    Path
        Where the page was written: whole, or not at all.

    Raises
    ------
    CadSweepError
        The extra ``view`` is not installed, or the page cannot be written.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> from cadsweep.report import write_report
    >>> write_report(cs.sweep_mesh(box, size=1.0), "box.html").name
    'box.html'
    """
    report = quality_of(mesh)
    scene, remark = _scene(mesh, report)
    title = str(mesh.info.get("part") or next(iter(mesh.parts), "mesh"))
    made = f"<p>Made by <code>{escape(command)}</code>, cadsweep {__version__}.</p>" if command else ""
    seconds = mesh.info.get("seconds", {})
    timings = [(escape(stage), f"{value:.2f} s") for stage, value in seconds.items()]
    sections = [
        f"<h1>{escape(title)}</h1>{verdict(report)}{made}",
        f'<div class="bar" id="bar"></div><div id="view"></div><p>{escape(remark)}</p>',
        f'<div class="columns"><div><h2>Mesh</h2>{table(figures(report) + _distance(mesh) + _material(mesh))}</div>',
        f"<div><h2>Scaled Jacobian</h2>{histogram(report)}</div></div>",
        f'<div class="columns"><div><h2>Sweep</h2>{_sweeps(mesh)}</div>',
        f"<div><h2>Boundaries</h2>{_boundaries(mesh)}</div><div>{_parts(mesh)}</div>",
        f"<div><h2>Time</h2>{table([*timings, ('total', f'{sum(seconds.values()):.2f} s')])}</div></div>",
        f"<h2>Worst hexahedra</h2>{_worst(report)}",
        _family(*family) if family else "",
        listed("Problems", report.problems) + listed("Notes", mesh.info.get("notes", [])),
    ]
    return write_page(Path(path), title, sections, scene)


def _distance(mesh: HexMesh) -> list[tuple[str, str]]:
    distance = mesh.info.get("distance")
    return [] if distance is None else [("greatest distance from the CAD faces", f"{distance:.3g}")]


def _material(mesh: HexMesh) -> list[tuple[str, str]]:
    material = mesh.info.get("material")
    if not material:
        return []
    meant = mesh.info.get("names", {}).get(material, material)
    return [("material", escape(material if meant == material else f"{material} (named {meant})"))]


def _family(meshes: Sequence[HexMesh], convergence: Mapping[str, ConvergenceIndex]) -> str:
    """Volume and areas on nested meshes: values, observed order, extrapolated value, grid convergence index."""
    head, *rows = convergence_rows(convergence)
    counts = "".join(f'<td class="n">{mesh.n_hexes:,}</td>' for mesh in meshes)
    body = ""
    for name, *texts in rows:
        cells = "".join(f'<td class="n">{text}</td>' for text in texts)
        body += f"<tr><td>{escape(name)}</td>{cells}</tr>"
    titles = "".join(f'<th class="n">{word}</th>' for word in head[1:])
    return (
        f"<h2>Grid convergence</h2><table><tr><th></th>{titles}</tr><tr><td>hexahedra</td>{counts}</tr>{body}</table>"
    )


def _sweeps(mesh: HexMesh) -> str:
    """The sweeps recognised; faces that have no name are shown by number."""
    rows = []
    for sweep in mesh.info.get("sweeps", []):
        for key, value in sweep.items():
            text = str(value)
            if key in ("source", "target"):
                text = ", ".join(f"face {f}" if isinstance(f, int) else str(f) for f in value)
            elif isinstance(value, list):
                text = " + ".join(map(str, value))
            rows.append((escape(str(key).replace("_", " ")), escape(text)))
    return table(rows)


def _boundaries(mesh: HexMesh) -> str:
    """Names with the colours of the view, what the user called them, and their size."""
    originals = mesh.info.get("names", {})
    rows = []
    for (name, quads), color in zip(mesh.boundaries.items(), mesh_colors(mesh), strict=True):
        meant = originals.get(name, name)
        swatch = f'<span class="swatch" style="background: {color}"></span> '
        label = escape(name) + (f" (named {escape(meant)})" if meant != name else "")
        rows.append((swatch + label, f"{len(quads):,} quads"))
    return table(rows)


def _parts(mesh: HexMesh) -> str:
    """Solids of an assembly with their colours and materials, and what they touch in; nothing of a single one."""
    if len(mesh.parts) < 2:
        return ""
    materials = mesh.info.get("materials") or {}
    rows = []
    for (name, ids), color in zip(mesh.parts.items(), part_colors(mesh), strict=True):
        swatch = f'<span class="swatch" style="background: {color}"></span> '
        made_of = f", {escape(materials[name])}" if name in materials else ""
        rows.append((swatch + escape(name), f"{len(ids):,} hexahedra{made_of}"))
    found = f"<h2>Parts</h2>{table(rows)}"
    if mesh.interfaces:
        rows = [(escape(name), f"{len(quads):,} quads") for name, quads in mesh.interfaces.items()]
        found += f"<h2>Interfaces</h2>{table(rows)}"
    return found


def _blocks_apart(mesh: HexMesh) -> dict[str, HexMesh]:
    """Columns or cells of a mesh drawn apart, by the name of the view, where there are several and not too many."""
    sizes = list(mesh.info.get("blocks") or ())
    if not max(1, len(mesh.parts)) < len(sizes) <= MOST_BLOCKS or sum(sizes) != mesh.n_hexes:
        return {}
    word = "column" if any("columns" in sweep for sweep in mesh.info.get("sweeps", ())) else "cell"
    ids = np.split(np.arange(mesh.n_hexes), np.cumsum(sizes)[:-1])
    parts = {f"{word} {number}": own for number, own in enumerate(ids, start=1)}
    return {f"{word}s apart": explode(replace(mesh, parts=parts, interfaces={}, info={}), 1.0)}


def _part_views(shapes: Mapping[str, HexMesh], traces: list[dict[str, Any]], views: dict[str, list[int]]) -> None:
    """The parts of meshes in their colours, by the name of the view: in their places or drawn apart."""
    for view, shown in shapes.items():
        surface, _ = skin(shown)
        quads, points = surface.regular_faces, np.asarray(surface.points)
        of = np.full(shown.n_hexes, -1, dtype=np.int64)
        for j, ids in enumerate(shown.parts.values()):
            of[ids] = j
        of_quad = of[surface.cell_data["hex"]]
        views[view] = []
        for j, (name, color) in enumerate(zip(shown.parts, part_colors(shown), strict=True)):
            if (of_quad == j).any():  # a part all around which are others has no outside
                views[view].append(len(traces))
                traces.append(faces(points, quads[of_quad == j], color=color, name=name))
        if len(quads) <= MOST_QUADS:
            views[view].append(len(traces))
            traces.append(lines(points, unique_edges(quads), color="#303030", width=1))


def _worst(report: QualityReport) -> str:
    head = '<tr><th class="n">hexahedron</th><th class="n">layer</th><th>centre</th>'
    head += '<th class="n">scaled Jacobian</th><th class="n">volume</th></tr>'
    rows = "".join(
        f'<tr><td class="n">{h.id}</td><td class="n">{"" if h.layer is None else h.layer}</td>'
        f"<td>{', '.join(f'{c:.5g}' for c in h.center)}</td>"
        f'<td class="n">{h.scaled_jacobian:.4f}</td><td class="n">{h.volume:.4g}</td></tr>'
        for h in report.worst
    )
    return f"<table>{head}{rows}</table>"


def _scene(mesh: HexMesh, report: QualityReport) -> tuple[dict[str, Any], str]:
    """Traces, the views that show some of them, and a remark for the reader."""
    surface, owners = skin(mesh)
    quads, quality = surface.regular_faces, surface.cell_data["scaled_jacobian"]
    points = np.asarray(surface.points)
    small = len(quads) <= MOST_QUADS
    traces = [faces(points, quads, intensity=quality)]
    views: dict[str, list[int]] = {"quality": [0]}
    always = []
    if small:
        traces.append(lines(points, unique_edges(quads), color="#303030", width=1))
        views["quality"].append(1)
    if report.worst:
        worst = mesh.hexes[[h.id for h in report.worst], :8]
        edges = worst[:, HEX_EDGES].reshape(-1, 2)
        always = [len(traces)]
        traces.append(lines(mesh.points, edges, color="#e0241b", width=5, name="worst hexahedra"))
        views["quality"] += always
    if mesh.boundaries:
        views["boundaries"] = [*views["quality"][1:], *range(len(traces), len(traces) + len(mesh.boundaries))]
        for i, (name, color) in enumerate(zip(mesh.boundaries, mesh_colors(mesh), strict=True)):
            traces.append(faces(points, quads[owners == i], color=color, name=name))
    if len(mesh.parts) > 1:
        _part_views({"parts": mesh, "parts apart": explode(mesh, 1.0)}, traces, views)
    if small:
        _part_views(_blocks_apart(mesh), traces, views)
    for axis in "xyz" if small else "":
        kept = kept_by_clip(mesh, axis)
        if not kept.any():
            continue
        half, _ = skin(mesh, kept)
        cut_points = np.asarray(half.points)
        views[f"cut across {axis}"] = [len(traces), len(traces) + 1, *always]
        traces.append(faces(cut_points, half.regular_faces, intensity=half.cell_data["scaled_jacobian"]))
        traces.append(lines(cut_points, unique_edges(half.regular_faces), color="#303030", width=1))
    for i in views["quality"]:
        traces[i]["visible"] = True
    remark = "Drag to turn, scroll to zoom, click a name in the legend to hide it."
    if not small:
        remark += f" The outside has {len(quads):,} quads: edges and cuts are left out."
    return {"traces": traces, "views": views, "layout": make_layout(points)}, remark
