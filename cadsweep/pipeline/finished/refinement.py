"""Nested refinement: every hexahedron into eight, the nodes there are kept, the new ones on the CAD model.

Place in the flow: after a mesh is made; :func:`refine` is public, and ``refine=K`` of ``sweep_mesh`` calls it. It asks
where nodes are (:mod:`cadsweep.entity`), and not how the mesh was made.

Method: the new nodes are those of hexahedra of 27 nodes (:mod:`cadsweep.orders`): on the CAD's edges and faces, and
inside by the bow of the edges, which fades harmonically, and by transfinite interpolation. Where the checks find an
invalid hex, or one far worse than it was, the new nodes, and they alone, are smoothed.

Not handled: a quad with two segments on one smooth curve has an angle there that tends to two right ones, whatever is
done inside: nested meshes keep such quads, and their worst scaled Jacobian halves.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ... import budget
from ...arrays import BoolArray, FloatArray, IntArray
from ...blocks.halved_cells import halve_joined, split_quads
from ...blocks.interface_slides import InterfaceSlides, find_interface_slides
from ...blocks.joined import JoinedMesh
from ...blocks.naming import NamedFaces
from ...brep import Part
from ...entity.entities import Entities
from ...errors import InputError
from ...lattice import Lattice
from ...mesh import HexMesh
from ...options import SweepOptions
from ...orders.placing import place
from ...projection.target import GOOD_ENOUGH
from ..complexes.checking import checked_cells
from ..complexes.groups import put_together
from ..nearness.measured import boundary_distance
from ..origin import GroupsOrigin, first_order, origin_of
from ..refusing import refusal
from ..run import Run, silent
from .pairs import with_pairs

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
    return _refine_cells(mesh, levels, run)


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
    budget.check_refined(mesh.n_hexes, options.refine, max_hexes=options.max_hexes, max_memory=options.max_memory)
    with run.stage("refine"):
        return refine(mesh, options.refine)


def _refine_cells(mesh: HexMesh, levels: int, run: Run) -> HexMesh:
    """A mesh with its steps halved `levels` times."""
    origin = mesh.origin
    part, names, joined = origin.part, origin.names, origin.joined
    parents = np.arange(len(joined.hexes))
    plain = replace(origin.options, order=1, nodes=20)
    info: dict[str, Any] = {**mesh.info, "notes": list(mesh.info["notes"])}
    fine = first_order(mesh, len(joined.points))
    for level in range(levels):
        on = Entities(part=part, joined=joined, names=names)
        placed, lattice = place(fine, 2, curves=on.on_curves(), surfaces=on.on_surfaces())
        halved = _halved(joined, (placed[fine.n_nodes :] - part.offset) / part.scale, lattice)
        parents = np.repeat(parents, 8)
        info["distance"] = boundary_distance(part, halved, names) * part.scale
        info = {**info, "sweeps": [{**sweep, "layers": 2 * sweep["layers"]} for sweep in info["sweeps"]]}
        kept = np.zeros(len(halved.points), dtype=bool)
        kept[: fine.n_nodes] = True
        goal = GOOD_ENOUGH * fine.info["quality"].min_scaled_jacobian
        fine = checked_cells(
            part,
            halved,
            names,
            plain if level < levels - 1 else origin.options,
            run,
            make=partial(_fine_mesh, fine, lattice, part),
            info=info,
            smooth_below=goal,
            goal=goal,
            kept=kept,
            slides=None
            if origin.options.wall_layers  # whose heights were asked for
            else partial(_new_slides, part, halved, names, origin.options, kept),
            references=origin.references,
        )
        report = fine.info["quality"]
        if not report.valid and not origin.options.allow_inverted:
            raise refusal(report)
        joined = fine.origin.joined
    info = {**fine.info, "coarse_nodes": np.arange(len(origin.joined.points))}
    return with_pairs(replace(fine, origin=origin.of_joined(joined), parents=parents, info=info))


def _new_slides(
    part: Part, halved: JoinedMesh, names: NamedFaces, options: SweepOptions, kept: BoolArray
) -> InterfaceSlides:
    """New nodes inside faces, which may move on these."""
    slides = find_interface_slides(part, halved, names, along_edges=False, outside=not options.periodic)
    return replace(slides, mask=slides.mask & ~kept)


def _split(lattice: Lattice, quads: IntArray) -> IntArray:
    """Quads (q, 4) as four each."""
    of_quad = lattice.quads(quads)
    return split_quads(quads, of_quad[:, 4:8], of_quad[:, 8])


def _fine_mesh(coarse: HexMesh, lattice: Lattice, part: Part, joined: JoinedMesh, info: dict[str, Any]) -> HexMesh:
    """The mesh of `joined`, with the names of the coarse one, whose nodes stay to the last bit."""
    points = part.to_model(joined.points)
    points[: coarse.n_nodes] = coarse.points
    return HexMesh(
        points=points,
        hexes=joined.hexes,
        boundaries={name: _split(lattice, quads) for name, quads in coarse.boundaries.items()},
        interfaces={name: _split(lattice, quads) for name, quads in coarse.interfaces.items()},
        parts={name: (8 * ids[:, None] + np.arange(8)).reshape(-1) for name, ids in coarse.parts.items()},
        info=info,
    )


def _halved(joined: JoinedMesh, places: FloatArray, lattice: Lattice) -> JoinedMesh:
    """The joined mesh with new nodes at `places`, working units."""
    chains = {}
    for key, nodes in joined.edge_nodes.items():
        chain = np.empty(2 * len(nodes) - 1, dtype=np.int64)
        chain[::2] = nodes
        chain[1::2] = lattice.edge_nodes(np.column_stack([nodes[:-1], nodes[1:]]))[:, 0]
        chains[key] = chain
    points = np.concatenate([joined.points, places])
    return halve_joined(joined, points, lattice.hexes, _split(lattice, joined.quads), chains)
