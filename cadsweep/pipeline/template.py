"""What another part's mesh must know of a mesh to be like it: no CAD, arrays and names alone.

Place in the flow: made from a mesh's :class:`~.origin.Origin`, or read from a file of factors, which holds it;
:mod:`.like` carries it to another part.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.block import FactoredMesh
from ..mesh import HexMesh, QuadMesh, SurfaceMesh
from ..projection.carried import MeshedFace, meshed_face
from ..sweep import LinkingSide, Sweep
from .cells_template import (
    CellsTemplate,
    faces_of_arrays,
    make_cells_template,
    meshed_words,
    parameter_arrays,
    tuples,
)
from .graphs import Graph, graph_of
from .origin import CellsOrigin, GroupsOrigin, Origin, origin_of

PREFIX = "like_"

_CHAINS = ("bottom", "right", "top", "left")


@dataclass(frozen=True, kw_only=True, eq=False)
class Template:
    """A mesh that others can be made like.

    Attributes
    ----------
    factored : FactoredMesh
    graph : Graph
        Of the solid that was swept.
    roles : dict
        The fields of its :class:`~cadsweep.sweep.Sweep`, but the solid.
    surfaces : SurfaceMesh
    target_faces : (q,) int64
        Face of every quad of the target cap.
    faces : dict of int to MeshedFace
        By face id; nodes are numbered layer by layer, ``k * n_nodes + i``, also those of the last layer of a ring.
    on_edges : dict of int to ((m,) int64, (m,) float64)
        Nodes on every edge, vertices left out, and their fractions of its arc length.
    choice : (Any, Any)
        The caps that the user named, if so.
    residual : bool
        Whether the sweep carries what its affine maps leave.
    """

    factored: FactoredMesh
    graph: Graph
    roles: dict[str, Any]
    surfaces: SurfaceMesh
    target_faces: IntArray
    faces: dict[int, MeshedFace]
    on_edges: dict[int, tuple[IntArray, FloatArray]]
    choice: tuple[Any, Any] = (None, None)
    residual: bool = True

    @property
    def n_layers(self) -> int:
        """Layers of hexahedra."""
        return self.factored.structure.n_layers


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


AnyTemplate = Template | CellsTemplate | GroupsTemplate


def make_template(mesh: HexMesh, purpose: str) -> AnyTemplate:
    """See a mesh as a template.

    Raises
    ------
    InputError
        The mesh does not know its CAD model, or its nodes do not follow the model's edges.
    """
    origin = origin_of(mesh, purpose)
    if isinstance(origin, CellsOrigin):
        return make_cells_template(origin, mesh)
    if isinstance(origin, GroupsOrigin):
        return GroupsTemplate(
            groups=tuple((group.solids, make_template(group.mesh, purpose)) for group in origin.groups),
            mesh=mesh,
            solids=meshed_words(origin.options),
        )
    return make_sweep_template(origin)


def make_sweep_template(origin: Origin) -> Template:
    """See a mesh of one sweep as a template."""
    sweep, surfaces, factored = origin.sweep, origin.surfaces, origin.factored
    source, n = surfaces.source, factored.structure.n_nodes
    n_layers = factored.structure.n_layers
    points = np.full((n_layers + 1, n, 3), np.nan)
    points[:, np.concatenate(source.loops)] = surfaces.rings
    points[0], points[-1] = source.points, factored.sweep.layer(n_layers)
    flat = points.reshape(-1, 3)
    target_faces = np.full(len(source.quads), sweep.target[0], dtype=np.int64)
    if len(sweep.target) > 1:
        for face, there in sweep.target_faces.items():
            target_faces[source.faces == face] = there
    owned = quads_of_faces(factored, surfaces, target_faces)
    solid = sweep.solid
    return Template(
        factored=factored,
        graph=graph_of(solid),
        roles=_roles(sweep),
        surfaces=surfaces,
        target_faces=target_faces,
        faces={face: meshed_face(quads, flat, solid.faces[face].surface) for face, quads in owned.items()},
        on_edges={
            edge: (nodes, np.clip(solid.edges[edge].curve.project(flat[nodes]), 0.0, 1.0))
            for edge, nodes in _nodes_on_edges(sweep, surfaces, n).items()
        },
        choice=(origin.options.source, origin.options.target),
        residual=origin.options.residual,
    )


def quads_of_faces(factored: FactoredMesh, surfaces: SurfaceMesh, target_faces: IntArray) -> dict[int, IntArray]:
    """Quads on every face, of nodes numbered layer by layer."""
    source, structure = surfaces.source, factored.structure
    n = structure.n_nodes
    ring = np.concatenate(source.loops)
    following = np.concatenate([np.roll(loop, -1) for loop in source.loops])
    layers = np.arange(structure.n_layers)[:, None] * n
    sides = np.stack([ring + layers, following + layers, following + layers + n, ring + layers + n], axis=-1)
    found: dict[int, list[IntArray]] = {}
    for ids, quads in (
        (source.faces, source.quads),
        (target_faces, source.quads + structure.n_layers * n),
        (surfaces.side_faces.reshape(-1), sides.reshape(-1, 4)),
    ):
        for face in np.unique(ids).tolist():
            found.setdefault(face, []).append(quads[ids == face])
    return {face: np.concatenate(pieces) for face, pieces in found.items()}


def _nodes_on_edges(sweep: Sweep, surfaces: SurfaceMesh, n: int) -> dict[int, IntArray]:
    """Nodes inside every edge: on the rings, and on the inner edges of caps."""
    source = surfaces.source
    nodes = np.arange(len(surfaces.rings))[:, None] * n + np.concatenate(source.loops)
    inside = (surfaces.node_edges >= 0) & (surfaces.node_vertices < 0)
    found = {int(e): nodes[inside & (surfaces.node_edges == e)] for e in np.unique(surfaces.node_edges[inside])}
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    last = (len(surfaces.rings) - 1) * n
    for edge, chain in source.edge_nodes.items():
        if edge in on_loops:
            continue
        found[edge] = chain[1:-1]
        target = sweep.target_edges.get(edge, (-1, True))[0]
        if target in surfaces.target_edge_points:
            found[target] = chain[1:-1] + last
    return found


def _roles(sweep: Sweep) -> dict[str, Any]:
    sides = [{"face": s.face, **{name: getattr(s, name) for name in _CHAINS}} for s in sweep.linking_sides]
    return {
        "source": sweep.source,
        "target": sweep.target,
        "linking_sides": sides,
        "source_loops": sweep.source_loops,
        "target_loops": sweep.target_loops,
        "rails": sweep.rails,
        "stations": sweep.stations,
        "spans": sweep.spans,
        "span_lengths": sweep.span_lengths,
        "target_faces": sorted(sweep.target_faces.items()),
        "target_edges": sorted((e, *there) for e, there in sweep.target_edges.items()),
        "score": sweep.score,
        "closed": sweep.closed,
    }


def template_arrays(template: Template) -> dict[str, Any]:
    """The own arrays of a sweep's template, for a numpy archive that holds its factors."""
    surfaces, graph = template.surfaces, template.graph
    text = {
        "graph": {name: getattr(graph, name) for name in Graph.__dataclass_fields__},
        "roles": template.roles,
        "choice": template.choice if _is_plain(template.choice) else (None, None),
        "residual": template.residual,
        "faces": list(template.faces),
        "edges": list(template.on_edges),
        "edge_nodes": list(surfaces.source.edge_nodes),
        "target_edges": list(surfaces.target_edge_points),
    }
    arrays: dict[str, Any] = {
        "text": np.array(json.dumps(text)),
        "source_faces": surfaces.source.faces.astype(np.int32),
        "side_faces": surfaces.side_faces.astype(np.int32),
        "node_edges": surfaces.node_edges.astype(np.int32),
        "node_vertices": surfaces.node_vertices.astype(np.int32),
        "target_faces": template.target_faces.astype(np.int32),
    }
    arrays |= parameter_arrays(template.faces)
    for edge, (nodes, fractions) in template.on_edges.items():
        arrays[f"on_{edge}"], arrays[f"at_{edge}"] = nodes, fractions
    for edge, nodes in surfaces.source.edge_nodes.items():
        arrays[f"chain_{edge}"] = nodes
    for edge, points in surfaces.target_edge_points.items():
        arrays[f"target_{edge}"] = points
    return {PREFIX + name: array for name, array in arrays.items()}


def _is_plain(value: Any) -> bool:
    try:
        json.dumps(value)
    except TypeError:
        return False
    return True


def template_of_arrays(factored: FactoredMesh, arrays: Mapping[str, Any]) -> Template:
    """The template again."""
    own = {name.removeprefix(PREFIX): array for name, array in arrays.items() if name.startswith(PREFIX)}
    text = json.loads(str(own["text"]))
    sweep = factored.sweep
    source = QuadMesh(
        points=sweep.source_points,
        quads=sweep.quads,
        faces=own["source_faces"].astype(np.int64),
        loops=sweep.loops,
        edge_nodes={edge: own[f"chain_{edge}"] for edge in text["edge_nodes"]},
    )
    surfaces = SurfaceMesh(
        source=source,
        rings=sweep.rings,
        side_faces=own["side_faces"].astype(np.int64),
        node_edges=own["node_edges"].astype(np.int64),
        node_vertices=own["node_vertices"].astype(np.int64),
        target_edge_points={edge: own[f"target_{edge}"] for edge in text["target_edges"]},
    )
    target_faces = own["target_faces"].astype(np.int64)
    n, n_layers = factored.structure.n_nodes, factored.structure.n_layers
    points = np.full((n_layers + 1, n, 3), np.nan)
    points[:, np.concatenate(sweep.loops)] = sweep.rings
    points[0], points[-1] = sweep.source_points, sweep.layer(n_layers)
    flat = points.reshape(-1, 3)
    quads = quads_of_faces(factored, surfaces, target_faces)
    faces = faces_of_arrays({face: quads[face] for face in text["faces"]}, flat, own)
    return Template(
        factored=factored,
        graph=Graph(**{name: tuples(value) for name, value in text["graph"].items()}),
        roles=text["roles"],
        surfaces=surfaces,
        target_faces=target_faces,
        faces=faces,
        on_edges={edge: (own[f"on_{edge}"], own[f"at_{edge}"]) for edge in text["edges"]},
        choice=tuple(text["choice"]),
        residual=text["residual"],
    )


def linking_side(side: Mapping[str, Any], face: int, directed: Any) -> LinkingSide:
    """A linking side with its chains run through `directed`, which takes an edge of the template to one of the part."""
    chains = {name: tuple(directed(edge, forward) for edge, forward in side[name]) for name in _CHAINS}
    return LinkingSide(face=face, **chains)
