"""What is said of a mesh, a part, a sweep, a report in a few lines of HTML: the cards of notebooks.

Place in the flow: called by the ``_repr_html_`` of the values themselves, through :mod:`cadsweep.verbs`.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from .. import cad
from ..brep import Part, Solid
from ..errors import CadSweepError
from ..mesh import HexMesh
from ..quality import QualityReport
from ..sweep import Sweep
from ..view import mesh_picture, part_picture
from .page import table

PLAIN, SOURCE, TARGET = "#d6dbe2", "#1f77b4", "#ff7f0e"


def quality_of(mesh: HexMesh) -> QualityReport:
    report = mesh.info.get("quality")
    return report if isinstance(report, QualityReport) else mesh.quality()


def verdict(report: QualityReport) -> str:
    if report.valid:
        return '<p class="valid">Valid: every check passed.</p>'
    return f'<p class="invalid">Not valid: {escape("; ".join(report.problems))}</p>'


def figures(report: QualityReport) -> list[tuple[str, str]]:
    return [
        ("nodes", f"{report.n_nodes:,}"),
        ("hexahedra", f"{report.n_hexes:,} of order {report.order}"),
        ("inverted", f"{report.n_inverted:,}"),
        ("worst scaled Jacobian", f"{report.min_scaled_jacobian:.4f}"),
        ("mean scaled Jacobian", f"{report.mean_scaled_jacobian:.4f}"),
        ("volume", f"{report.volume:.8g}"),
    ]


def histogram(report: QualityReport) -> str:
    """Bars of the scaled Jacobian as SVG; red below zero."""
    edges, counts = report.histogram
    most = max(int(np.max(counts)), 1)
    bars = ""
    for i, count in enumerate(counts.tolist()):
        height = 120 * count / most if count else 0
        color = "#b3261e" if edges[i] < 0 else "#1f5fa8"
        label = f"<title>{edges[i]:.4g} to {edges[i + 1]:.4g}: {count:,}</title>"
        bars += f'<rect x="{18 * i + 8}" y="{130 - height:.1f}" width="16" height="{height:.1f}" fill="{color}">'
        bars += f"{label}</rect>"
    ticks = "".join(
        f'<text x="{18 * i + 8}" y="146" font-size="11" text-anchor="middle">{edges[i]:.3g}</text>'
        for i in range(0, len(edges), 5)
    )
    width = 18 * len(counts) + 24
    return f'<svg width="{width}" height="150" viewBox="0 0 {width} 150" role="img">{bars}{ticks}</svg>'


def mesh_summary_html(mesh: HexMesh) -> str:
    """Return a card of a mesh: picture, figures, histogram. Runs the checks unless the mesh has their report."""
    report = quality_of(mesh)
    boundaries = ", ".join(f"{escape(name)} ({len(quads):,})" for name, quads in mesh.boundaries.items())
    rows = [*figures(report), ("boundaries (quads)", boundaries or "none")]
    return _card(_image(lambda: mesh_picture(mesh)), verdict(report) + table(rows) + histogram(report))


def report_card(report: QualityReport) -> str:
    """Return a card of a report: verdict, figures, histogram, the worst hexahedra."""
    worst = "".join(f"<li>{escape(str(hexahedron))}</li>" for hexahedron in report.worst[:3])
    return _card(histogram(report), f"{verdict(report)}{table(figures(report))}<ul>{worst}</ul>")


def part_card(part: Part) -> str:
    """Return a card of a part: its faces in the colours of the model, its solids, its names."""
    names = [face.name for solid in part.solids for face in solid.faces if face.name]
    rows = [
        ("solids", escape(", ".join(model.name for model in part.models))),
        ("cells", f"{len(part.solids)}"),
        ("faces", f"{sum(len(solid.faces) for solid in part.solids)}"),
        ("volume", f"{sum(model.volume for model in part.models) * part.scale**3:.8g}"),
        ("names of faces", escape(", ".join(dict.fromkeys(names))) or "none"),
    ]
    drawn = [(solid, {face.id: face.color or solid.color or PLAIN for face in solid.faces}) for solid in part.solids]
    return _card(_image(lambda: _picture(drawn)), f"<b>{escape(part.name)}</b>{table(rows)}")


def sweep_card(sweep: Sweep) -> str:
    """Return a card of a sweep: its source blue, its target orange, its sides grey."""
    solid = sweep.solid
    colors = {face.id: PLAIN for face in solid.faces}
    colors |= dict.fromkeys(sweep.source, SOURCE) | dict.fromkeys(sweep.target, TARGET)
    rows = [
        (f'<span style="color: {color}">&#9632;</span> {word}', escape(", ".join(solid.faces[f].label() for f in caps)))
        for word, color, caps in (("source", SOURCE, sweep.source), ("target", TARGET, sweep.target))
    ]
    rows += [
        ("linking sides", f"{len(sweep.linking_sides)}"),
        ("stations", f"{len(sweep.stations)}"),
        ("score", f"{sweep.score:.2f}"),
    ]
    return _card(_image(lambda: _picture([(solid, colors)])), table(rows))


def _picture(drawn: Sequence[tuple[Solid, Mapping[int, str]]]) -> Any:
    """A picture of solids, each with the colours of its faces."""
    painted = []
    for solid, colors in drawn:
        for face, (points, triangles) in enumerate(cad.find_facets(solid)):
            if len(triangles):
                painted.append((points, triangles, colors[face]))
    edges = [
        edge.curve.evaluate(np.linspace(0.0, 1.0, 2 if edge.kind == "line" else 25))
        for solid, _ in drawn
        for edge in solid.edges
    ]
    return part_picture(painted, edges)


def _image(draw: Callable[[], Any]) -> str:
    """A picture as an element; where none can be drawn, why."""
    try:
        picture = draw()
    except CadSweepError as error:  # no pyvista, no display: the figures are worth showing without
        return f"<small>no picture: {escape(str(error))}</small>"
    data = io.BytesIO()
    picture.save(data, format="png", optimize=True)
    return f'<img width="400" alt="" src="data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}">'


def _card(left: str, right: str) -> str:
    return f'<div style="display: flex; flex-wrap: wrap; gap: 1rem"><div>{left}</div><div>{right}</div></div>'
