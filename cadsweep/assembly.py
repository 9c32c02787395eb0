"""From layers of nodes to a named mesh: which quads bound which face, and what the face is called.

Place in the flow: between ``projection`` and ``quality``. Every boundary quad belongs to exactly one
CAD face, and every CAD face to exactly one name, so the boundaries of a mesh never overlap.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from .mesh import HexMesh, SurfaceMesh, SweptStructure, side_quads, sweep_hexes
from .topology import FloatArray, IntArray, Sweep


def name_faces(sweep: Sweep) -> dict[int, str]:
    """Name every face of the solid.

    A face keeps the name that its user gave it. The others are ``source``, ``target`` and
    ``side_1``, ``side_2``, ... in the order of the loops; a cap of several unnamed faces is
    ``source_1``, ``source_2``, ... Pieces of one divided face share a name.

    Returns
    -------
    dict of int to str
        Face id to boundary name.
    """
    faces = sweep.solid.faces
    taken = {face.name for face in faces if face.name}
    roles = [("source", sweep.source), ("target", sweep.target), ("side", [s.face for s in sweep.linking_sides])]
    names: dict[int, str] = {}
    for role, ids in roles:
        keys = {}
        for i in ids:
            if not faces[i].name:
                keys.setdefault(faces[i].key or f"face {i}", len(keys) + 1)
        alone = role != "side" and len(keys) == 1
        for i in ids:
            face = faces[i]
            number = keys.get(face.key or f"face {i}")
            name = face.name or (role if alone else f"{role}_{number}")
            while not face.name and name in taken:
                name += "_"
            names[i] = name
    return names


def group_boundaries(
    sweep: Sweep, surfaces: SurfaceMesh, structure: SweptStructure, target_faces: IntArray
) -> dict[str, IntArray]:
    """Collect the outward boundary quads of the mesh by name.

    Parameters
    ----------
    target_faces : (q,) int64
        Face id on which each quad of the target cap lies.

    Returns
    -------
    dict of str to (m, 4) int64
        In the order source, target, sides.
    """
    names = name_faces(sweep)
    quads = structure.quads
    sides = side_quads(structure.loops, structure.n_nodes, structure.n_layers, periodic=structure.periodic)
    blocks: list[tuple[IntArray, IntArray]] = []
    if not structure.periodic:
        blocks.append((quads[:, ::-1], surfaces.source.faces))
        blocks.append((quads + structure.n_layers * structure.n_nodes, target_faces))
    blocks.append((sides.reshape(-1, 4), surfaces.side_faces.reshape(-1)))
    groups: dict[str, list[IntArray]] = {}
    for block, owners in blocks:
        order = np.argsort(owners, kind="stable")
        ids, starts = np.unique(owners[order], return_index=True)
        for face, chosen in zip(ids, np.split(order, starts[1:]), strict=True):
            groups.setdefault(names[int(face)], []).append(block[chosen])
    return {name: np.concatenate(parts) for name, parts in groups.items()}


def assemble(
    points: FloatArray,
    structure: SweptStructure,
    boundaries: dict[str, IntArray],
    *,
    part: str,
    info: dict[str, Any],
) -> HexMesh:
    """Make the mesh value from its layers.

    Parameters
    ----------
    points : (n, 3) float64
        All nodes, layer after layer, model units.
    part : str
        Name of the volume.
    """
    hexes = sweep_hexes(structure.quads, structure.n_nodes, structure.n_layers, periodic=structure.periodic)
    return HexMesh(
        points=points,
        hexes=hexes,
        boundaries=boundaries,
        parts={part: np.arange(len(hexes), dtype=np.int64)},
        structure=structure,
        info=info,
    )


def target_quad_faces(surfaces: SurfaceMesh, target: tuple[int, ...], matched: dict[int, int]) -> IntArray:
    """Face id of the target cap for every source quad.

    Parameters
    ----------
    target : tuple of int
        Faces of the target cap.
    matched : dict of int to int
        Source face to the target face that answers it; needed where the target has several faces.
    """
    owners = surfaces.source.faces
    if len(target) == 1:
        return np.full(len(owners), target[0], dtype=np.int64)
    missing = Counter(int(f) for f in owners if int(f) not in matched)
    assert not missing, f"no target face for source faces {sorted(missing)}"
    table = np.zeros(int(owners.max()) + 1, dtype=np.int64)
    for source_face, target_face in matched.items():
        table[source_face] = target_face
    return table[owners]
