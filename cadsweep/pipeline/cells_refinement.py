"""Nested refinement of a mesh of several cells, of columns, or of solids side by side.

Place in the flow: :func:`cadsweep.refine` comes here where the mesh is not of one sweep.

Method: the new nodes are those of hexahedra of 27 nodes (:mod:`cadsweep.orders`): on the CAD's edges and faces, and
inside by the bow of the edges, which fades harmonically, and by transfinite interpolation. Where the checks find an
invalid hex, the new nodes, and they alone, are smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..blocks.halved_cells import halve_joined, split_quads
from ..blocks.interface_slides import InterfaceSlides, find_interface_slides
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces
from ..brep import Part
from ..lattice import find_rows
from ..mesh import HexMesh
from ..options import SweepOptions
from ..orders.curving import curves_of, surfaces_of
from ..orders.elevate import place_lattice
from ..projection.target import GOOD_ENOUGH
from .cells_accuracy import boundary_distance
from .origin import CellsOrigin
from .pairs import with_pairs
from .refusing import refusal
from .run import Run
from .several import checked_cells


def refine_cells(mesh: HexMesh, levels: int, run: Run) -> tuple[HexMesh, IntArray]:
    """A mesh of cells with its steps halved `levels` times, and the coarse hex (m,) of every fine one."""
    origin: CellsOrigin = mesh.origin
    part, names, joined = origin.part, origin.names, origin.joined
    parents = np.arange(len(joined.hexes))
    plain = replace(origin.options, order=1, nodes=20)
    info: dict[str, Any] = {**mesh.info, "notes": list(mesh.info["notes"])}
    fine = _first_order(mesh, part, joined)
    for level in range(levels):
        lattice, hexes, edges, faces = place_lattice(
            fine, nodes=27, curves=curves_of(part, joined), surfaces=surfaces_of(part, joined, names)
        )
        assert faces is not None
        middle = Middles(n=fine.n_nodes, edges=edges, faces=faces)
        halved = _halved(joined, (lattice[fine.n_nodes :] - part.offset) / part.scale, hexes, middle)
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
            make=partial(_fine_mesh, fine, middle, part),
            info=info,
            smooth_below=goal,
            goal=goal,
            kept=kept,
            slides=None
            if origin.options.wall_layers  # whose heights were asked for
            else partial(_new_slides, part, halved, names, origin.options, kept),
        )
        report = fine.info["quality"]
        if not report.valid and not origin.options.allow_inverted:
            raise refusal(report)
        joined = fine.origin.joined
    return with_pairs(replace(fine, origin=replace(origin, joined=joined))), parents


def _new_slides(
    part: Part, halved: JoinedMesh, names: NamedFaces, options: SweepOptions, kept: BoolArray
) -> InterfaceSlides:
    """New nodes inside faces, which may move on these."""
    slides = find_interface_slides(part, halved, names, along_edges=False, outside=not options.periodic)
    return replace(slides, mask=slides.mask & ~kept)


def _first_order(mesh: HexMesh, part: Part, joined: JoinedMesh) -> HexMesh:
    """The mesh as one of order 1: of a hex and a quad of order 2 the corners come first."""
    boundaries = {name: quads[:, :4] for name, quads in mesh.boundaries.items()}
    interfaces = {name: quads[:, :4] for name, quads in mesh.interfaces.items()}
    points = mesh.points[: len(joined.points)]
    return replace(mesh, points=points, hexes=mesh.hexes[:, :8], boundaries=boundaries, interfaces=interfaces)


@dataclass(frozen=True, kw_only=True, eq=False)
class Middles:
    """Numbers of the nodes between the `n` coarse ones: in the middle of edges (e, 2), then of quads (f, 4)."""

    n: int
    edges: IntArray
    faces: IntArray

    def of_edges(self, pairs: IntArray) -> IntArray:
        """Nodes in the middle of segments (s, 2)."""
        return self.n + find_rows(self.edges, np.sort(pairs, axis=1), "segment")

    def split(self, quads: IntArray) -> IntArray:
        """Quads (q, 4) as four each."""
        sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
        centres = self.n + len(self.edges) + find_rows(self.faces, np.sort(quads, axis=1), "quad")
        return split_quads(quads, self.of_edges(sides).reshape(-1, 4), centres)


def _fine_mesh(coarse: HexMesh, middle: Middles, part: Part, joined: JoinedMesh, info: dict[str, Any]) -> HexMesh:
    """The mesh of `joined`, with the names of the coarse one, whose nodes stay to the last bit."""
    points = part.to_model(joined.points)
    points[: coarse.n_nodes] = coarse.points
    return HexMesh(
        points=points,
        hexes=joined.hexes,
        boundaries={name: middle.split(quads) for name, quads in coarse.boundaries.items()},
        interfaces={name: middle.split(quads) for name, quads in coarse.interfaces.items()},
        parts={name: (8 * ids[:, None] + np.arange(8)).reshape(-1) for name, ids in coarse.parts.items()},
        info=info,
    )


def _halved(joined: JoinedMesh, places: FloatArray, hexes: IntArray, middle: Middles) -> JoinedMesh:
    """The joined mesh with new nodes at `places`, working units."""
    chains = {}
    for key, nodes in joined.edge_nodes.items():
        chain = np.empty(2 * len(nodes) - 1, dtype=np.int64)
        chain[::2] = nodes
        chain[1::2] = middle.of_edges(np.column_stack([nodes[:-1], nodes[1:]]))
        chains[key] = chain
    return halve_joined(joined, np.concatenate([joined.points, places]), hexes, middle.split(joined.quads), chains)
