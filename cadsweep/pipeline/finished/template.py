"""What another part's mesh must know of a mesh to be like it: no CAD, arrays and names alone.

Place in the flow: made from what a mesh was made from (:mod:`..origin`), or read from a file, which holds it;
:mod:`.like` carries it to another part. It is by the model's faces, edges and vertices, whatever the mesh is made of.
Ids of these run through all solids of the model (:func:`~.graphs.first_ids`).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray
from ...blocks.cells import CellBlocks
from ...brep import Edge, Solid, Units
from ...entity.entities import Entities
from ...mesh import HexMesh
from ...options import SweepOptions
from ...projection.carried import MeshedFace, meshed_face
from ..complexes.swept import twins_of
from ..origin import CellsOrigin, DesignChoice, GroupsOrigin, first_order, origin_of
from .graphs import Graph, first_ids, graph_of_part
from .model_faces import OnModel, faces_parted, find_on_model


class FactoredCells(NamedTuple):
    """Cells as factors, and the units of the model that their nodes are brought to."""

    cells: CellBlocks
    units: Units

    def placed(self) -> tuple[FloatArray, FloatArray, IntArray]:
        """Nodes in working and in model units, and hexahedra."""
        joined = self.cells.joined()
        return joined.points, self.units.to_model(joined.points), joined.hexes


@dataclass(frozen=True, kw_only=True, eq=False)
class Template:
    """A mesh that others can be made like.

    Attributes
    ----------
    points : (n, 3) float64
        Working units.
    mesh : HexMesh
        Of order 1, in model units; what others get of it are its hexes and names.
    graph : Graph
        Of the solids before they were cut.
    hex_solids : (m,) int64
        Solid of every hex.
    quads : (q, 4) int64
        Boundary of every solid, outward; a quad between two solids stands here twice.
    quad_faces : (q,) int64
    faces : dict of int to MeshedFace
        Of a face between two solids, the first one's.
    edges : dict of int to ((m,) int64, (m,) float64)
        Nodes along every edge that is followed, start to end, and their fractions of its arc length.
    vertices : (v,) int64
        Node on every vertex; -1 where there is none, as on a seam that nothing follows.
    outside, between : dict of int to tuple of str
        Names of boundaries and interfaces by face.
    patches : dict of int to tuple of tuple of str
        Names of boundaries that are patches of a face, as of a mark that was flattened.
    first_faces : tuple of int
        A face of every solid.
    first : tuple of int
        Faces of the solids that the names of their interfaces begin with.
    solids : dict of str to Any
        What of the model is meshed, and how: ``only``, ``skip``, ``interfaces``.
    factored : FactoredCells or None
        What `points` and the mesh's nodes and hexes are multiplied out of, where it is known.
    answers : dict of int to int
        Of one sweep, the face of the target that every face of the source is carried to.
    twins : dict of int to int or None
        Of a ring that was cut open, the edges of the one side of the cut, and those of the other at the same places.
    is_swept : bool
        Whether the model was made ready for one sweep, as another part has to be; and the caps that its user named.
    choice : (Any, Any)
    """

    points: FloatArray
    mesh: HexMesh
    graph: Graph
    hex_solids: IntArray
    quads: IntArray
    quad_faces: IntArray
    faces: dict[int, MeshedFace]
    edges: dict[int, tuple[IntArray, FloatArray]]
    vertices: IntArray
    outside: dict[int, tuple[str, ...]]
    between: dict[int, tuple[str, ...]]
    first_faces: tuple[int, ...]
    first: tuple[int, ...]
    solids: dict[str, Any]
    patches: dict[int, tuple[tuple[str, ...], ...]] = field(default_factory=dict)
    factored: FactoredCells | None = None
    answers: dict[int, int] = field(default_factory=dict)
    twins: dict[int, int] | None = None
    is_swept: bool = False
    choice: tuple[Any, Any] = (None, None)


@dataclass(frozen=True, kw_only=True, eq=False)
class GroupsTemplate:
    """A mesh of solids that do not all touch.

    Attributes
    ----------
    groups : tuple of (tuple of str, AnyTemplate)
        Names of the solids that hang together, and their mesh.
    mesh : HexMesh
        All of it, of order 1.
    solids : dict of str to Any
        What of the model is meshed, and how: ``only``, ``skip``, ``interfaces``.
    """

    groups: tuple[tuple[tuple[str, ...], AnyTemplate], ...]
    mesh: HexMesh
    solids: dict[str, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignTemplate:
    """A mesh that was carried to its model from a design.

    Attributes
    ----------
    design : AnyTemplate
        The mesh of the design.
    choice : DesignChoice
    names : tuple of tuple of str
        Of the model's faces.
    labels : dict of str to str
        Names to what the user calls them.
    mesh : HexMesh
        On the model, of order 1.
    solids : dict of str to Any
        What of the model is meshed, and how: ``only``, ``skip``, ``interfaces``.
    """

    design: AnyTemplate
    choice: DesignChoice
    names: tuple[tuple[str, ...], ...]
    labels: dict[str, str]
    mesh: HexMesh
    solids: dict[str, Any]


AnyTemplate = Template | GroupsTemplate | DesignTemplate


def make_template(mesh: HexMesh, purpose: str) -> AnyTemplate:
    """See a mesh as a template.

    Raises
    ------
    InputError
        The mesh does not know its CAD model, or its nodes do not follow the model's edges.
    """
    origin = origin_of(mesh, purpose)
    if isinstance(origin, GroupsOrigin):
        return GroupsTemplate(
            groups=tuple((group.solids, make_template(group.mesh, purpose)) for group in origin.groups),
            mesh=mesh,
            solids=meshed_words(origin.options),
        )
    if origin.design is not None:
        return DesignTemplate(
            design=make_template(origin.design.mesh, purpose),
            choice=origin.design.choice,
            names=tuple(face.names for face in origin.model.solids[0].faces),
            labels=origin.model.names,
            mesh=_plain(mesh, len(origin.joined.points)),
            solids=meshed_words(origin.options),
        )
    model, names, joined = origin.model, origin.names, origin.joined
    starts, graph = first_ids(model), graph_of_part(model)
    solid_of = {owner: solid for solid, owner in enumerate(model.owners)}
    quads, faces, edges = [], [], dict[int, tuple[IntArray, FloatArray]]()
    vertices = np.full(starts.vertices[-1], -1, dtype=np.int64)
    outside, between, first = dict[int, tuple[str, ...]](), dict[int, tuple[str, ...]](), list[int]()
    patches = dict[int, tuple[tuple[str, ...], ...]]()
    for owner, j in sorted(solid_of.items()):
        own = [
            (place, rows)
            for place, rows in origin.entities.faces.items()
            if (names.of(place) or origin.is_swept) and origin.part.owners[place[0]] == owner
        ]
        every = np.concatenate([rows for _, rows in own])
        solid = model.solids[j]
        is_whole = len(origin.part.solids) == len(model.solids) and origin.part.solids[j] is solid
        found = _as_meshed(origin.entities, j, own) if is_whole else find_on_model(solid, joined.points, every)
        quads.append(every)
        faces.append(found.faces + starts.faces[j])
        vertices[starts.vertices[j] : starts.vertices[j + 1]] = found.vertices
        for e, chain in found.edges.items():
            edges[starts.edges[j] + e] = chain, _fractions(solid.edges[e], chain, joined.points, found.vertices)
        row = 0
        for place, rows in own:
            pieces = [f + starts.faces[j] for f in found.pieces[int(found.faces[row])]]
            if place in names.outside:
                outside |= dict.fromkeys(pieces, names.outside[place])
                on_it = [own for piece, own in sorted(names.patches.items()) if piece[:2] == place]
                if set(itertools.chain(*on_it)) & mesh.boundaries.keys() - {*names.outside[place]}:
                    patches |= dict.fromkeys(pieces, tuple(on_it))
            elif place in names.between:
                between |= dict.fromkeys(pieces, names.between[place])
                first += pieces if names.first[place] else []
            row += len(rows)
    ids, rows = np.concatenate(faces), np.concatenate(quads)
    return Template(
        points=joined.points,
        mesh=_plain(mesh, len(joined.points)),
        graph=graph,
        hex_solids=np.array([solid_of[owner] for owner in origin.part.owners], dtype=np.int64)[joined.hex_cells],
        quads=rows,
        quad_faces=ids,
        faces=_meshed(model.solids, joined.points, rows, ids, graph),
        edges=edges,
        vertices=vertices,
        outside=outside,
        between=between,
        patches=patches,
        first_faces=starts.faces[:-1],
        first=tuple(sorted(set(first))),
        solids=meshed_words(origin.options),
        factored=_factored(origin),
        answers=_answers(origin),
        twins=twins_of(model.solids[0]) if origin.is_swept else None,
        is_swept=origin.is_swept,
        choice=(origin.options.source, origin.options.target),
    )


def _plain(mesh: HexMesh, n_nodes: int) -> HexMesh:
    """The mesh of order 1, so many nodes, without what it was made of."""
    info = {name: value for name, value in mesh.info.items() if name != "quality"}
    return replace(first_order(mesh, n_nodes), origin=None, info=info)


def _as_meshed(entities: Entities, cell: int, own: Sequence[tuple[tuple[int, int], IntArray]]) -> OnModel:
    """What a solid's nodes are on, of one that nothing was cut from."""
    solid = entities.part.solids[cell]
    chains = {e: entities.chains[key] for e, key in enumerate(solid.edge_keys.tolist()) if key in entities.chains}
    pieces = faces_parted(solid, chains)
    first = {face: united for united, faces in pieces.items() for face in faces}
    return OnModel(
        faces=np.repeat([first[face] for (_, face), _ in own], [len(rows) for _, rows in own]),
        edges=chains,
        vertices=np.array([entities.vertices.get(key, -1) for key in solid.vertex_keys.tolist()], dtype=np.int64),
        pieces=pieces,
    )


def _answers(origin: CellsOrigin) -> dict[int, int]:
    """The face of the target that every face of the source of one sweep is carried to."""
    sweep = origin.sweep
    if sweep is None:
        return {}
    alone = len(sweep.source) == len(sweep.target) == 1
    return {sweep.source[0]: sweep.target[0]} if alone else dict(sweep.target_faces)


def _fractions(edge: Edge, chain: IntArray, points: FloatArray, vertices: IntArray) -> FloatArray:
    """Of an edge's length, where its nodes are; no number for a node over its end, which is of another edge."""
    at = np.clip(edge.curve.project(points[chain]), 0.0, 1.0)
    for place, vertex, end in ((0, edge.start, 0.0), (-1, edge.end, 1.0)):
        if chain[place] == vertices[vertex]:
            at[place] = end
        elif at[place] == end:
            at[place] = np.nan
    return at


def _factored(origin: CellsOrigin) -> FactoredCells | None:
    """The factors of a mesh, with the nodes that are elsewhere by now; None where it is not made of any."""
    factors, points = origin.cells, origin.joined.points
    if factors is None or not np.array_equal((first := factors.joined()).hexes, origin.joined.hexes):
        return None
    moved = np.flatnonzero((first.points != points).any(axis=1))
    cells = replace(factors, moved_nodes=moved, moved_points=points[moved])
    return FactoredCells(cells, Units(origin.part.scale, origin.part.offset))


def meshed_words(options: SweepOptions) -> dict[str, Any]:
    """Which solids are meshed, and whether they share what they touch in."""
    return {
        "only": None if options.only is None else list(options.only),
        "skip": None if options.skip is None else list(options.skip),
        "interfaces": options.interfaces,
    }


def _meshed(
    solids: Sequence[Solid], points: FloatArray, quads: IntArray, ids: IntArray, graph: Graph
) -> dict[int, MeshedFace]:
    """Every face with its quads, those between two solids once."""
    surfaces = [face.surface for solid in solids for face in solid.faces]
    twice = {max(pair) for pair in graph.shared_faces}
    return {
        face: meshed_face(quads[ids == face], points, surfaces[face])
        for face in np.unique(ids).tolist()
        if face not in twice
    }
