"""Meshes of solids that do not touch, side by side in one: names, checks, and what each was made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...blocks.block_mesh import BlockMesh, blocks_side_by_side, mesh_of_arrays
from ...brep import Part
from ...mesh import HexMesh
from ...options import SweepOptions
from ...quality import check_mesh
from ..origin import AnyMesh, Group, GroupsOrigin
from ..refusing import refusal
from ..run import Run, measured
from .beside import info_of_all, side_by_side
from .separate import name_contacts


def make_group(part: Part, mesh: HexMesh) -> Group:
    """A part of solids that hang together, and its mesh, which may not follow the contacts' outlines."""
    return Group(
        solids=tuple(model.name for model in part.models),
        given=_given_names(part),
        mesh=mesh,
        part=part,
    )


def put_together(part: Part, groups: Sequence[Group], options: SweepOptions, run: Run) -> HexMesh:
    """One mesh of the groups of a part.

    A solid by itself gets its own part of the mesh, and its boundaries are called after it where their user gave them
    no name.
    """
    meshes = [_called(group) for group in groups]
    origin = GroupsOrigin(part=part, groups=tuple(groups), options=options)
    known = _known_solids(part)
    if len(meshes) == 1:
        mesh = replace(meshes[0], info={**meshes[0].info, **known})
        return mesh if len(groups[0].solids) > 1 else replace(mesh, origin=origin)
    mesh = side_by_side(meshes)
    with run.stage("quality"):
        report = check_mesh(mesh, cad={})
    if not report.valid and not options.allow_inverted:
        raise refusal(report)
    info = {**mesh.info, **known, "part": part.name, "seconds": run.seconds, "quality": report}
    return replace(mesh, origin=origin, info=info)


def blocks_together(part: Part, groups: Sequence[tuple[Part, BlockMesh]], options: SweepOptions, run: Run) -> BlockMesh:
    """The mesh of :func:`put_together` of groups, each a part and its mesh, that stay in blocks."""
    meshes = [_called_blocks(own, mesh) for own, mesh in groups]
    known = _known_solids(part)
    if len(meshes) == 1:
        return replace(meshes[0], info={**meshes[0].info, **known})
    mesh = blocks_side_by_side(meshes, info_of_all([mesh.info for mesh in meshes]))
    with run.stage("quality"):
        report = measured(mesh, {}, run)
    if not report.valid and not options.allow_inverted:
        raise refusal(report)
    return replace(mesh, info={**mesh.info, **known, "part": part.name, "seconds": run.seconds, "quality": report})


def as_blocks(mesh: AnyMesh) -> BlockMesh:
    """A mesh as blocks, whether its insides are factors or arrays."""
    return mesh if isinstance(mesh, BlockMesh) else mesh_of_arrays(mesh)


def _given_names(part: Part) -> frozenset[str]:
    """Names that the user gave to faces."""
    return frozenset(label for solid in part.solids for face in solid.faces for label in face.names)


def _known_solids(part: Part) -> dict[str, dict[str, str]]:
    """What the record says of the solids of an assembly."""
    return {
        "materials": {model.name: model.material for model in part.models if model.material},
        "paths": {model.name: model.path for model in part.models if model.path},
    }


def _called(group: Group) -> HexMesh:
    """The mesh of a group with the names that it has beside others."""
    mesh = name_contacts(group.mesh, group.part)
    if len(group.solids) > 1:
        return mesh
    name = group.solids[0]
    called = {label: label if label in group.given else f"{name}_{label}" for label in mesh.boundaries}

    def renamed(key: str) -> str:
        """The names of two matched boundaries, or of several that are one side of them."""
        sides = [[called.get(label, label) for label in side.split("_and_")] for side in key.split("__")]
        return "__".join("_and_".join(labels) for labels in sides)

    return replace(
        mesh,
        boundaries={called[label]: quads for label, quads in mesh.boundaries.items()},
        periodic={renamed(key): pairs for key, pairs in mesh.periodic.items()},
        parts={name: np.arange(mesh.n_hexes)},
        structure=None,
    )


def _called_blocks(part: Part, mesh: BlockMesh) -> BlockMesh:
    """The same of a mesh that stays in blocks."""
    if part.contacts:
        mesh = mesh.named(name_contacts(mesh.skin(), part))
    if len(part.models) > 1:
        return mesh
    name, given = part.models[0].name, _given_names(part)
    return replace(
        mesh,
        boundaries={label if label in given else f"{name}_{label}": own for label, own in mesh.boundaries.items()},
        parts=(name,),
    )
