"""The same mesh on another part, where it is of several cells, of columns, or of several solids.

Place in the flow: :mod:`.like` comes here where the mesh is not of one sweep.

Method: what two variants of a part have in common are the faces and edges of the model, and not the cuts through it. So
nodes on edges keep their fractions of arc length, every face of the model is carried by the map of its boundary
(:mod:`cadsweep.projection.carried`), and all that is inside, nodes on cuts included, by the map of the whole boundary
(:mod:`cadsweep.projection.inside`). Where a hex is invalid or far worse than there, smoothing is tried; where it stays
invalid, the part is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces
from ..brep import Part
from ..errors import CadError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..projection.carried import carry_face
from ..projection.inside import carry_inside
from ..quality import scaled_jacobians
from .cells_accuracy import boundary_distance
from .cells_template import CellsTemplate
from .graphs import FirstIds, first_ids, graph_of_part
from .matching import Match, match_graphs
from .refusing import carried_refusal, poor_carried
from .run import Run
from .several import checked_cells
from .subsets import chosen_solids, separated

STEPS = 4
"""Steps in which a boundary that moves far is followed; more of them mended no more of what folded."""


def cells_like(part: Part, template: CellsTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """Mesh a part as another one of several cells is meshed.

    Raises
    ------
    CadError
        The parts do not correspond; names the first face without a partner.
    InvertedHexError
        The mesh carried here is not valid, and smoothing does not mend it.
    """
    part = meshed_solids(part, template.solids)
    with run.stage("recognition"):
        match = match_graphs(template.graph, graph_of_part(part))
    starts = first_ids(part)
    with run.stage("surface"):
        known, places = _boundary(template, match, part, starts)
    with run.stage("projection"):
        points = _carried(template, known, places)
    joined = _joined(template, match, part, starts, points)
    names = _names(template, match, starts)
    old = template.mesh
    info: dict[str, Any] = {
        **{key: value for key, value in old.info.items() if key in ("sweeps", "colors")},
        "part": part.name,
        "material": next((m.material for m in part.models if m.material), None) if len(part.models) == 1 else None,
        "materials": {m.name: m.material for m in part.models if m.material},
        "cad_volume": sum(model.volume for model in part.models) * part.scale**3,
        "names": dict(part.names),
        "distance": boundary_distance(part, joined, names) * part.scale,
        "notes": [*part.notes, f"meshed like '{old.info.get('part', 'another part')}'"],
        "seconds": run.seconds,
    }

    def make(own: JoinedMesh, info: dict[str, Any]) -> HexMesh:
        return HexMesh(
            points=part.to_model(own.points),
            hexes=old.hexes,
            boundaries=dict(old.boundaries),
            interfaces=dict(old.interfaces),
            parts=dict(old.parts),
            info=info,
        )

    mesh = checked_cells(
        part, joined, names, options, run, make=make, info=info, smooth_below=poor_carried(template.points, old.hexes)
    )
    report = mesh.info["quality"]
    if not report.valid and not options.allow_inverted:
        raise carried_refusal(report, part.name)
    return mesh


def _carried(template: CellsTemplate, known: IntArray, places: FloatArray) -> FloatArray:
    """All nodes; where folded hexes would come of it, they go to their places in steps."""
    hexes = template.mesh.hexes[:, :8]
    points = carry_inside(template.points, hexes, known, places)
    if scaled_jacobians(points, hexes).min() > 0.0:
        return points
    return carry_inside(template.points, hexes, known, places, n_steps=STEPS)


def meshed_solids(part: Part, wanted: dict[str, Any]) -> Part:
    """The solids that a mesh was made of, sharing what they shared there."""
    part = chosen_solids(part, only=wanted["only"], skip=wanted["skip"])
    return separated(part) if wanted["interfaces"] == "separate" else part


def _boundary(template: CellsTemplate, match: Match, part: Part, starts: FirstIds) -> tuple[IntArray, FloatArray]:
    """The nodes on all faces, and their places, working units."""
    points = np.full_like(template.points, np.nan)
    corners = np.concatenate([solid.vertices for solid in part.solids])
    curves = [edge.curve for solid in part.solids for edge in solid.edges]
    surfaces = [face.surface for solid in part.solids for face in solid.faces]
    done = {other for own in template.graph.shared_edges for other in own[1:]}
    for edge, (nodes, fractions) in template.edges.items():
        if edge not in done:
            there, same = match.edges[edge]
            own = np.isfinite(fractions)
            at = fractions[own] if same else 1.0 - fractions[own]
            points[nodes[own]] = curves[there].evaluate(at)
    for vertex, node in enumerate(template.vertices.tolist()):
        if node >= 0:
            points[node] = corners[match.vertices[vertex]]
    for face, meshed in template.faces.items():
        loops = meshed.loops()
        known = meshed.nodes[np.concatenate(loops)]
        if np.isnan(points[known]).any():
            label = template.graph.face_labels[face]
            raise CadError(f"the parts do not correspond: {label} has an outline that is on no edge")
        points[meshed.nodes] = carry_face(meshed, points[known], loops, surfaces[match.faces[face]])
    known = np.unique(template.quads)
    return known, points[known]


def _place(starts: tuple[int, ...], number: int) -> tuple[int, int]:
    """Solid, and id there, of an id that runs through all solids."""
    solid = int(np.searchsorted(starts, number, side="right")) - 1
    return solid, number - starts[solid]


def _joined(template: CellsTemplate, match: Match, part: Part, starts: FirstIds, points: FloatArray) -> JoinedMesh:
    """The mesh in terms of the part's solids, which are its cells here."""
    faces = np.array([match.faces[f] for f in range(len(template.graph.loops))], dtype=np.int64)[template.quad_faces]
    cells = np.searchsorted(starts.faces, faces, side="right") - 1
    edge_nodes = {}
    for edge, (nodes, _) in template.edges.items():
        there, same = match.edges[edge]
        solid, own = _place(starts.edges, there)
        edge_nodes[int(part.solids[solid].edge_keys[own])] = nodes if same else nodes[::-1]
    solids = np.array([_place(starts.faces, match.faces[face])[0] for face in template.first_faces], dtype=np.int64)
    return JoinedMesh(
        points=points,
        hexes=template.mesh.hexes,
        hex_cells=solids[template.hex_solids],
        quads=template.quads,
        quad_cells=cells,
        quad_faces=faces - np.array(starts.faces)[cells],
        edge_nodes=edge_nodes,
    )


def _names(template: CellsTemplate, match: Match, starts: FirstIds) -> NamedFaces:
    """What the part's faces are called: as their partners."""

    def there(face: int) -> tuple[int, int]:
        return _place(starts.faces, match.faces[face])

    return NamedFaces(
        outside={there(face): names for face, names in template.outside.items()},
        between={there(face): names for face, names in template.between.items()},
        first={there(face): face in template.first for face in template.between},
    )
