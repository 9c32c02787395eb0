"""The model found on the skin of a grid, with all its edges, or with those that the grid can hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Solid
from ..harmonic import sides_of
from .facets import Facets, Nearest
from .grid import Grid
from .labels import label_quads
from .letting import let_go, missed
from .mending import mend_labels
from .rings import Reduced, without_rings
from .sheets import Fitted
from .strips import lay_strips
from .topology import MisfitError, match_topology
from .uniting import United, unite_as

_SAMPLES = 33
"""Places of an edge at which the mesh is asked how far it is off."""


class Crease(NamedTuple):
    """An edge of the model that was let go, the united face around it, and the nodes that the grid has for it."""

    edge: Edge
    face: int
    nodes: IntArray


class Found(NamedTuple):
    """A grid on which the model was found.

    Attributes
    ----------
    united : United
        The model, of which more faces are one where edges were let go.
    reduced : Reduced
        The same without the rings that are still to be laid.
    skin : Fitted
        The grid; labels and chains are those of `united`.
    creases : tuple of Crease
    size : float
        Of the grid.
    is_mended : bool
        Whether labels were changed for it.
    """

    united: United
    reduced: Reduced
    skin: Fitted
    creases: tuple[Crease, ...]
    size: float
    is_mended: bool = False

    @property
    def lost(self) -> float:
        """How much its edges are missed that were let go."""
        return sum(missed(crease.edge) for crease in self.creases)


class Labelled(NamedTuple):
    """A grid in a model.

    Attributes
    ----------
    united : United
        The model for a grid of that size.
    reduced : Reduced
        The same without the rings that are still to be laid.
    skin : Fitted
        The grid, every quad with a face of `reduced`, strips laid in; no chains yet.
    size : float
        Of the grid.
    """

    united: United
    reduced: Reduced
    skin: Fitted
    size: float


def label_on_grid(
    united: United, facets: Facets, grid: Grid, size: float, *, on_step: Callable[[], None] = lambda: None
) -> Labelled:
    """Label the skin of a grid of a size with the faces of a model, united for it, by facets of the model's faces.

    `on_step` is called now and then, and may raise.

    Raises
    ------
    SurfaceMeshError
        A strip that the grid is too coarse for cannot be laid in.
    """
    first = without_rings(united.solid, size)
    covering = facets._replace(faces=first.of_face[united.of_face[facets.faces]])
    labels = label_quads(first.solid, covering, grid.points, grid.quads, size)
    skin = Fitted(points=grid.points, hexes=grid.hexes, quads=grid.quads, labels=labels, chains={})
    return Labelled(united, first, lay_strips(first.solid, skin, size, on_step), size)


def find_on_grid(
    model: Solid,
    facets: Facets,
    labelled: Labelled,
    *,
    letting: bool = False,
    mending: bool = False,
    on_step: Callable[[], None] = lambda: None,
) -> Found:
    """The model found on a grid.

    Parameters
    ----------
    model : Solid
    facets : Facets
        Of its faces.
    labelled : Labelled
    letting : bool
        Let edges go that the grid cannot hold.
    mending : bool
        Change labels, if few will do.
    on_step : callable
        Called now and then; may raise.

    Raises
    ------
    MisfitError
        The grid has not the model's topology.
    SurfaceMeshError
        Nor has it that with fewer edges.
    """
    united, first, skin, size = labelled
    reduced = first
    if mending:
        skin = replace(skin, labels=mend_labels(first.solid, skin.quads, skin.labels))
    fewer, numbers = united, np.arange(len(first.faces))  # of every face of `first` the number once more are one
    asked: list[tuple[int, int]] = []
    before = numbers
    while True:
        try:
            chains = match_topology(reduced.solid, skin.points, skin.quads, numbers[skin.labels], size)
            break
        except MisfitError as misfit:
            if not letting:
                raise
            beside = [reduced.solid.edges[edge].faces for edge in misfit.edges]
            asked += [(int(np.argmax(numbers == one)), int(np.argmax(numbers == other))) for one, other in beside]
            parts = let_go(first.solid, skin.points, skin.quads, skin.labels, size, asked, on_step)
            if np.array_equal(parts, before):
                raise
            before = parts
            fewer = _with_parts(model, facets, size, united, first, parts)
            reduced = without_rings(fewer.solid, size, _left(united, first, fewer))
            numbers = reduced.of_face[fewer.of_face[_members(united)[first.faces]]]
            if len(np.unique(numbers)) < len(reduced.faces):  # a ring that can no longer be laid in
                raise
    on_model = replace(
        skin,
        labels=reduced.faces[numbers[skin.labels]],
        chains={int(reduced.edges[edge]): nodes for edge, nodes in chains.items()},
    )
    is_mended = not np.array_equal(skin.labels, labelled.skin.labels)
    return Found(fewer, reduced, on_model, tuple(_creases(first, reduced.faces[numbers], skin, size)), size, is_mended)


def farthest(creases: tuple[Crease, ...], points: FloatArray, quads: IntArray) -> float:
    """How far the boundary of a mesh is off edges that were let go."""
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    along = np.linspace(0.0, 1.0, _SAMPLES)
    places = np.concatenate([crease.edge.curve.evaluate(along) for crease in creases])
    return float(Nearest(Facets(points, triangles, np.zeros(len(triangles), dtype=np.int64)))(places)[0].max())


def _members(united: United) -> IntArray:
    """A face of the model of every united one."""
    return np.unique(united.of_face, return_index=True)[1].astype(np.int64)


def _with_parts(  # noqa: PLR0917
    model: Solid, facets: Facets, size: float, united: United, reduced: Reduced, parts: IntArray
) -> United:
    """The model with more faces united: those of one part of the reduced solid, and rings between two of these."""
    of_united = np.arange(len(united.solid.faces)) + len(parts)
    of_united[reduced.faces] = parts
    for ring in reduced.rings:
        sides = {int(parts[reduced.of_face[f]]) for e in (*ring.lost, *ring.kept) for f in united.solid.edges[e].faces}
        if len(sides) == 1:
            of_united[ring.face] = sides.pop()
    of_face = np.unique(of_united[united.of_face], return_inverse=True)[1].astype(np.int64)
    return unite_as(model, facets, size, of_face, united.bridged)


def _left(united: United, reduced: Reduced, fewer: United) -> list[int]:
    """The rings that are faces by themselves still, by their numbers once fewer faces are united."""
    now = [fewer.of_face[united.of_face == ring.face][0] for ring in reduced.rings]
    before = [(united.of_face == ring.face).sum() for ring in reduced.rings]
    return [int(own) for own, n in zip(now, before, strict=True) if (fewer.of_face == own).sum() == n]


def _creases(first: Reduced, of_face: IntArray, skin: Fitted, size: float) -> list[Crease]:
    """Edges of a solid whose faces became one, by what these are in the end, and nodes between their labels."""
    segments, beside = sides_of(skin.quads)
    sides = np.sort(skin.labels[beside], axis=1)
    gone = [edge for edge in first.solid.edges if of_face[edge.faces[0]] == of_face[edge.faces[1]]]
    nearest: dict[int, tuple[float, int]] = {}
    for edge in gone:
        nodes = np.unique(segments[(sides == sorted(edge.faces)).all(axis=1)])
        for node, away in zip(nodes.tolist(), edge.curve.distance(skin.points[nodes]).tolist(), strict=True):
            nearest[node] = min(nearest.get(node, (size, -1)), (away, edge.id))
    return [
        Crease(
            edge,
            int(of_face[edge.faces[0]]),
            np.array([node for node, (_, own) in nearest.items() if own == edge.id], dtype=np.int64),
        )
        for edge in gone
    ]
