"""Ids of the vertices, edges and faces of a prism over the cells of a plane.

Place in the flow: second step of :mod:`.prism`.
"""

from __future__ import annotations

from dataclasses import dataclass

from .prism_plane import PlaneCells


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """What every vertex, line and cell of the plane becomes in the prism.

    Attributes
    ----------
    lower_vertex, upper_vertex : dict of int to int
        By vertex of the plane.
    rails : dict of int to int
        Edge up from every vertex of the rim.
    lower, upper : dict of int to int
        Edge at the bottom and at the top, by line.
    bottoms, tops : tuple of int
        Faces, by cell.
    """

    lower_vertex: dict[int, int]
    upper_vertex: dict[int, int]
    rails: dict[int, int]
    lower: dict[int, int]
    upper: dict[int, int]
    bottoms: tuple[int, ...]
    tops: tuple[int, ...]


def number_prism(cells: PlaneCells) -> Numbers:
    """Number the rim side by side, then what every cell adds; of faces sides first, then bottoms and tops in turn."""
    ends = cells.shared.ends
    lower_vertex, upper_vertex = dict[int, int](), dict[int, int]()
    rails, lower, upper = dict[int, int](), dict[int, int](), dict[int, int]()
    n_edges = n_vertices = 0
    for j in range(cells.n_rim):
        for v in ends[j].tolist():
            if v not in rails:
                rails[v], n_edges = n_edges, n_edges + 1
                lower_vertex[v], upper_vertex[v], n_vertices = n_vertices, n_vertices + 1, n_vertices + 2
        lower[j], upper[j], n_edges = n_edges, n_edges + 1, n_edges + 2
    for own in cells.loops:
        new = sorted({j for loop in own for j in loop.edges if j not in lower})
        corners = [v for v in dict.fromkeys(ends[new].ravel().tolist()) if v not in lower_vertex]
        for edges, vertices in ((lower, lower_vertex), (upper, upper_vertex)):
            edges.update((j, n_edges + k) for k, j in enumerate(new))
            vertices.update((v, n_vertices + k) for k, v in enumerate(corners))
            n_edges, n_vertices = n_edges + len(new), n_vertices + len(corners)
    bottoms = tuple(range(cells.n_rim, cells.n_rim + 2 * len(cells.loops), 2))
    return Numbers(
        lower_vertex=lower_vertex,
        upper_vertex=upper_vertex,
        rails=rails,
        lower=lower,
        upper=upper,
        bottoms=bottoms,
        tops=tuple(f + 1 for f in bottoms),
    )


__all__ = ["Numbers", "number_prism"]
