"""What the solids of a part touch each other in.

Place in the flow: after imprinting; read by ``cadsweep info`` and by whoever asks what a part is made of. Keys tell it:
what two cells share has one key. Plain data, no OpenCASCADE.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...brep import Part


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Two solids of a model that touch.

    Attributes
    ----------
    models : (int, int)
        Indices into ``Part.models``, ascending.
    faces : tuple of ((int, int), (int, int))
        Shared faces, as (cell, face id) in the first solid and in the second.
    area : float
        Of these faces, working units.
    n_edges, n_vertices : int
        Shared edges and vertices, those of shared faces and edges included.
    """

    models: tuple[int, int]
    faces: tuple[tuple[tuple[int, int], tuple[int, int]], ...]
    area: float
    n_edges: int
    n_vertices: int

    @property
    def kind(self) -> str:
        """What the solids touch in at most: ``"face"``, ``"edge"`` or ``"vertex"``."""
        return "face" if self.faces else "edge" if self.n_edges else "vertex"


def find_contacts(part: Part) -> tuple[Contact, ...]:
    """List every pair of solids of the model that touch, in the order of the model.

    Parameters
    ----------
    part : Part

    Returns
    -------
    tuple of Contact
        None for cells of one solid: what they share is a cut.
    """
    faces = _pairs(part, [solid.face_keys.tolist() for solid in part.solids])
    edges = _pairs(part, [solid.edge_keys.tolist() for solid in part.solids])
    vertices = _pairs(part, [solid.vertex_keys.tolist() for solid in part.solids])
    return tuple(
        Contact(
            models=pair,
            faces=tuple(faces.get(pair, {}).values()),
            area=sum(part.solids[cell].faces[face].area for (cell, face), _ in faces.get(pair, {}).values()),
            n_edges=len(edges.get(pair, {})),
            n_vertices=len(vertices.get(pair, {})),
        )
        for pair in sorted(faces.keys() | edges.keys() | vertices.keys())
    )


def _pairs(
    part: Part, keys: Sequence[Sequence[int]]
) -> dict[tuple[int, int], dict[int, tuple[tuple[int, int], tuple[int, int]]]]:
    """By two models, by key: where an entity is in each of them."""
    places: dict[int, dict[int, tuple[int, int]]] = {}
    for cell, own in enumerate(keys):
        for number, key in enumerate(own):
            places.setdefault(key, {}).setdefault(part.owners[cell], (cell, number))
    found: dict[tuple[int, int], dict[int, tuple[tuple[int, int], tuple[int, int]]]] = {}
    for key, by_model in places.items():
        models = sorted(by_model)
        for k, i in enumerate(models):
            for j in models[k + 1 :]:
                found.setdefault((i, j), {})[key] = (by_model[i], by_model[j])
    return found
