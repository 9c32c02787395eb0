"""The mesh of one sweep on another part.

Place in the flow: :mod:`.like` comes here where the mesh is of one sweep.

Method. The part is made ready as ever; then its faces, edges and vertices are paired with those of the mesh's part
(:mod:`.matching`), and what the sweep was there it is here. Nodes on edges keep their fractions of arc length. Every
face, cap or side, is then carried by the least-squares affine map of its boundary in the parameters of its surface,
the residual included (:mod:`cadsweep.projection.carried`). Inner layers are placed by the factored sweep with the
options of the mesh; what smoothing moved there is moved here by the local linear part of the map between the rings.
All of this is a smooth function of the part. All checks are made; where a hex is invalid or far worse than it was
there, smoothing is tried; where it stays invalid, the part is refused.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..blocks.block import FactoredMesh
from ..blocks.reference import make_reference, volume_doubt
from ..brep import Part
from ..errors import CadError, CadSweepError, InputError, NotSweepableError
from ..mesh import HexMesh, QuadMesh, SurfaceMesh
from ..options import SweepOptions
from ..projection import project_layers
from ..projection.carried import carry_face
from ..projection.target import sweep_normals, worst_corner
from ..quality import check_mesh
from ..quality.deviation import measure_deviation
from ..surface.spacing import fit_linear_parts
from ..sweep import Sweep
from .attempts import open_and_find
from .candidates import smoothed, volume_notes
from .graphs import graph_of
from .making import raised
from .matching import Match, match_graphs
from .origin import Origin
from .parts import only_solid
from .refusing import POOR_CARRIED, carried_refusal, poor_carried
from .run import Run
from .template import Template, linking_side


def sweep_like(part: Part, template: Template, options: SweepOptions, run: Run) -> HexMesh:
    """Mesh a part as another one is meshed by one sweep.

    Raises
    ------
    CadError
        The parts do not correspond; names the first face or edge without a partner.
    InvertedHexError
        The mesh carried here is not valid, and smoothing does not mend it.
    """
    how = template.factored.sweep
    options = replace(options, functional=how.functional, strategy=how.strategy)
    if len(part.solids) != 1:
        raise CadError(
            f"the parts do not correspond: the mesh's part is one solid, and '{part.name}' has {len(part.solids)}; "
            "choose one with part="
        )
    with run.stage("recognition"):
        part, match = _paired(part, template)
        sweep = _same_sweep(part, template, match)
    with run.stage("surface"):
        points = _boundary(template, match, sweep)
        surfaces = _surfaces(template, match, points)
    with run.stage("projection"):
        factored = _factored(template, part, surfaces, points, run)
        faces = np.array([match.faces[face] for face in template.target_faces.tolist()], dtype=np.int64)
        deviation = measure_deviation(sweep, surfaces, points[-1], faces)
        factored = replace(factored, info={**factored.info, "distance": deviation.distance * part.scale})
    origin = Origin(part=part, sweep=sweep, surfaces=surfaces, factored=factored, options=options)
    return _finished(origin, template, run)


def _paired(part: Part, template: Template) -> tuple[Part, Match]:
    """The part as it is swept, and the partners of the template's entities in it."""
    ready = [part]
    # It needs no sweep of its own, and the user's choice of caps has its answer in the template.
    with suppress(NotSweepableError, InputError):
        ready.insert(0, open_and_find(part, *template.choice)[0])
    first: CadSweepError | None = None
    for one in ready:
        try:
            return one, match_graphs(template.graph, graph_of(only_solid(one)))
        except CadError as error:
            first = first or error
    assert first is not None
    raise first


def _same_sweep(part: Part, template: Template, match: Match) -> Sweep:
    """The template's sweep on the part's faces and edges."""
    roles, faces = template.roles, match.faces

    def directed(edge: int, forward: bool) -> tuple[int, bool]:
        there, same = match.edges[edge]
        return there, forward == same

    def chains(loops: Any) -> Any:
        return tuple(tuple(directed(edge, forward) for edge, forward in loop) for loop in loops)

    def target(edge: int, there: int, forward: bool) -> tuple[int, tuple[int, bool]]:
        own, same = match.edges[edge]
        partner, same_there = match.edges[there]
        return own, (partner, forward == (same == same_there))

    sweep = Sweep(
        solid=only_solid(part),
        source=tuple(faces[f] for f in roles["source"]),
        target=tuple(faces[f] for f in roles["target"]),
        linking_sides=tuple(linking_side(side, faces[side["face"]], directed) for side in roles["linking_sides"]),
        source_loops=chains(roles["source_loops"]),
        target_loops=chains(roles["target_loops"]),
        rails=tuple(match.edges[edge][0] for edge in roles["rails"]),
        stations=tuple(tuple(match.edges[edge][0] for edge in ring) for ring in roles["stations"]),
        spans=tuple(tuple(tuple(match.edges[edge][0] for edge in span) for span in spans) for spans in roles["spans"]),
        span_lengths=tuple(tuple(lengths) for lengths in roles["span_lengths"]),
        target_faces={faces[f]: faces[t] for f, t in roles["target_faces"]},
        target_edges=dict(target(*row) for row in roles["target_edges"]),
        score=roles["score"],
    )
    if sweep.closed != roles["closed"]:
        raise CadError("the parts do not correspond: one is a closed ring, and the other is not")
    return sweep


def _boundary(template: Template, match: Match, sweep: Sweep) -> FloatArray:
    """Places of all nodes on the boundary (n_layers + 1, n, 3), working units; NaN inside."""
    solid = sweep.solid
    n, n_layers = template.factored.structure.n_nodes, template.n_layers
    points = np.full(((n_layers + 1) * n, 3), np.nan)
    surfaces = template.surfaces
    nodes = np.arange(n_layers + 1)[:, None] * n + np.concatenate(surfaces.source.loops)
    on_vertex = surfaces.node_vertices >= 0
    partners = np.array([match.vertices.get(v, -1) for v in range(len(template.graph.vertices))])
    points[nodes[on_vertex]] = solid.vertices[partners[surfaces.node_vertices[on_vertex]]]
    for edge, chain in surfaces.source.edge_nodes.items():
        for vertex, node in zip(template.graph.ends[edge], chain[[0, -1]].tolist(), strict=True):
            points[node] = solid.vertices[match.vertices[vertex]]
    for edge, there, forward in template.roles["target_edges"]:
        if edge in surfaces.source.edge_nodes and there in surfaces.target_edge_points:
            ends = surfaces.source.edge_nodes[edge][[0, -1]] + n_layers * n
            for vertex, node in zip(template.graph.ends[there], ends[:: 1 if forward else -1].tolist(), strict=True):
                points[node] = solid.vertices[match.vertices[vertex]]
    for edge, (own, fractions) in template.on_edges.items():
        there, same = match.edges[edge]
        points[own] = solid.edges[there].curve.evaluate(fractions if same else 1.0 - fractions)
    roles, along = template.roles, dict[int, tuple[FloatArray | None, float]]()
    answers = dict(roles["target_faces"])
    if len(roles["source"]) == len(roles["target"]) == 1:
        answers = {roles["source"][0]: roles["target"][0]}
    for face, meshed in sorted(template.faces.items(), key=lambda item: item[0] not in answers):
        loops = meshed.loops()
        known = meshed.nodes[np.concatenate(loops)]
        if np.isnan(points[known]).any():
            label = template.graph.face_labels[face]
            raise CadError(f"the parts do not correspond: {label} has an outline that is on no edge")
        boundary, surface = points[known], solid.faces[match.faces[face]].surface
        step, good = along.get(face, (None, 1.0))
        carried = carry_face(meshed, boundary, loops, surface, shift=step, good=good)
        points[meshed.nodes] = carried
        if face in answers:
            # Where the source is relaxed, the target goes along: apart, the two would twist the layers between them.
            step = carried - carry_face(meshed, boundary, loops, surface, relax=False)
            target = template.faces[answers[face]]
            if step.any() and len(target.nodes) == len(step):
                there = target.nodes[np.concatenate(loops)]
                linear = fit_linear_parts(boundary, points[there][None])[0]
                normals = sweep_normals(carried, meshed.quads, surface)
                along[answers[face]] = step @ linear.T, worst_corner(carried, meshed.quads, normals)
    layers = points.reshape(n_layers + 1, n, 3)
    if sweep.closed:
        layers[-1] = layers[0]
    return layers


def _surfaces(template: Template, match: Match, points: FloatArray) -> SurfaceMesh:
    """The boundary's mesh, with the ids of the part's faces, edges and vertices."""
    old = template.surfaces
    faces = np.full(len(template.graph.loops) + 1, -1, dtype=np.int64)
    edges = np.full(len(template.graph.ends) + 1, -1, dtype=np.int64)
    vertices = np.full(len(template.graph.vertices) + 1, -1, dtype=np.int64)
    faces[list(match.faces)] = list(match.faces.values())
    edges[list(match.edges)] = [there for there, _ in match.edges.values()]
    vertices[list(match.vertices)] = list(match.vertices.values())

    def run(edge: int, chain: Any) -> tuple[int, Any]:
        there, same = match.edges[edge]
        return there, chain if same else chain[::-1]

    on_target: dict[int, FloatArray] = {}
    for edge, there, forward in template.roles["target_edges"]:
        if there in old.target_edge_points:
            chain = points[-1][old.source.edge_nodes[edge]]
            on_target.update([run(there, chain if forward else chain[::-1])])
    return SurfaceMesh(
        source=QuadMesh(
            points=points[0].copy(),
            quads=old.source.quads,
            faces=faces[old.source.faces],
            loops=old.source.loops,
            edge_nodes=dict(run(edge, chain) for edge, chain in old.source.edge_nodes.items()),
        ),
        rings=np.ascontiguousarray(points[:, np.concatenate(old.source.loops)]),
        side_faces=faces[old.side_faces],
        node_edges=edges[old.node_edges],
        node_vertices=vertices[old.node_vertices],
        target_edge_points=on_target,
    )


def _factored(template: Template, part: Part, surfaces: SurfaceMesh, points: FloatArray, run: Run) -> FactoredMesh:
    old, solid = template.factored, only_solid(part)
    how = old.sweep
    placed = project_layers(
        points[0],
        how.quads,
        surfaces.rings,
        loops=how.loops,
        functional=how.functional,
        strategy=how.strategy,
        target_points=points[-1],
        residual=template.residual,
    )
    moved = _moved(old, placed.points, surfaces.rings)
    info = {
        **{key: value for key, value in old.info.items() if key in ("sweeps", "colors")},
        "part": part.name,
        "material": solid.material,
        "cad_volume": solid.volume * part.scale**3,
        "cad_volume_doubt": volume_doubt(solid) * part.scale**3,
        "names": dict(part.names),
        "notes": [*part.notes, f"meshed like '{old.info.get('part', 'another part')}'"],
        "seconds": run.seconds,
    }
    return replace(old, sweep=placed, moved_points=moved, scale=part.scale, offset=part.offset, info=info)


def _moved(old: FactoredMesh, place: Any, rings: FloatArray) -> FloatArray:
    """Where the nodes go that smoothing moved in the template: by as much, in the map between the rings."""
    moved = old.moved_points.copy()
    n, n_layers = old.structure.n_nodes, old.structure.n_layers
    layers, nodes = np.divmod(old.moved_nodes, n)
    for k in np.unique(layers).tolist():
        chosen = layers == k
        near = slice(max(0, min(k - 1, n_layers - 2)), max(k + 2, 3))
        source, image = old.sweep.rings[near].reshape(-1, 3), rings[near].reshape(1, -1, 3)
        linear = fit_linear_parts(source, image)[0]
        shift = moved[chosen] - old.sweep.layer(k)[nodes[chosen]]
        moved[chosen] = place(slice(k, k + 1))[0][nodes[chosen]] + shift @ linear.T
    return moved


def _finished(origin: Origin, template: Template, run: Run) -> HexMesh:
    """The mesh, checked as ever, and smoothed where it is invalid or far worse than the template."""
    part, sweep, options = origin.part, origin.sweep, origin.options
    factored = origin.factored
    with run.stage("assembly"):
        mesh = factored.to_mesh()
    reference = make_reference(part, sweep)
    with run.stage("quality"):
        report = check_mesh(mesh, cad=reference)
    poor = report.min_scaled_jacobian < POOR_CARRIED and report.min_scaled_jacobian < poor_carried(
        template.factored.to_mesh().points, mesh.hexes
    )
    if options.smoothing and (poor or not report.valid):
        with run.stage("smoothing"):
            factored = smoothed(factored)
            mesh = factored.to_mesh()
            report = check_mesh(mesh, cad=reference)
    if options.order > 1 and (report.valid or options.allow_inverted):
        with run.stage(f"order {options.order}"):
            mesh = raised(mesh, replace(origin, factored=factored))
            report = check_mesh(mesh, cad=reference)
    if not report.valid and not options.allow_inverted:
        raise carried_refusal(report, part.name)
    factored = factored.noted(volume_notes(report, factored))
    origin = replace(origin, factored=factored)
    return replace(mesh, origin=origin, info={**factored.info, "quality": report})
