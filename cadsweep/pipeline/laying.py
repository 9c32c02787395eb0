"""A mesh of a design laid on the model, checked there, and lines of it laid on borders of blends.

Place in the flow: :mod:`.designs` meshes a design and chooses among what comes of it here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .. import cad, rows
from ..arrays import FloatArray, IntArray
from ..blends import Blend
from ..blends.borders import BORDERS, BorderChoice, Bordered, with_borders
from ..blends.carrying import Carried, carry
from ..blends.sheets import DesignMesh
from ..blends.united import patch_surfaces, unite
from ..blocks.interface_slides import InterfaceSlides
from ..blocks.joined import JoinedMesh
from ..brep import Part, Solid
from ..errors import CadSweepError, InvertedHexError, SurfaceMeshError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..smoothing.ladder import STEPS
from ..smoothing.patch import edge_lengths
from ..smoothing.untangle import guards_outside, untangle
from .complexes.several import finish
from .finished.pairs import with_pairs
from .origin import made_of
from .run import Run

_GUARD = 0.25
"""Height of the hexahedra outside, over the lengths of the boundary's quads, while a mesh is untangled."""
_GOAL = 0.2
"""Worst scaled Jacobian at which untangling ends: smoothing goes on from there."""
_FOLLOWED = "{} of {} borders of its blends are lines of the mesh; at others each face has the quads with middles on it"
_UNFOLLOWED = "borders of its blends are no lines of the mesh; each face has the quads with middles on it"
_STEPS = tuple(f"{name} " for steps in STEPS.values() for name, _ in steps)
"""How notes of smoothing begin."""


def laid_on_model(  # noqa: PLR0917
    part: Part,
    blends: list[Blend],
    design: cad.Design,
    patch_of: IntArray,
    made: DesignMesh,
    roles: dict[str, str],
    notes: list[str],
    options: SweepOptions,
    run: Run,
    like: BorderChoice | None = None,
) -> tuple[HexMesh, Callable[[], tuple[HexMesh, BorderChoice]]]:
    """A mesh on the design, on the model and checked; and what lays lines of it on borders of blends, or those given.

    Raises
    ------
    CadSweepError
        It cannot be carried, or is not valid there.
    """
    with run.stage("carrying"):
        carrying = _carried(part, design, patch_of, made, roles)

    def finished(joined: JoinedMesh, slides: InterfaceSlides, notes: list[str]) -> HexMesh:
        united = replace(part, solids=(carrying.solid,), models=part.models, owners=(0,))
        own = replace(run, measure=None)
        mesh = finish(united, joined, options, own, notes=notes, slides=lambda: slides)
        assert isinstance(mesh, HexMesh), "it has no factors"
        return with_pairs(made_of(mesh, part))

    try:
        mesh = finished(carrying.joined, carrying.slides, notes)
    except InvertedHexError:  # smoothing mends places; what is crossed all over takes all nodes at once
        if run.is_over():
            raise
        with run.stage("carrying"):
            untangled = _untangled(carrying, edge_lengths(made.points, made.hexes), run)
        mesh = finished(untangled, carrying.slides, notes)

    def told(said: str) -> tuple[HexMesh, BorderChoice]:
        return replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], said]}), ()

    def bordered() -> tuple[HexMesh, BorderChoice]:
        if not rows.is_on(BORDERS) or is_layered(options) or (like is None and run.is_over()):
            return told(_UNFOLLOWED)
        joined = mesh.origin.joined
        try:
            with run.stage("carrying"):
                laid = with_borders(
                    part.solids[0], blends, patch_of, carrying.carried, joined.points, joined.hexes, joined.quads, like
                )  # fmt: skip
            said = _FOLLOWED.format(len(laid.borders), laid.n_runs)
            if not laid.borders:
                return told(said)
            steps = [note for note in mesh.info["notes"] if note.startswith(_STEPS)]
            followed = finished(joined.moved(laid.points), carrying.on_borders(laid), [*notes, *steps, said])
        except CadSweepError as error:  # as where it is too coarse then
            return told(f"{_UNFOLLOWED}: {error}")
        rows.took([BORDERS])
        return followed, laid.choice

    return mesh, bordered


def is_layered(options: SweepOptions) -> bool:
    """Whether hexahedra at the boundary are as they were asked for."""
    return options.wall_layers is not None or options.periodic is not None


class _Carrying(NamedTuple):
    """The model by patches, the mesh on it, and how its nodes may move."""

    solid: Solid
    carried: Carried
    joined: JoinedMesh
    slides: InterfaceSlides

    def on_borders(self, laid: Bordered) -> InterfaceSlides:
        """How its nodes may move once some are on borders of blends."""
        surface, curve, mask = self.slides.surface.copy(), self.slides.curve.copy(), self.slides.mask.copy()
        for number, border in enumerate(laid.borders, start=len(self.slides.curves)):
            surface[border.nodes], curve[border.nodes] = -1, number
        surface[laid.at_vertices], curve[laid.at_vertices], mask[laid.at_vertices] = -1, -1, False
        curves = [*self.slides.curves, *laid.curves]
        return replace(self.slides, mask=mask, surface=surface, curve=curve, curves=curves)


def _carried(part: Part, design: cad.Design, patch_of: IntArray, made: DesignMesh, roles: dict[str, str]) -> _Carrying:
    """Carry the mesh of a design.

    Raises
    ------
    SurfaceMeshError
        The mesh has not the edges of the model.
    """
    (solid,) = part.solids
    points, hexes, quads, faces = made
    carried = carry(solid, design.gone, patch_of, patch_surfaces(solid, patch_of), points, hexes, quads, faces)
    united, quad_faces = unite(solid, patch_of, carried, quads)
    slides = InterfaceSlides(
        mask=(carried.surface >= 0) | (carried.curve >= 0),
        surface=np.where(carried.surface >= 0, np.searchsorted(np.unique(patch_of), carried.surface), -1),
        curve=carried.curve,
        surfaces=[face.surface for face in united.faces],
        curves=[line.curve for line in carried.lines],
    )
    joined = JoinedMesh(
        points=carried.points,
        hexes=hexes,
        hex_cells=np.zeros(len(hexes), dtype=np.int64),
        quads=quads,
        quad_cells=np.zeros(len(quads), dtype=np.int64),
        quad_faces=quad_faces,
        roles=_roles(united, roles),
        edge_nodes={number: line.nodes for number, line in enumerate(carried.lines)},
    )
    return _Carrying(united, carried, joined, slides)


def _untangled(carrying: _Carrying, lengths: FloatArray, run: Run) -> JoinedMesh:
    """The carried mesh untangled; edges of hexahedra are to be as long as in the design, (m, 3).

    Raises
    ------
    SurfaceMeshError
        Some stay inverted.
    """
    joined, slides = carrying.joined, carrying.slides
    free = np.ones(len(joined.points), dtype=bool)
    free[joined.quads] = False
    height = _GUARD * float(np.median(lengths))
    found = untangle(
        joined.points,
        joined.hexes,
        free | slides.mask,
        lengths,
        slides,
        goal=_GOAL,
        guards=guards_outside(slides.surfaces, len(joined.points), joined.quads, joined.quad_faces, height),
        on_round=lambda left: run.is_over(),
    )
    if found.worst <= 0:
        raise SurfaceMeshError("hexahedra stay inverted once the mesh of the design lies on the model")
    return joined.moved(found.points)


def _roles(united: Solid, roles: dict[str, str]) -> dict[tuple[int, ...], str]:
    """Roles of faces, and of patches of faces, by what the design's faces are in its mesh."""
    found: dict[tuple[int, ...], str] = {}
    for face in united.faces:
        found[0, face.id] = roles.get(face.key, "side")
        found |= {(0, face.id, j): roles.get(own.key, "side") for j, own in enumerate(face.former)}
    return found


__all__ = ["is_layered", "laid_on_model"]
