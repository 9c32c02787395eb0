"""The same mesh on another part: equal connectivity, names and numbering, nodes that move smoothly with the part.

Place in the flow: ``sweep_mesh(part, like=mesh)`` comes here instead of looking for a sweep of its own.

Method: what two variants of a part have in common are the faces and edges of the model, and not the cuts through it. So
its faces, edges and vertices are paired with those of the mesh's part (:mod:`.matching`); nodes on edges keep their
fractions of arc length, and every face is carried by the map of its boundary (:mod:`cadsweep.projection.carried`). All
that is inside, nodes on cuts included, follows the map of the whole boundary (:mod:`cadsweep.projection.inside`). All
of this is a smooth function of the part. All checks are made; where a hex is invalid or far worse than it was there,
smoothing is tried; where it stays invalid, the part is refused.

Not handled: parts whose faces do not pair.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from ... import cad
from ...arrays import FloatArray, IntArray
from ...blocks.cells import CellBlocks, SweptCell
from ...blocks.joined import JoinedMesh
from ...blocks.naming import NamedFaces
from ...brep import Part, Units, volume_doubt
from ...errors import CadError, CadSweepError, InputError, NotSweepableError
from ...mesh import HexMesh
from ...options import SweepOptions
from ...projection import project_layers
from ...projection.carried import carry_face
from ...projection.inside import carry_inside
from ...projection.target import sweep_normals, worst_corner
from ...quality import scaled_jacobians
from ...surface.spacing import fit_linear_parts
from ..attempts import open_and_find
from ..complexes.checking import checked_cells
from ..complexes.groups import make_group, put_together
from ..complexes.subsets import chosen_solids, separated, subset, touching_groups
from ..complexes.swept import at_one_place
from ..nearness.measured import boundary_distance
from ..origin import CellsOrigin
from ..refusing import carried_refusal, poor_carried
from ..routes import open_part
from ..run import Run
from ..tips import HIGHER_NOTE, bridged, flattened_higher
from .graphs import FirstIds, first_ids, graph_of_part
from .matching import Match, match_graphs
from .refinement import refined
from .template import AnyTemplate, DesignTemplate, GroupsTemplate, Template, make_template
from .template_files import load_template

_UNMOVED = 1e-9
"""Part of a section by which smoothing moves nodes that it does not move."""

STEPS = 4
"""Steps in which a boundary that moves far is followed; more of them mended no more of what folded."""

OWN = (
    *(
        "size",
        "tolerance",
        "layers",
        "bias",
        "fractions",
        "sizes",
        "counts",
        "rail_layers",
        "biases",
        "wall_layers",
        "periodic",
        "local_sizes",
    ),
    *("cuts", "decompose", "decompose_time", "fitted", "only", "skip", "interfaces"),
)
"""Options that a mesh brings along, so that none may be asked for besides."""


def as_template(like: Any) -> AnyTemplate:
    """A mesh, a file of factors or a template as a template.

    Raises
    ------
    InputError
        It is none of these, or a mesh that does not know its CAD model.
    """
    if isinstance(like, AnyTemplate):
        return like
    if isinstance(like, HexMesh):
        return make_template(like, "a mesh to be like")
    if isinstance(like, str | PathLike):
        return load_template(like)
    raise InputError(f"like must be a mesh or a .sweep.npz file, not {type(like).__name__}")


def mesh_like(source: Any, template: AnyTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """Mesh a part as another one is meshed.

    Raises
    ------
    CadError
        The parts do not correspond; names the first face or edge without a partner.
    InvertedHexError
        The mesh carried here is not valid, and smoothing does not mend it.
    InputError
        Options that the mesh brings along are asked for.
    """
    for name in OWN:
        if getattr(options, name) not in (None, SweepOptions.__dataclass_fields__[name].default):
            raise InputError(f"like brings its own {name}; leave that out")
    part = open_part(source, options, run)
    return refined(_part_like(part, template, replace(options, params=None, part=None), run), options, run)


def _part_like(part: Part, template: AnyTemplate, options: SweepOptions, run: Run) -> HexMesh:
    if isinstance(template, GroupsTemplate):
        return _groups_like(part, template, options, run)
    part = _meshed_solids(part, template.solids)
    if any(note.startswith(HIGHER_NOTE) for note in template.mesh.info["notes"]):
        part = flattened_higher(part, options)
    if isinstance(template, DesignTemplate):
        return _design_like(part, template, options, run)
    n_solids = len(template.first_faces)
    if len(part.solids) != n_solids:
        raise CadError(
            f"the parts do not correspond: the mesh's part has {n_solids} solid{'s' * (n_solids > 1)}, and "
            f"'{part.name}' has {len(part.solids)}; choose with part= or only="
        )
    if any(note.startswith(cad.TIPS_NOTE) for note in template.mesh.info["notes"]):
        part = bridged(part, options)
    with run.stage("recognition"):
        part, match = _paired(part, template)
        if template.twins:
            kept = {f for e in template.twins.values() for f in part.solids[0].edges[match.edges[e][0]].faces}
            part = replace(part, solids=(at_one_place(part.solids[0], kept),))
    starts = first_ids(part)
    for face in template.patches:
        cell, own = _place(starts.faces, match.faces[face])
        if not part.solids[cell].faces[own].former:
            label = part.solids[cell].faces[own].label()
            raise CadError(
                f"the parts do not correspond: {label} has no patches, as of marks, and has in the mesh's part"
            )
    with run.stage("surface"):
        known, places = _boundary(template, match, part)
    with run.stage("projection"):
        points, cells = _carried(template, known, places)
    joined, names = _joined(template, match, part, starts, points), _names(template, match, starts)
    origin = CellsOrigin(
        model=part,
        part=part,
        joined=joined,
        names=names,
        options=options,
        cells=cells,
        is_swept=template.is_swept,
    )
    old = template.mesh
    info: dict[str, Any] = {
        **{key: value for key, value in old.info.items() if key in ("sweeps", "colors", "way")},
        "part": part.name,
        "material": next((m.material for m in part.models if m.material), None) if len(part.models) == 1 else None,
        "materials": {m.name: m.material for m in part.models if m.material},
        "cad_volume": sum(model.volume for model in part.models) * part.scale**3,
        "cad_volume_doubt": sum(volume_doubt(solid) for solid in part.solids) * part.scale**3,
        "names": dict(part.names),
        "distance": boundary_distance(part, joined, names) * part.scale,
        "notes": [*part.notes, f"meshed like '{old.info.get('part', 'another part')}'"],
        "seconds": run.seconds,
    }

    def make(own: JoinedMesh, info: dict[str, Any]) -> HexMesh:
        return replace(old, points=part.to_model(own.points), info=info)

    mesh = checked_cells(
        part,
        joined,
        names,
        options,
        run,
        make=make,
        info=info,
        smooth_below=poor_carried(template.points, old.hexes),
        references=origin.references,
    )
    report = mesh.info["quality"]
    if not report.valid and not options.allow_inverted:
        raise carried_refusal(report, part.name)
    return replace(mesh, origin=replace(origin, joined=mesh.origin.joined))


def _paired(part: Part, template: Template) -> tuple[Part, Match]:
    """The part as the mesh's was made ready, and the partners of the template's entities in it."""
    ready = [part]
    if template.is_swept and len(part.solids) == 1:
        # It needs no sweep of its own, and the user's choice of caps has its answer in the template.
        with suppress(NotSweepableError, InputError):
            ready.insert(0, open_and_find(part, *template.choice)[0])
    first: CadSweepError | None = None
    for one in ready:
        try:
            return one, match_graphs(template.graph, graph_of_part(one))
        except CadError as error:
            first = first or error
    assert first is not None
    raise first


def _carried(template: Template, known: IntArray, places: FloatArray) -> tuple[FloatArray, CellBlocks | None]:
    """All nodes, and their factors; where folded hexes would come of it, nodes go to their places in steps."""
    hexes = template.mesh.hexes[:, :8]
    made = _between_layers(template, known, carry_inside(template.points, hexes, known, places))
    if scaled_jacobians(made[0], hexes).min() > 0.0:
        return made
    return _between_layers(template, known, carry_inside(template.points, hexes, known, places, n_steps=STEPS))


def _between_layers(template: Template, known: IntArray, points: FloatArray) -> tuple[FloatArray, CellBlocks | None]:
    """All nodes, those inside of cells that no cut bounds placed anew between their rings; and the factors.

    What smoothing moved there is moved by as much, in the map between the rings.
    """
    if template.factored is None:
        return points, None
    cells, on_model = template.factored.cells, np.zeros(len(points), dtype=bool)
    factors = list(cells.cells)
    on_model[known] = True
    points = points.copy()
    for number, own in enumerate(cells.cells):
        if not isinstance(own, SweptCell):
            continue
        how, block = own.sweep, cells.swept_block(number, Units(), 0)
        nodes = block.layers(np.arange(how.n_layers + 1))
        rings, inside = nodes[:, how.ring_nodes], nodes[1:-1][:, block.inside]
        if not inside.size or not all(on_model[some].all() for some in (nodes[0], nodes[-1], rings)):
            continue
        layers = slice(1, how.n_layers)
        placed = project_layers(
            points[nodes[0]],
            how.quads,
            points[rings],
            loops=how.loops,
            functional=how.functional,
            strategy=how.strategy,
            target_points=points[nodes[-1]],
            residual=how.n_modes > 0,
        )
        factors[number] = replace(own, sweep=placed)
        shifts = template.points[inside] - how.points(layers)[:, block.inside]
        points[inside] = placed.points(layers)[:, block.inside]
        for k in np.flatnonzero((np.abs(shifts) > _UNMOVED * np.ptp(how.rings, axis=(0, 1)).max()).any(axis=(1, 2))):
            near = slice(max(0, min(k, how.n_layers - 2)), max(k + 3, 3))
            source, image = how.rings[near].reshape(-1, 3), points[rings[near]].reshape(1, -1, 3)
            points[inside[k]] += shifts[k] @ fit_linear_parts(source, image)[0].T
    nothing = np.empty(0, dtype=np.int64)
    skeleton = points[cells.numbers]
    return points, replace(
        cells, points=skeleton, cells=tuple(factors), moved_nodes=nothing, moved_points=np.empty((0, 3))
    )


def _meshed_solids(part: Part, wanted: dict[str, Any]) -> Part:
    """The solids that a mesh was made of, sharing what they shared there."""
    part = chosen_solids(part, only=wanted["only"], skip=wanted["skip"])
    return separated(part) if wanted["interfaces"] == "separate" else part


def _groups_like(part: Part, template: GroupsTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """Solids that do not all touch: each group of them as its partner, which has the same names."""
    part = _meshed_solids(part, template.solids)
    owners = {model.name: [c for c, own in enumerate(part.owners) if own == j] for j, model in enumerate(part.models)}
    known = {name for names, _ in template.groups for name in names}
    for here, there, whose in ((known, owners, "this part"), (owners, known, "the mesh's part")):
        for name in sorted(here):
            if name not in there:
                raise CadError(f"the parts do not correspond: there is no solid '{name}' in {whose}")
    present = {frozenset(part.models[part.owners[c]].name for c in cells) for cells in touching_groups(part)}
    groups = []
    for names, own in template.groups:
        if frozenset(names) not in present:
            raise CadError(
                f"the parts do not correspond: '{names[0]}' touches other solids here than in the mesh's part"
            )
        alone = subset(part, sorted(cell for name in names for cell in owners[name]))
        groups.append(make_group(alone, _part_like(alone, own, options, run)))
    return put_together(part, groups, replace(options, **template.solids), run)


def _design_like(part: Part, template: DesignTemplate, options: SweepOptions, run: Run) -> HexMesh:
    """A solid as its partner was meshed, by the design of that: what it is carried from is like that, too.

    Raises
    ------
    CadError
        Its design's mesh has other hexahedra on it.
    """
    from ..designs import design_like  # hardly any mesh was

    def mesh_it(design: Part, asked: SweepOptions, run: Run) -> HexMesh:
        return _part_like(design, template.design, asked, run)

    (solid,) = part.solids
    if len(solid.faces) != len(template.names):
        raise CadError(
            f"the parts do not correspond: the mesh's part has {len(template.names)} faces, and this has "
            f"{len(solid.faces)}; the mesh is by a design, of which faces answer each other by their order"
        )
    faces = [replace(face, name=None, groups=names) for face, names in zip(solid.faces, template.names, strict=True)]
    part = replace(part, solids=(replace(solid, faces=tuple(faces)),), names=template.labels)
    mesh = design_like(part, template.choice, options, run, mesh_it)
    if not np.array_equal(mesh.hexes[:, :8], template.mesh.hexes[:, :8]):
        raise CadError("the parts do not correspond: the meshes of their designs have sheets in different places")
    return mesh


def _boundary(template: Template, match: Match, part: Part) -> tuple[IntArray, FloatArray]:
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
    along = dict[int, tuple[FloatArray | None, float]]()
    for face, meshed in sorted(template.faces.items(), key=lambda item: item[0] not in template.answers):
        loops = meshed.loops()
        boundary, surface = points[meshed.nodes[np.concatenate(loops)]], surfaces[match.faces[face]]
        if np.isnan(boundary).any():
            label = template.graph.face_labels[face]
            raise CadError(f"the parts do not correspond: {label} has an outline that is on no edge")
        step, good = along.get(face, (None, 1.0))
        carried = carry_face(meshed, boundary, loops, surface, shift=step, good=good)
        points[meshed.nodes] = carried
        if face in template.answers:
            # Where the source is relaxed, the target goes along: apart, the two would twist the layers between them.
            step = carried - carry_face(meshed, boundary, loops, surface, relax=False)
            target = template.faces[template.answers[face]]
            if step.any() and len(target.nodes) == len(step):
                opposite = points[target.nodes[np.concatenate(loops)]]
                linear = fit_linear_parts(boundary, opposite[None])[0]
                normals = sweep_normals(carried, meshed.quads, surface)
                along[template.answers[face]] = step @ linear.T, worst_corner(carried, meshed.quads, normals)
    known = np.unique(template.quads)
    return known, points[known]


def _place(starts: tuple[int, ...], number: int) -> tuple[int, int]:
    """Solid, and id there, of an id that runs through all solids."""
    solid = int(np.searchsorted(starts, number, side="right")) - 1
    return solid, number - starts[solid]


def _joined(template: Template, match: Match, part: Part, starts: FirstIds, points: FloatArray) -> JoinedMesh:
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


def _names(template: Template, match: Match, starts: FirstIds) -> NamedFaces:
    """What the part's faces are called: as their partners."""

    def there(face: int) -> tuple[int, int]:
        return _place(starts.faces, match.faces[face])

    return NamedFaces(
        outside={there(face): names for face, names in template.outside.items()},
        between={there(face): names for face, names in template.between.items()},
        first={there(face): face in template.first for face in template.between},
        patches={(*there(face), j): own for face, names in template.patches.items() for j, own in enumerate(names)},
    )
