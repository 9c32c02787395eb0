"""Contacts of solids that are meshed each by itself, on meshes that do not follow their outlines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ... import cad
from ...arrays import FloatArray, IntArray
from ...brep import Part
from ...mesh import HexMesh

_OFF = 0.25
"""Greatest distance of a quad's middle from the CAD face it stands for, over its diagonal: around by 90 degrees."""
_ALIKE = 0.7
"""Least cosine between the normals of the two."""
_WITHIN = 0.9
"""Where a quad is asked whether it reaches into a contact: so far from its middle towards its corners."""


def name_contacts(mesh: HexMesh, imprinted: Part) -> HexMesh:
    """Name the quads of a solid's mesh that reach into those contacts which are no boundary of it yet.

    Parameters
    ----------
    mesh : HexMesh
        Of the solid, model units; its faces may be others.
    imprinted : Part
        The solid with a face a contact, called after the contact, and after its user's names where it has some.

    Returns
    -------
    HexMesh
        A contact has all quads that reach into it; these leave the boundaries that were named by us.
    """
    if not imprinted.contacts:
        return mesh
    contacts: dict[str, list[int]] = {}
    given: set[str] = set()
    for face in imprinted.solids[0].faces:
        if face.name is not None and face.name in imprinted.contacts:
            contacts.setdefault(face.name, []).append(face.id)
            given.update(face.groups)
        else:
            given.update(face.names)
    contacts = {name: faces for name, faces in contacts.items() if name not in mesh.boundaries}
    if not contacts:
        return mesh
    boundaries = dict(mesh.boundaries)
    notes = list(mesh.info["notes"])
    for name, faces in contacts.items():
        area = sum(imprinted.solids[0].faces[f].area for f in faces) * imprinted.scale**2
        found: list[IntArray] = []
        covered = 0.0
        for other, quads in list(boundaries.items()):
            chosen = _reaching(mesh, quads, imprinted, faces)
            if not chosen.any():
                continue
            found.append(quads[chosen])
            covered += _area(mesh.points[quads[chosen][:, :4]])
            if other not in given:
                boundaries[other] = quads[~chosen]
        if found:
            boundaries[name] = np.unique(np.concatenate(found), axis=0)
            notes.append(
                f"'{name}': the mesh does not follow the outline of this contact; it has the {len(boundaries[name])} "
                f"quads that reach into it, {100 * covered / area:.3g} % of its area"
            )
        else:
            notes.append(f"'{name}': no quad of the mesh reaches into this contact")
    boundaries = {name: quads for name, quads in boundaries.items() if len(quads)}
    return replace(mesh, boundaries=boundaries, info={**mesh.info, "notes": notes})


def _reaching(mesh: HexMesh, quads: IntArray, part: Part, faces: list[int]) -> np.ndarray:
    """Which quads (q, 4 or more) lie on some faces of a part and reach into them, (q,) bool."""
    corners = (mesh.points[quads[:, :4]] - part.offset) / part.scale
    middles = corners.mean(axis=1)
    across, other = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    diagonals = np.maximum(np.linalg.norm(across, axis=1), np.linalg.norm(other, axis=1))
    normals = np.cross(across, other)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(np.float64).tiny)[:, None]
    found = np.zeros(len(quads), dtype=bool)
    for f in faces:
        face = part.solids[0].faces[f]
        inside = cad.contains(part, [f])
        ring = np.concatenate([part.solids[0].edges[e].curve.evaluate(np.linspace(0, 1, 9)) for e in face.edges])
        low, high = ring.min(axis=0), ring.max(axis=0)
        reach = diagonals[:, None] + 0.5 * np.linalg.norm(high - low)  # a curved face bulges out of its edges' box
        near = np.flatnonzero(~found & ((middles > low - reach) & (middles < high + reach)).all(axis=1))
        uv = face.surface.project(middles[near])
        off = np.linalg.norm(face.surface.evaluate(uv) - middles[near], axis=1)
        alike = np.einsum("qd,qd->q", face.surface.normals(uv), normals[near]) > _ALIKE
        near = near[(off < _OFF * diagonals[near]) & alike]
        asked = np.concatenate([middles[near, None], middles[near, None] + _WITHIN * _arms(corners[near])], axis=1)
        found[near] |= inside(asked.reshape(-1, 3)).reshape(len(near), 5).any(axis=1)
    return found


def _arms(corners: FloatArray) -> FloatArray:
    """From the middle of quads (q, 4, 3) to their corners."""
    return corners - corners.mean(axis=1, keepdims=True)


def _area(corners: FloatArray) -> float:
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return 0.5 * float(np.linalg.norm(normals, axis=1).sum())
