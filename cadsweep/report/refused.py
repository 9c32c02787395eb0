"""The page about a part that is refused: the part with the faces in question coloured, and why.

Place in the flow: called by ``cadsweep report`` where there is no mesh to report on.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .. import cad
from .._version import __version__
from ..arrays import FloatArray
from ..brep import Part
from .page import listed, make_layout, table, write_page
from .traces import faces, lines

IN_QUESTION, PLAIN, LEFT = "#e0241b", "#d6dbe2", "#f28e00"


def write_refusal(
    part: Part,
    path: str | PathLike[str],
    *,
    reason: str,
    where: str = "",
    hint: str = "",
    faces_in_question: Collection[int],
    reasons: Sequence[str] = (),
    command: str | None = None,
    left: Sequence[FloatArray] = (),
) -> Path:
    """Write a page about a part that has no mesh.

    Parameters
    ----------
    part : Part
    path : path
        Suffix ``.html``.
    reason : str
        What the refusal says.
    where, hint : str
        The face or the place in the way, and what to try.
    faces_in_question : collection of int
        Ids of the faces that are coloured, of the solids that `reason` names.
    reasons : sequence of str
        Why each face is no cap, each direction gives no columns, and each cell of the best cuts has no sweep, a line
        each.
    command : str, optional
        What was tried; shown on the page.
    left : sequence of (m, 3) float64
        Outline of the cell that no cuts made sweepable, drawn over the part: ``NotSweepableError.left``.

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
    >>> from cadsweep.report import write_refusal
    >>> ball = cs.load(cq.Workplane().sphere(3))
    >>> write_refusal(ball, "ball.html", reason="a ball is no sweep", faces_in_question=[0]).name
    'ball.html'
    """
    chosen = _chosen(part, reason, faces_in_question)
    several = len(part.solids) > 1
    rows = [
        (escape((f"{part.solids[j].name}: " if several else "") + part.solids[j].faces[f].label()), "")
        for j, f in sorted(chosen)
    ]
    told = "".join(f"<p>{word}: {escape(text)}</p>" for word, text in (("Where", where), ("Try", hint)) if text)
    made = f"<p>Tried: <code>{escape(command)}</code>, cadsweep {__version__}.</p>" if command else ""
    sections = [
        f'<h1>{escape(part.name)}</h1><p class="invalid">No mesh: {escape(reason)}</p>{told}{made}',
        '<div class="bar" id="bar"></div><div id="view"></div>',
        "<p>Drag to turn, scroll to zoom, click a name in the legend to hide it.</p>",
        f"<h2>Faces in question</h2>{table(rows)}" if rows else "",
        "".join(listed(title, lines) for title, lines in _sorted(reasons)) + listed("Notes", part.notes),
    ]
    return write_page(Path(path), f"{part.name}: no mesh", sections, _scene(part, chosen, left))


_TITLES = (
    ("What each face lacks as a cap", ("face ",)),
    ("Why it is no stack of columns", ("no stack of columns",)),
    ("What the best cuts leave, and why", ("sets of cuts", "a cell at", "all cells can be filled")),
)
"""Headings of reasons, and words that the lines below each have or begin with."""


def _sorted(reasons: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Reasons under the headings that they belong to; what belongs to none under one of its own, the last."""
    left, found = list(reasons), []
    for title, words in _TITLES:
        own = [line for line in left if any(word in line[:40] for word in words)]
        left = [line for line in left if line not in own]
        found.append((title, own))
    return [(title, lines) for title, lines in [*found, ("What else was tried", left)] if lines]


def _chosen(part: Part, reason: str, wanted: Collection[int]) -> set[tuple[int, int]]:
    """Solid and face of what is coloured: of the solids that the refusal names, with all pieces of a divided face."""
    named = {j for j, solid in enumerate(part.solids) if solid.name and f"'{solid.name}'" in reason}
    found = set()
    for j, solid in enumerate(part.solids):
        if named and j not in named:
            continue
        keys = {solid.faces[f].key for f in wanted if f < len(solid.faces)} - {""}
        found |= {(j, face.id) for face in solid.faces if face.id in wanted or face.key in keys}
    return found


def _scene(part: Part, questioned: set[tuple[int, int]], left: Sequence[FloatArray]) -> dict[str, Any]:
    """The faces in question one by one, by name, all others together, the edges, and the cell that is left."""
    others: list[tuple[Any, Any]] = []
    traces = []
    for j, solid in enumerate(part.solids):
        for face, (points, triangles) in zip(solid.faces, cad.find_facets(solid), strict=True):
            if not len(triangles):
                continue
            if (j, face.id) in questioned:
                traces.append(faces(part.to_model(points), triangles, color=IN_QUESTION, name=face.label()))
            else:
                others.append((points, triangles))
    if others:
        starts = np.cumsum([0, *(len(points) for points, _ in others)])
        joined = np.concatenate([triangles + start for (_, triangles), start in zip(others, starts, strict=False)])
        everywhere = part.to_model(np.concatenate([points for points, _ in others]))
        traces.append(faces(everywhere, joined, color=PLAIN, name="other faces"))
    chains = [
        part.to_model(edge.curve.evaluate(np.linspace(0.0, 1.0, 2 if edge.kind == "line" else 33)))
        for solid in part.solids
        for edge in solid.edges
    ]
    traces.append(_drawn(chains, color="#303030", width=3))
    if left:
        traces.append(_drawn(left, color=LEFT, width=9, name="left without a sweep"))
    for trace in traces:
        trace["visible"] = True
    layout = make_layout(np.concatenate(chains))
    return {"traces": traces, "views": {"faces in question": list(range(len(traces)))}, "layout": layout}


def _drawn(chains: Sequence[FloatArray], *, color: str, width: int, name: str | None = None) -> dict[str, Any]:
    """Chains of points as lines."""
    first = np.cumsum([0, *(len(chain) for chain in chains)])[:-1]
    pairs = [
        np.column_stack([np.arange(len(c) - 1), np.arange(1, len(c))]) + k for c, k in zip(chains, first, strict=True)
    ]
    return lines(np.concatenate(chains), np.concatenate(pairs), color=color, width=width, name=name)
