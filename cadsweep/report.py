"""What is known of a mesh, as one page: a summary for notebooks, and an interactive report.

Place in the flow: after ``quality``; called by ``cadsweep report`` and by notebooks.

Method: the page holds everything it needs, the drawing library plotly.js included, and loads nothing from
the network. Python writes the data (quads, edges, colours) as typed arrays; the page switches between what
is drawn already: the outside by quality or by boundary, and cuts that lay the hexahedra of one half open.

Not handled: meshes whose outside has more quads than a browser turns at ease are drawn without cuts and
edges, and the page says so.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ._version import __version__
from .arrays import FloatArray, IntArray
from .cells import HEX_EDGES
from .errors import CadSweepError
from .mesh import HexMesh
from .quality import QualityReport
from .quality.convergence import ConvergenceIndex, convergence_rows
from .view import explode, kept_by_clip, mesh_colors, part_colors, skin, write_whole

MOST_QUADS = 150_000
"""Quads of the outside above which cuts and edges are left out."""

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; color: #1d2733 }
h1 { font-size: 1.5rem; margin: 0 } h2 { font-size: 1.1rem; margin: 1.6rem 0 .4rem }
table { border-collapse: collapse } td, th { padding: .15rem .8rem .15rem 0; text-align: left; vertical-align: top }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums }
#view { height: 36rem; border: 1px solid #ccd3db; border-radius: 6px }
.bar button { font: inherit; padding: .3rem .8rem; margin: 0 .4rem .5rem 0; border: 1px solid #9aa6b2;
  border-radius: 5px; background: #fff; cursor: pointer } .bar button.on { background: #1f5fa8; color: #fff }
.valid { color: #1b7a3d } .invalid { color: #b3261e } code { background: #eef1f4; padding: .1rem .35rem }
.swatch { display: inline-block; width: .8em; height: .8em; border: 1px solid #9aa6b2 }
.columns { display: flex; flex-wrap: wrap; gap: 0 4rem }
"""
_SCRIPT = """
const scene = JSON.parse(document.getElementById("scene").textContent);
const view = document.getElementById("view");
const bar = document.getElementById("bar");
function show(name) {
  for (const b of bar.children) b.classList.toggle("on", b.textContent === name);
  return Plotly.restyle(view, {visible: scene.traces.map((t, i) => scene.views[name].includes(i))});
}
for (const name of Object.keys(scene.views)) {
  const button = document.createElement("button");
  button.textContent = name;
  button.onclick = () => show(name);
  bar.append(button);
}
const buttons = [["toImage", "orbitRotation", "tableRotation", "resetCameraDefault3d"]];
bar.firstChild.classList.add("on");
Plotly.newPlot(view, scene.traces, scene.layout, {responsive: true, modeBarButtons: buttons, displaylogo: false})
  .then(() => { document.body.dataset.drawn = "yes"; });
"""


def mesh_summary_html(mesh: HexMesh) -> str:
    """Return a summary of a mesh as an HTML fragment, for notebooks.

    Runs the checks unless the mesh carries their report already.
    """
    report = _quality(mesh)
    boundaries = ", ".join(f"{escape(name)} ({len(quads):,})" for name, quads in mesh.boundaries.items())
    rows = [*_figures(report), ("boundaries (quads)", boundaries or "none")]
    return f"<div>{_verdict(report)}{_table(rows)}{_histogram(report)}</div>"


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
    library = _plotly_js()
    report = _quality(mesh)
    scene, remark = _scene(mesh, report)
    name = escape(str(mesh.info.get("part") or next(iter(mesh.parts), "mesh")))
    made = f"<p>Made by <code>{escape(command)}</code>, cadsweep {__version__}.</p>" if command else ""
    seconds = mesh.info.get("seconds", {})
    timings = [(escape(stage), f"{value:.2f} s") for stage, value in seconds.items()]
    sections = [
        f"<h1>{name}</h1>{_verdict(report)}{made}",
        f'<div class="bar" id="bar"></div><div id="view"></div><p>{escape(remark)}</p>',
        f'<div class="columns"><div><h2>Mesh</h2>{_table(_figures(report) + _distance(mesh) + _material(mesh))}</div>',
        f"<div><h2>Scaled Jacobian</h2>{_histogram(report)}</div></div>",
        f'<div class="columns"><div><h2>Sweep</h2>{_sweeps(mesh)}</div>',
        f"<div><h2>Boundaries</h2>{_boundaries(mesh)}</div><div>{_parts(mesh)}</div>",
        f"<div><h2>Time</h2>{_table([*timings, ('total', f'{sum(seconds.values()):.2f} s')])}</div></div>",
        f"<h2>Worst hexahedra</h2>{_worst(report)}",
        _family(*family) if family else "",
        _list("Problems", report.problems) + _list("Notes", mesh.info.get("notes", [])),
    ]
    page = "\n".join(
        [
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{name}</title>',
            f'<link rel="icon" href="data:,"><style>{_STYLE}</style></head><body>',
            *sections,
            f'<script type="application/json" id="scene">{_embedded(scene)}</script>',
            f"<script>{library}</script><script>{_SCRIPT}</script></body></html>",
        ]
    )
    return write_whole(Path(path), page.encode())


def _plotly_js() -> str:
    """The drawing library, from the package that brings it."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise CadSweepError(f'reports need the extra "view": pip install "cadsweep[view]" ({error})') from error
    return str(get_plotlyjs())


def _quality(mesh: HexMesh) -> QualityReport:
    report = mesh.info.get("quality")
    return report if isinstance(report, QualityReport) else mesh.quality()


def _embedded(data: Any) -> str:
    """JSON that cannot end the element it stands in."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _verdict(report: QualityReport) -> str:
    if report.valid:
        return '<p class="valid">Valid: every check passed.</p>'
    return f'<p class="invalid">Not valid: {escape("; ".join(report.problems))}</p>'


def _figures(report: QualityReport) -> list[tuple[str, str]]:
    return [
        ("nodes", f"{report.n_nodes:,}"),
        ("hexahedra", f"{report.n_hexes:,} of order {report.order}"),
        ("inverted", f"{report.n_inverted:,}"),
        ("worst scaled Jacobian", f"{report.min_scaled_jacobian:.4f}"),
        ("mean scaled Jacobian", f"{report.mean_scaled_jacobian:.4f}"),
        ("volume", f"{report.volume:.8g}"),
    ]


def _distance(mesh: HexMesh) -> list[tuple[str, str]]:
    distance = mesh.info.get("distance")
    return [] if distance is None else [("greatest distance from the CAD faces", f"{distance:.3g}")]


def _material(mesh: HexMesh) -> list[tuple[str, str]]:
    material = mesh.info.get("material")
    if not material:
        return []
    meant = mesh.info.get("names", {}).get(material, material)
    return [("material", escape(material if meant == material else f"{material} (named {meant})"))]


def _table(rows: list[tuple[str, str]]) -> str:
    """Rows whose cells are HTML already."""
    body = "".join(f'<tr><td>{key}</td><td class="n">{value}</td></tr>' for key, value in rows)
    return f"<table>{body}</table>"


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


def _list(title: str, items: Any) -> str:
    rows = "".join(f"<li>{escape(str(item))}</li>" for item in items)
    return f"<h2>{title}</h2><ul>{rows}</ul>" if rows else ""


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
    return _table(rows)


def _boundaries(mesh: HexMesh) -> str:
    """Names with the colours of the view, what the user called them, and their size."""
    originals = mesh.info.get("names", {})
    rows = []
    for (name, quads), color in zip(mesh.boundaries.items(), mesh_colors(mesh), strict=True):
        meant = originals.get(name, name)
        swatch = f'<span class="swatch" style="background: {color}"></span> '
        label = escape(name) + (f" (named {escape(meant)})" if meant != name else "")
        rows.append((swatch + label, f"{len(quads):,} quads"))
    return _table(rows)


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
    found = f"<h2>Parts</h2>{_table(rows)}"
    if mesh.interfaces:
        rows = [(escape(name), f"{len(quads):,} quads") for name, quads in mesh.interfaces.items()]
        found += f"<h2>Interfaces</h2>{_table(rows)}"
    return found


def _part_views(mesh: HexMesh, traces: list[dict[str, Any]], views: dict[str, list[int]]) -> None:
    """The parts in their colours, in their places and drawn apart."""
    for view, shown in (("parts", mesh), ("parts apart", explode(mesh, 1.0))):
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
                traces.append(_faces(points, quads[of_quad == j], color=color, name=name))
        if len(quads) <= MOST_QUADS:
            views[view].append(len(traces))
            traces.append(_lines(points, _unique_edges(quads), color="#303030", width=1))


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


def _histogram(report: QualityReport) -> str:
    """Bars of the scaled Jacobian as SVG; red below zero."""
    edges, counts = report.histogram
    most = max(int(np.max(counts)), 1)
    bars = ""
    for i, count in enumerate(counts.tolist()):
        height = 120 * count / most if count else 0
        color = "#b3261e" if edges[i] < 0 else "#1f5fa8"
        label = f"<title>{edges[i]:.2f} to {edges[i + 1]:.2f}: {count:,}</title>"
        bars += f'<rect x="{18 * i + 8}" y="{130 - height:.1f}" width="16" height="{height:.1f}" fill="{color}">'
        bars += f"{label}</rect>"
    ticks = "".join(
        f'<text x="{18 * i + 8}" y="146" font-size="11" text-anchor="middle">{edges[i]:.2g}</text>'
        for i in range(0, len(edges), 5)
    )
    width = 18 * len(counts) + 24
    return f'<svg width="{width}" height="150" viewBox="0 0 {width} 150" role="img">{bars}{ticks}</svg>'


def _array(values: FloatArray | IntArray) -> dict[str, str]:
    """A typed array the way plotly.js reads it: element type, and base64 of the bytes."""
    is_real = np.issubdtype(values.dtype, np.floating)
    data = np.ascontiguousarray(values, dtype="<f4" if is_real else "<i4")
    return {"dtype": "f4" if is_real else "i4", "bdata": base64.b64encode(data.tobytes()).decode()}


def _scene(mesh: HexMesh, report: QualityReport) -> tuple[dict[str, Any], str]:
    """Traces, the views that show some of them, and a remark for the reader."""
    surface, owners = skin(mesh)
    quads, quality = surface.regular_faces, surface.cell_data["scaled_jacobian"]
    points = np.asarray(surface.points)
    small = len(quads) <= MOST_QUADS
    traces = [_faces(points, quads, intensity=quality)]
    views: dict[str, list[int]] = {"quality": [0]}
    always = []
    if small:
        traces.append(_lines(points, _unique_edges(quads), color="#303030", width=1))
        views["quality"].append(1)
    if report.worst:
        worst = mesh.hexes[[h.id for h in report.worst], :8]
        edges = worst[:, HEX_EDGES].reshape(-1, 2)
        always = [len(traces)]
        traces.append(_lines(mesh.points, edges, color="#e0241b", width=5, name="worst hexahedra"))
        views["quality"] += always
    if mesh.boundaries:
        views["boundaries"] = [*views["quality"][1:], *range(len(traces), len(traces) + len(mesh.boundaries))]
        for i, (name, color) in enumerate(zip(mesh.boundaries, mesh_colors(mesh), strict=True)):
            traces.append(_faces(points, quads[owners == i], color=color, name=name))
    if len(mesh.parts) > 1:
        _part_views(mesh, traces, views)
    for axis in "xyz" if small else "":
        kept = kept_by_clip(mesh, axis)
        if not kept.any():
            continue
        half, _ = skin(mesh, kept)
        cut_points = np.asarray(half.points)
        views[f"cut across {axis}"] = [len(traces), len(traces) + 1, *always]
        traces.append(_faces(cut_points, half.regular_faces, intensity=half.cell_data["scaled_jacobian"]))
        traces.append(_lines(cut_points, _unique_edges(half.regular_faces), color="#303030", width=1))
    # With the aspect "data" a length of the view is one of the model over the geometric mean of the box's sides; a cube
    # fills the view from plotly's own 1.25.
    sides = np.maximum(np.ptp(points, axis=0), 1e-9 * np.ptp(points))
    eye = 1.25 * float(np.linalg.norm(sides) / np.sqrt(3) / np.prod(sides) ** (1 / 3))
    axes = {"showbackground": False, "showspikes": False}
    layout = {
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "scene": {
            "aspectmode": "data",
            "camera": {"eye": dict.fromkeys("xyz", eye)},
            "xaxis": axes,
            "yaxis": axes,
            "zaxis": axes,
        },
        "legend": {"x": 0, "y": 1, "itemsizing": "constant"},
        "uirevision": "same",
    }
    for i in views["quality"]:
        traces[i]["visible"] = True
    remark = "Drag to turn, scroll to zoom, click a name in the legend to hide it."
    if not small:
        remark += f" The outside has {len(quads):,} quads: edges and cuts are left out."
    return {"traces": traces, "views": views, "layout": layout}, remark


def _faces(
    points: FloatArray,
    quads: IntArray,
    *,
    intensity: FloatArray | None = None,
    color: str | None = None,
    name: str | None = None,
) -> dict[str, Any]:
    """Quads as pairs of triangles, coloured by a number a quad or by one colour."""
    used, inverse = np.unique(quads, return_inverse=True)
    corners = inverse.reshape(quads.shape)
    triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    x, y, z = points[used].T
    trace: dict[str, Any] = {"type": "mesh3d", "x": _array(x), "y": _array(y), "z": _array(z), "flatshading": True}
    trace |= {key: _array(triangles[:, j]) for j, key in enumerate("ijk")}
    trace["lighting"] = {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05}
    trace["visible"] = False
    if intensity is not None:
        trace |= {"intensity": _array(np.repeat(intensity, 2)), "intensitymode": "cell", "cmin": 0, "cmax": 1}
        trace |= {"colorscale": "Viridis", "colorbar": {"title": {"text": "scaled Jacobian"}, "len": 0.7}}
        trace["hovertemplate"] = "scaled Jacobian %{intensity:.3f}<extra></extra>"
    else:
        trace |= {"color": color, "name": name, "showlegend": True, "hovertemplate": f"{name}<extra></extra>"}
    return trace


def _lines(points: FloatArray, edges: IntArray, *, color: str, width: int, name: str | None = None) -> dict[str, Any]:
    """Edges as one line with gaps."""
    places = np.full((len(edges), 3, 3), np.nan)
    places[:, :2] = points[edges]
    x, y, z = places.reshape(-1, 3).T
    trace: dict[str, Any] = {"type": "scatter3d", "mode": "lines", "x": _array(x), "y": _array(y), "z": _array(z)}
    trace |= {"line": {"color": color, "width": width}, "hoverinfo": "skip", "showlegend": name is not None}
    return trace | {"name": name or "edges", "visible": False}


def _unique_edges(quads: IntArray) -> IntArray:
    """Every edge (m, 2) of quads once."""
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0)
