"""What another part's mesh must know of a mesh of several cells to be like it: arrays and names alone.

Place in the flow: made from a :class:`~.origin.CellsOrigin`, or read from a file; :mod:`.cells_like` carries it to
another part. :mod:`.template` is the same for a mesh of one sweep. Ids of faces, edges and vertices run through all
solids of the model (:func:`~.graphs.first_ids`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.cell_files import cells_as_arrays, cells_from_arrays
from ..blocks.cells import CellBlocks
from ..blocks.finish import by_face, to_hex_mesh
from ..brep import Edge, Part, Units
from ..mesh import HexMesh
from ..options import SweepOptions
from ..projection.carried import MeshedFace, meshed_face
from .graphs import Graph, first_ids, graph_of_part
from .model_faces import find_on_model
from .origin import CellsOrigin

_UV, _FACTORS, _SCALE = "uv_", "factors_", "scale"


class FactoredCells(NamedTuple):
    """Cells as factors, and the units of the model that their nodes are brought to."""

    cells: CellBlocks
    units: Units

    def placed(self) -> tuple[FloatArray, FloatArray, IntArray]:
        """Nodes in working and in model units, and hexahedra."""
        joined = self.cells.joined()
        return joined.points, self.units.to_model(joined.points), joined.hexes


@dataclass(frozen=True, kw_only=True, eq=False)
class CellsTemplate:
    """A mesh of several cells that others can be made like.

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
    first_faces : tuple of int
        A face of every solid.
    first : tuple of int
        Faces of the solids that the names of their interfaces begin with.
    solids : dict of str to Any
        What of the model is meshed, and how: ``only``, ``skip``, ``interfaces``.
    factored : FactoredCells or None
        What `points` and the mesh's nodes and hexes are multiplied out of, where it is known.
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
    factored: FactoredCells | None = None


def make_cells_template(origin: CellsOrigin, mesh: HexMesh) -> CellsTemplate:
    """See a mesh of cells as a template.

    Raises
    ------
    InputError
        Its nodes do not follow the edges of the model.
    """
    model, joined, names = origin.model, origin.joined, origin.names
    starts = first_ids(model)
    solid_of = {owner: solid for solid, owner in enumerate(model.owners)}
    places = [(place, quads) for place, quads in by_face(joined) if names.of(place)]
    quads, faces, edges = [], [], dict[int, tuple[IntArray, FloatArray]]()
    vertices = np.full(starts.vertices[-1], -1, dtype=np.int64)
    outside, between, first = dict[int, tuple[str, ...]](), dict[int, tuple[str, ...]](), list[int]()
    for owner, j in sorted(solid_of.items()):
        own = [(place, rows) for place, rows in places if origin.part.owners[place[0]] == owner]
        every = np.concatenate([rows for _, rows in own])
        solid = model.solids[j]
        found = find_on_model(solid, joined.points, every)
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
            else:
                between |= dict.fromkeys(pieces, names.between[place])
                first += pieces if names.first[place] else []
            row += len(rows)
    ids, rows = np.concatenate(faces), np.concatenate(quads)
    plain = to_hex_mesh(origin.part, joined, names, {k: v for k, v in mesh.info.items() if k != "quality"})
    return CellsTemplate(
        points=joined.points,
        mesh=plain,
        graph=graph_of_part(model),
        hex_solids=np.array([solid_of[owner] for owner in origin.part.owners], dtype=np.int64)[joined.hex_cells],
        quads=rows,
        quad_faces=ids,
        faces=_meshed(model, joined.points, rows, ids, graph_of_part(model)),
        edges=edges,
        vertices=vertices,
        outside=outside,
        between=between,
        first_faces=starts.faces[:-1],
        first=tuple(sorted(set(first))),
        solids=meshed_words(origin.options),
        factored=_factored(origin),
    )


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
    if not isinstance(origin.cells, CellBlocks):
        return None
    first = origin.cells.joined()
    if not np.array_equal(first.hexes, origin.joined.hexes):
        return None
    moved = np.flatnonzero((first.points != origin.joined.points).any(axis=1))
    cells = replace(origin.cells, moved_nodes=moved, moved_points=origin.joined.points[moved])
    return FactoredCells(cells, Units(origin.part.scale, origin.part.offset))


def meshed_words(options: SweepOptions) -> dict[str, Any]:
    """Which solids are meshed, and whether they share what they touch in."""
    return {
        "only": None if options.only is None else list(options.only),
        "skip": None if options.skip is None else list(options.skip),
        "interfaces": options.interfaces,
    }


def _meshed(model: Part, points: FloatArray, quads: IntArray, ids: IntArray, graph: Graph) -> dict[int, MeshedFace]:
    """Every face with its quads, those between two solids once."""
    surfaces = [face.surface for solid in model.solids for face in solid.faces]
    twice = {max(pair) for pair in graph.shared_faces}
    return {
        face: meshed_face(quads[ids == face], points, surfaces[face])
        for face in np.unique(ids).tolist()
        if face not in twice
    }


def parameter_arrays(faces: Mapping[int, MeshedFace]) -> dict[str, FloatArray]:
    """Parameters of meshed faces by name, for a numpy archive; of those that have them."""
    return {f"{_UV}{face}": meshed.uv for face, meshed in faces.items() if meshed.uv is not None}


def faces_of_arrays(quads: Mapping[int, IntArray], points: FloatArray, own: Mapping[str, Any]) -> dict[int, MeshedFace]:
    """Meshed faces again, from their quads and the arrays of :func:`parameter_arrays`."""
    faces = {}
    for face, of_face in quads.items():
        nodes, local = np.unique(of_face, return_inverse=True)
        faces[face] = MeshedFace(
            nodes=nodes, quads=local.reshape(-1, 4), points=points[nodes], uv=own.get(f"{_UV}{face}")
        )
    return faces


def mesh_arrays(mesh: HexMesh, *, placed: bool = True) -> dict[str, Any]:
    """A mesh of order 1 as arrays, for a numpy archive; without nodes and hexes where it is not `placed`."""
    named = {kind: getattr(mesh, kind) for kind in ("boundaries", "interfaces", "parts")}
    text = {
        "names": {kind: list(own) for kind, own in named.items()},
        "info": {key: value for key, value in mesh.info.items() if key not in ("quality", "coarse_nodes")},
    }
    rows = {f"{kind}_{j}": ids for kind, own in named.items() for j, ids in enumerate(own.values())}
    rows |= {f"parts_{j}": runs_of(ids - np.arange(len(ids))) for j, ids in enumerate(mesh.parts.values())}
    own = {"model_points": mesh.points, "hexes": mesh.hexes} if placed else {}
    return {"mesh": np.array(json.dumps(text)), **own, **rows}


def mesh_of_arrays(own: Mapping[str, Any]) -> HexMesh:
    """The mesh again."""
    factored = factored_of_arrays(own)
    points, hexes = (own["model_points"], own["hexes"]) if factored is None else factored.placed()[1:]
    return _named(own, points, hexes)


def _named(own: Mapping[str, Any], points: FloatArray, hexes: IntArray) -> HexMesh:
    text = json.loads(str(own["mesh"]))
    named: dict[str, Any] = {
        kind: {name: own[f"{kind}_{j}"] for j, name in enumerate(names)} for kind, names in text["names"].items()
    }
    for name, ids in named["parts"].items():
        if ids.ndim == 2:  # older files have the hexes themselves
            values = values_of_runs(ids)
            named["parts"][name] = values + np.arange(len(values))
    return HexMesh(points=points, hexes=hexes, info=text["info"], **named)


def runs_of(values: IntArray) -> IntArray:
    """Rows (value, how often it comes) of values in a row: a few rows, where millions of hexes are numbered in turn."""
    starts = np.flatnonzero(np.diff(values, prepend=values[:1] - 1))
    return np.stack([values[starts], np.diff(starts, append=len(values))], axis=1)


def values_of_runs(runs: IntArray) -> IntArray:
    """The values again."""
    return np.repeat(runs[:, 0], runs[:, 1])


def factored_of_arrays(own: Mapping[str, Any]) -> FactoredCells | None:
    """The factors of cells, where a file has them."""
    if _SCALE not in own:
        return None
    units = Units(float(own[_SCALE]), own["offset"])
    cells = {name.removeprefix(_FACTORS): array for name, array in own.items() if name.startswith(_FACTORS)}
    return FactoredCells(cells_from_arrays(cells), units)


def cells_arrays(template: CellsTemplate) -> dict[str, Any]:
    """A template as arrays, for a numpy archive."""
    text = {
        "graph": {name: getattr(template.graph, name) for name in Graph.__dataclass_fields__},
        "outside": sorted(template.outside.items()),
        "between": sorted(template.between.items()),
        "first_faces": template.first_faces,
        "first": template.first,
        "solids": template.solids,
        "faces": list(template.faces),
        "edges": list(template.edges),
    }
    factored = template.factored
    arrays: dict[str, Any] = {
        **mesh_arrays(template.mesh, placed=factored is None),
        "text": np.array(json.dumps(text)),
        "hex_solids": runs_of(template.hex_solids),
        "quads": template.quads,
        "quad_faces": template.quad_faces,
        "vertices": template.vertices,
    }
    if factored is None:
        arrays["points"] = template.points
    else:
        arrays |= {_FACTORS + name: array for name, array in cells_as_arrays(factored.cells).items()}
        arrays |= {_SCALE: np.array(factored.units.scale), "offset": factored.units.offset}
    arrays |= parameter_arrays(template.faces)
    for edge, (nodes, fractions) in template.edges.items():
        arrays[f"on_{edge}"], arrays[f"at_{edge}"] = nodes, fractions
    return arrays


def cells_of_arrays(own: Mapping[str, Any]) -> CellsTemplate:
    """The template again."""
    text = json.loads(str(own["text"]))
    quads, ids, hex_solids = own["quads"], own["quad_faces"], own["hex_solids"]
    factored = factored_of_arrays(own)
    if factored is None:
        points, mesh = own["points"], mesh_of_arrays(own)
    else:
        points, placed, hexes = factored.placed()
        mesh = _named(own, placed, hexes)
    faces = faces_of_arrays({face: quads[ids == face] for face in text["faces"]}, points, own)
    return CellsTemplate(
        points=points,
        mesh=mesh,
        graph=Graph(**{name: tuples(value) for name, value in text["graph"].items()}),
        hex_solids=values_of_runs(hex_solids) if hex_solids.ndim == 2 else hex_solids,
        quads=quads,
        quad_faces=ids,
        faces=faces,
        edges={edge: (own[f"on_{edge}"], own[f"at_{edge}"]) for edge in text["edges"]},
        vertices=own["vertices"],
        outside={face: tuple(names) for face, names in text["outside"]},
        between={face: tuple(names) for face, names in text["between"]},
        first_faces=tuple(text["first_faces"]),
        first=tuple(text["first"]),
        solids=text["solids"],
        factored=factored,
    )


def tuples(value: Any) -> Any:
    """Lists of lists as tuples of tuples, as they were before JSON."""
    return tuple(tuples(one) for one in value) if isinstance(value, list) else value
