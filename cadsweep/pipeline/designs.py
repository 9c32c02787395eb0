"""A solid meshed by its design: without its blends, by whatever way that takes, and then carried onto the model.

Place in the flow: a row of the ways of :mod:`.routes`, after one sweep and columns of the model itself.

Method: blends are found (:mod:`cadsweep.blends`), taken away in a copy (``cad.design_of``), the design is meshed like
any other solid, and its nodes go to the model's corners, edges and faces (:func:`cadsweep.blends.carrying.carry`). What
is inverted then is untangled. Borders of blends are no lines of the mesh: a blend has the quads with middles on it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .. import cad
from ..arrays import FloatArray, IntArray
from ..blends import Blend, find_blends
from ..blends.carrying import Carried, carry
from ..blends.patches import find_patches
from ..blends.united import patch_surfaces, unite
from ..blocks.interface_slides import InterfaceSlides
from ..blocks.joined import JoinedMesh
from ..brep import Part, Solid
from ..entity.entities import Entities
from ..errors import NotSweepableError, SurfaceMeshError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..quality import scaled_jacobians
from ..smoothing.patch import edge_lengths
from ..smoothing.untangle import guards_outside, untangle
from .origin import AnyMesh, CellsOrigin, Origin
from .run import Run
from .several import finish

log = logging.getLogger(__name__)

_GUARD = 0.25
"""Height of the hexahedra outside, over the lengths of the boundary's quads, while a mesh is untangled."""
_GOAL = 0.2
"""Worst scaled Jacobian at which untangling ends: smoothing goes on from there."""

_OF_ENTITIES = (
    *("source", "target", "rail_layers", "wall_layers", "periodic"),
    *("sizes", "counts", "biases", "local_sizes"),
)
"""Options that speak of faces and edges of the model, which the design need not have."""
_NOTE = (
    "meshed by its design, without {} faces of blends, and laid on them then: they have the quads with middles on them"
)


def has_design(part: Part, options: SweepOptions) -> bool:
    """Whether a solid has blends, and nothing is asked for that speaks of faces and edges as they are."""
    return all(getattr(options, name) is None for name in _OF_ENTITIES) and bool(find_blends(part.solids[0]))


def mesh_design(
    part: Part, options: SweepOptions, run: Run, mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh]
) -> HexMesh:
    """Mesh a part of one solid by its design; `mesh_it` meshes that.

    Raises
    ------
    NotSweepableError
        It has none.
    CadSweepError
        The design cannot be meshed, or its mesh not be carried.
    """
    (solid,) = part.solids
    blends = find_blends(solid)
    with run.stage("design"):
        design = cad.design_of(part, [blend.faces for blend in blends]) if blends else None
    if design is None:
        raise NotSweepableError("the solid has no blends that can be left out")
    made = mesh_it(design.part, replace(options, order=1, refine=0), replace(run, measure=None))
    assert isinstance(made, HexMesh), "in memory"
    assert isinstance(made.origin, Origin | CellsOrigin), "one solid"
    with run.stage("carrying"):
        united, joined, slides = _carried(part, blends, design, _roles_of(made.origin), made.origin.entities, run)
    mesh = finish(
        replace(part, solids=(united,), models=part.models, owners=(0,)),
        joined,
        options,
        replace(run, measure=None),
        notes=[_NOTE.format(len(design.gone)), *design.left],
        sweeps=made.info["sweeps"],
        slides=lambda: slides,
    )
    assert isinstance(mesh, HexMesh), "it has no factors"
    if options.tolerance is not None and mesh.info["distance"] > options.tolerance:
        raise NotSweepableError(f"the mesh of the design is {mesh.info['distance']:.3g} off the model's faces")
    return replace(mesh, info={**mesh.info, "way": made.info["way"]})


def _carried(  # noqa: PLR0917
    part: Part, blends: list[Blend], design: cad.Design, roles: dict[str, str], made: Entities, run: Run
) -> tuple[Solid, JoinedMesh, InterfaceSlides]:
    """The model by patches, the mesh on it, and how its nodes may move.

    Raises
    ------
    SurfaceMeshError
        The mesh cannot be carried, or hexahedra stay inverted.
    """
    (solid,) = part.solids
    patch_of = find_patches(solid, blends, design.gone, design.model_faces)
    quads, faces = _skin(solid, made)
    points, hexes = made.points, made.joined.hexes
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
        points=_untangled(carried, quads, quad_faces, made, slides, run),
        hexes=hexes,
        hex_cells=np.zeros(len(hexes), dtype=np.int64),
        quads=quads,
        quad_cells=np.zeros(len(quads), dtype=np.int64),
        quad_faces=quad_faces,
        roles=_roles(united, roles),
        edge_nodes={number: line.nodes for number, line in enumerate(carried.lines)},
    )
    return united, joined, slides


def _skin(solid: Solid, made: Entities) -> tuple[IntArray, IntArray]:
    """Quads (q, 4) on faces of the design, outward, and the face of the model (q,) that each is on."""
    by_key = {face.key or f"face {face.id}": face.id for face in reversed(solid.faces)}
    quads, faces = [], []
    for place, own in made.faces.items():
        if not made.names.of(place):
            continue
        face = made.face(place)
        found = np.full(len(own), by_key[face.key], dtype=np.int64)
        middles = made.points[own].mean(axis=1)
        for patch in face.former:
            found[patch.contains(middles)] = by_key[patch.key]
        quads.append(own)
        faces.append(found)
    return np.concatenate(quads), np.concatenate(faces)


def _untangled(  # noqa: PLR0917
    carried: Carried, quads: IntArray, quad_faces: IntArray, made: Entities, slides: InterfaceSlides, run: Run
) -> FloatArray:
    """The carried points, untangled where a hexahedron is inverted.

    Raises
    ------
    SurfaceMeshError
        Some stay inverted.
    """
    hexes = made.joined.hexes
    if scaled_jacobians(carried.points, hexes).min() > 0.0:
        return carried.points
    free = np.ones(len(carried.points), dtype=bool)
    free[quads] = False
    lengths = edge_lengths(made.points, hexes)
    found = untangle(
        carried.points, hexes, free | slides.mask, lengths, slides, goal=_GOAL,
        guards=guards_outside(
            slides.surfaces, len(carried.points), quads, quad_faces, _GUARD * float(np.median(lengths))
        ),
        on_round=lambda left: run.is_over(),
    )  # fmt: skip
    if found.worst <= 0:
        raise SurfaceMeshError("hexahedra stay inverted once the mesh of the design lies on the model")
    return found.points


def _roles(united: Solid, roles: dict[str, str]) -> dict[tuple[int, ...], str]:
    """Roles of faces, and of patches of faces, by what the design's faces are in its mesh."""
    found: dict[tuple[int, ...], str] = {}
    for face in united.faces:
        found[0, face.id] = roles.get(face.key, "side")
        found |= {(0, face.id, j): roles.get(own.key, "side") for j, own in enumerate(face.former)}
    return found


def _roles_of(origin: Origin | CellsOrigin) -> dict[str, str]:
    """Roles of the design's faces, by key; those of two kinds have none."""
    own: Mapping[Any, str]
    if isinstance(origin, Origin):
        own = {(0, f): role for role in ("source", "target") for f in getattr(origin.sweep, role)}
        solids: tuple[Solid, ...] = (origin.sweep.solid,)
    else:
        own, solids = origin.joined.roles, origin.part.solids
    found: dict[str, set[str]] = {}
    for cell, solid in enumerate(solids):
        for face in solid.faces:
            if origin.names.of((cell, face.id)):
                found.setdefault(face.key, set()).add(own.get((cell, face.id), "side"))
    return {key: next(iter(kinds)) for key, kinds in found.items() if len(kinds) == 1}


__all__ = ["has_design", "mesh_design"]
