"""Nested refinement: every hexahedron into eight, the nodes there are kept, the new ones on the CAD model.

Place in the flow: after a mesh is made; :func:`refine` is public, and ``refine=K`` of ``sweep_mesh`` calls it.

Method: on the boundary the new nodes are those of hexahedra of 27 nodes: middles of segments on the CAD's edges,
middles and centres of quads on its faces (:mod:`cadsweep.orders`). They make a source cap, rings and a target cap with
half the steps, and the inner nodes of those come from one factored sweep. What it places a coarse node away from where
it is, by smoothing or by the strategy, is added to the new nodes around in the mean, so that the mesh has no kinks at
the nodes that stay. Caps are evened out where quads at a rim got worse (:mod:`.refined_caps`). Where the checks find
an invalid hex, the new nodes, and they alone, are smoothed.

Meshes of several cells are refined by :mod:`.cells_refinement`.

Not handled: a quad with two segments on one smooth curve has an angle there that tends to two right ones, whatever is
done inside: nested meshes keep such quads, and their worst scaled Jacobian halves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .. import estimate, smoothing
from ..blocks.block import FactoredMesh
from ..blocks.halves import Halved, halve, halved_surfaces
from ..blocks.reference import make_reference
from ..errors import InputError
from ..mesh import HexMesh, SurfaceMesh
from ..options import SweepOptions
from ..orders.curving import project_to_edges, project_to_faces
from ..orders.elevate import elevate, place_lattice
from ..projection import project_layers
from ..quality import check_mesh
from ..segments import ring_segments
from .cells_refinement import refine_cells
from .groups import put_together
from .origin import CellsOrigin, GroupsOrigin, Origin, origin_of
from .pairs import with_pairs
from .refined_caps import share_out
from .refusing import refusal
from .run import Run, silent

MOST_LEVELS = 8
"""Each makes eight times as many hexes."""

FELL = 0.75
"""Part of the worst scaled Jacobian that refining must leave to go without a note."""


def refine(mesh: HexMesh, levels: int = 1) -> HexMesh:
    """Halve a mesh in every direction.

    Parameters
    ----------
    mesh : HexMesh
        From :func:`cadsweep.sweep_mesh` in this process, or from here.
    levels : int
        How often; each level has eight times as many hexes.

    Returns
    -------
    HexMesh
        Valid, of the order of `mesh`, with its names. ``parents`` (m,) is the hex of `mesh` that each hex is a piece
        of, and ``info["coarse_nodes"]`` (n,) the node that each corner node of `mesh` is, at the same place bit for
        bit. New nodes on the boundary lie on the CAD model's edges and faces.

    Raises
    ------
    InputError
        The mesh does not know its CAD model, or `levels` is not a whole number from 1 to 8.
    InvertedHexError
        The refined mesh is not valid: the coarse one follows the model's curves too coarsely.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> mesh = cs.sweep_mesh(box, size=1.0, layers=2)
    >>> fine = cs.refine(mesh)
    >>> fine.n_hexes == 8 * mesh.n_hexes
    True
    >>> bool((fine.points[fine.info["coarse_nodes"]] == mesh.points).all())
    True
    """
    if isinstance(levels, bool) or not isinstance(levels, int) or not 1 <= levels <= MOST_LEVELS:
        raise InputError(f"levels must be a whole number from 1 to {MOST_LEVELS}, not {levels!r}")
    fine = _refine(mesh, levels, Run(on_progress=silent))
    before, after = (one.info["quality"].min_scaled_jacobian for one in (mesh, fine))
    if after < FELL * before:
        note = (
            f"refined, the worst scaled Jacobian fell from {before:.2f} to {after:.2f}: quads with two segments on one "
            "smooth curve keep their nodes, and the angle between the segments opens; start from a finer mesh"
        )
        return replace(fine, info={**fine.info, "notes": [*fine.info["notes"], note]})
    return fine


def _refine(mesh: HexMesh, levels: int, run: Run) -> HexMesh:
    origin = origin_of(mesh, "refining")
    if isinstance(origin, GroupsOrigin):
        return _refine_groups(origin, levels, run)
    if isinstance(origin, CellsOrigin):
        cells, parents = refine_cells(mesh, levels, run)
        return replace(
            cells, parents=parents, info={**cells.info, "coarse_nodes": np.arange(len(origin.joined.points))}
        )
    parents, kept = (
        np.arange(mesh.n_hexes),
        np.arange(origin.factored.structure.n_nodes * origin.factored.n_node_layers),
    )
    fine = _first_order(mesh, origin)
    for _ in range(levels):
        fine, halved = _halved_mesh(fine)
        parents = parents[halved.parents]
        kept = halved.nodes[kept]
    if mesh.order > 1:
        fine = _high_order(fine, mesh.order, mesh.hexes.shape[1])
    info = {**fine.info, "way": mesh.info.get("way"), "coarse_nodes": kept}
    return with_pairs(replace(fine, parents=parents, info=info))


def _refine_groups(origin: GroupsOrigin, levels: int, run: Run) -> HexMesh:
    """Each of the meshes that lie side by side, refined."""
    groups = [replace(group, mesh=_refine(group.mesh, levels, run)) for group in origin.groups]
    fine = put_together(origin.part, groups, origin.options, run)
    parents, kept = [], []
    coarse_hexes, fine_nodes = 0, 0
    for coarse, group in zip(origin.groups, groups, strict=True):
        assert group.mesh.parents is not None
        parents.append(group.mesh.parents + coarse_hexes)
        kept.append(group.mesh.info["coarse_nodes"] + fine_nodes)
        coarse_hexes += coarse.mesh.n_hexes
        fine_nodes += group.mesh.n_nodes
    return replace(fine, parents=np.concatenate(parents), info={**fine.info, "coarse_nodes": np.concatenate(kept)})


def refined(mesh: HexMesh, options: SweepOptions, run: Run) -> HexMesh:
    """The mesh as often refined as the options ask."""
    if not options.refine:
        return mesh
    estimate.check_refined(mesh.n_hexes, options.refine, max_hexes=options.max_hexes, max_memory=options.max_memory)
    with run.stage("refine"):
        return refine(mesh, options.refine)


def _first_order(mesh: HexMesh, origin: Origin) -> HexMesh:
    """The mesh as one of order 1."""
    if mesh.order == 1:
        return mesh
    plain = origin.factored.to_mesh()
    return replace(plain, points=mesh.points[: plain.n_nodes], origin=origin)


def _high_order(mesh: HexMesh, order: int, nodes: int) -> HexMesh:
    origin: Origin = mesh.origin
    part, sweep = origin.part, origin.sweep
    curved = elevate(
        mesh,
        order=order,
        nodes=nodes,
        curves=project_to_edges(part, sweep, origin.surfaces),
        surfaces=project_to_faces(part, sweep, origin.factored),
        allow_inverted=origin.options.allow_inverted,
    )
    return _checked(curved, origin)


def _halved_mesh(mesh: HexMesh) -> tuple[HexMesh, Halved]:
    origin: Origin = mesh.origin
    part, sweep, factored = origin.part, origin.sweep, origin.factored
    lattice, hexes, _, _ = place_lattice(
        mesh,
        nodes=27,
        curves=project_to_edges(part, sweep, origin.surfaces),
        surfaces=project_to_faces(part, sweep, factored),
    )
    halved = halve(factored.structure, hexes)
    model = lattice[halved.lattice]
    points = (model - factored.offset) / factored.scale
    if not halved.structure.periodic:
        placed = points[[0, -1]]
        share_out(points, halved, sweep, origin.surfaces)
        for layer, before in zip((0, -1), placed, strict=True):
            moved = (points[layer] != before).any(axis=1)
            model[layer][moved] = points[layer][moved] * factored.scale + factored.offset
    around, along = (edges for _, edges in ring_segments(sweep, origin.surfaces))
    surfaces = halved_surfaces(
        halved, origin.surfaces, points, around=around, along=along, target_edges=sweep.target_edges
    )
    fine = _factored(origin, halved, surfaces, points)
    made = Origin(part=part, sweep=sweep, surfaces=surfaces, factored=fine, options=origin.options)
    result = _exact(fine.to_mesh(), mesh, halved, model, made)
    report = check_mesh(result, cad=make_reference(part, sweep))
    if not report.valid and origin.options.smoothing:
        made = replace(made, factored=_smoothed(fine, halved))
        result = _exact(made.factored.to_mesh(), mesh, halved, model, made)
    return _checked(result, made), halved


def _exact(fine: HexMesh, coarse: HexMesh, halved: Halved, model: np.ndarray, origin: Origin) -> HexMesh:
    """The mesh with the coarse nodes, and those on its boundary, where they are to the last bit."""
    structure = halved.structure
    boundary = np.zeros((origin.factored.n_node_layers, structure.n_nodes), dtype=bool)
    boundary[:, np.concatenate(structure.loops)] = True
    if not structure.periodic:
        boundary[[0, -1]] = True
    points = fine.points
    points[boundary.reshape(-1)] = model[: len(boundary)][boundary]
    points[halved.nodes] = coarse.points
    return replace(fine, origin=origin)


def _checked(mesh: HexMesh, origin: Origin) -> HexMesh:
    report = check_mesh(mesh, cad=make_reference(origin.part, origin.sweep))
    if not report.valid and not origin.options.allow_inverted:
        raise refusal(report, origin.part, origin.sweep)
    return replace(mesh, info={**mesh.info, "quality": report})


def _factored(origin: Origin, halved: Halved, surfaces: SurfaceMesh, points: np.ndarray) -> FactoredMesh:
    """The factors of the fine sweep, and what the coarse nodes ask of it besides."""
    coarse, options = origin.factored, origin.options
    placed = project_layers(
        surfaces.source.points,
        surfaces.source.quads,
        surfaces.rings,
        loops=surfaces.source.loops,
        functional=options.functional,
        strategy=options.strategy,
        target_points=points[-1],
        residual=options.residual,
    )
    n, n_layers = halved.n_coarse, coarse.structure.n_layers
    wanted = points[::2, :n]
    swept = np.asarray(placed.points(slice(0, 2 * n_layers + 1)))
    shifts = halved.prolonged(wanted - swept[::2, :n])
    shifts[:, np.concatenate(surfaces.source.loops)] = 0.0
    shifts[[0, -1]] = 0.0
    last = 2 * n_layers + (not halved.structure.periodic)
    moved = np.flatnonzero((shifts[:last] != 0.0).any(axis=2))
    info: dict[str, Any] = {**coarse.info, "notes": [*coarse.info["notes"]]}
    info["sweeps"] = [
        {**sweep, "layers": 2 * sweep["layers"], "span_layers": [2 * one for one in sweep["span_layers"]]}
        for sweep in coarse.info["sweeps"]
    ]
    info.pop("quality", None)
    info.pop("distance", None)  # of the coarse mesh
    return replace(
        coarse,
        sweep=placed,
        structure=halved.structure,
        source_owners=np.repeat(coarse.source_owners, 4),
        target_owners=np.repeat(coarse.target_owners, 4),
        side_owners=np.repeat(np.repeat(coarse.side_owners, 2, axis=0), 2, axis=1),
        kept_nodes=np.empty(0, dtype=np.int64),
        moved_nodes=moved,
        moved_points=(swept[:last] + shifts[:last]).reshape(-1, 3)[moved],
        info=info,
    )


def _smoothed(fine: FactoredMesh, halved: Halved) -> FactoredMesh:
    """Mend the worst places by moving new nodes alone."""
    structure = halved.structure
    fixed = np.zeros((fine.n_node_layers, structure.n_nodes), dtype=bool)
    fixed[:, np.concatenate(structure.loops)] = True
    fixed[::2, : halved.n_coarse] = True
    if not structure.periodic:
        fixed[[0, -1]] = True
    points = fine.points().reshape(-1, 3)
    better = smoothing.improve(points, structure, fixed=fixed.reshape(-1))
    fine = fine.noted(better.steps)
    moved = np.union1d(fine.moved_nodes, better.nodes)
    points[better.nodes] = better.positions
    return replace(fine, moved_nodes=moved, moved_points=(points[moved] - fine.offset) / fine.scale)
