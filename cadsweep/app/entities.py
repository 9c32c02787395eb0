"""The part as plain data: what the tree lists, what is picked, and what a word for it is.

Place in the flow: a child process reads the part (:mod:`.work`) and hands this over.

Keys: ``"solid:0"``, ``"face:0:7"``, ``"edge:0:12"``: kind, number of the solid, id in it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, IntArray

KINDS = ("solid", "face", "edge")


@dataclass(frozen=True, kw_only=True, eq=False)
class Entity:
    """A solid, a face or an edge.

    Attributes
    ----------
    key : str
    name : str
        The model's name for it; empty where it has none.
    shape : str
        ``"plane"``, ``"circle"``, ...; of a solid ``"solid"``.
    measure : float
        Volume, area or length, model units.
    place : tuple of three float
        Its middle, model units.
    neighbours : tuple of str
        Of a face its edges; of an edge its faces.
    tangent : bool
        Of an edge: its faces are tangent along it.
    color : str
        Of the CAD model, ``#rrggbb``; empty where it has none.
    """

    key: str
    name: str = ""
    shape: str
    measure: float
    place: tuple[float, float, float]
    neighbours: tuple[str, ...] = ()
    tangent: bool = False
    color: str = ""

    @property
    def kind(self) -> str:
        """``"solid"``, ``"face"`` or ``"edge"``."""
        return self.key.split(":")[0]

    @property
    def solid(self) -> int:
        """Number of the solid."""
        return int(self.key.split(":")[1])

    @property
    def id(self) -> int:
        """Id in the solid; of a solid its number."""
        return int(self.key.split(":")[-1])


@dataclass(frozen=True, kw_only=True, eq=False)
class PartData:
    """A part as the page knows it.

    Attributes
    ----------
    name : str
    entities : dict of str to Entity
        By key: each solid, then its faces, then its edges.
    points : (n, 3) float64
        Of the facets, model units.
    normals : (n, 3) float64
    triangles : (t, 3) int64
    owners : (t,) int64
        Face that each triangle is of, as a place in `face_keys`.
    chains : dict of str to (m, 3) float64
        Points along each edge.
    notes : tuple of str
    """

    name: str
    entities: dict[str, Entity]
    points: FloatArray
    normals: FloatArray
    triangles: IntArray
    owners: IntArray
    chains: dict[str, FloatArray]
    notes: tuple[str, ...] = ()
    volume: float = 0.0
    names: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def face_keys(self) -> list[str]:
        """Keys of the faces, in their order."""
        return [key for key in self.entities if key.startswith("face:")]

    @cached_property
    def solids(self) -> list[Entity]:
        """The solids."""
        return [entity for entity in self.entities.values() if entity.kind == "solid"]

    @cached_property
    def size(self) -> float:
        """Diagonal of all facets, model units."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @cached_property
    def _uses(self) -> Counter[str]:
        return Counter(entity.name for entity in self.entities.values() if entity.name)

    def has_own_name(self, key: str) -> bool:
        """Whether the model's name for an entity names nothing else."""
        entity = self.entities[key]
        return bool(entity.name) and self._uses[entity.name] == 1

    def id_word(self, key: str) -> str:
        """The word for an entity by number: ``"face 7"``, in an assembly ``"pin: face 7"``; a solid's name."""
        entity = self.entities[key]
        if entity.kind == "solid":
            return entity.name
        word = f"{entity.kind} {entity.id}"
        return word if len(self.solids) == 1 else f"{self.solids[entity.solid].name}: {word}"

    def label(self, key: str) -> str:
        """What lists call an entity."""
        entity = self.entities[key]
        return entity.name or f"{entity.kind} {entity.id}"


def same_kind(part: PartData, keys: Iterable[str]) -> list[str]:
    """Everything of the kind and shape of what is picked: all planes, all circles."""
    shapes = {(part.entities[key].kind, part.entities[key].shape) for key in keys}
    return [key for key, entity in part.entities.items() if (entity.kind, entity.shape) in shapes]


def all_tangent(part: PartData, keys: Iterable[str]) -> list[str]:
    """What is picked, with every face that is reached across edges along which faces are tangent; edges likewise end
    to end."""
    found = dict.fromkeys(keys)
    waiting = list(found)
    while waiting:
        key = waiting.pop()
        for near in _tangent_to(part, key):
            if near not in found:
                found[near] = None
                waiting.append(near)
    return list(found)


def _tangent_to(part: PartData, key: str) -> list[str]:
    entity = part.entities[key]
    if entity.kind == "face":
        edges = [part.entities[edge] for edge in entity.neighbours]
        return [face for edge in edges if edge.tangent for face in edge.neighbours]
    if entity.kind == "edge":
        faces = [part.entities[face] for face in entity.neighbours]
        others = dict.fromkeys(edge for face in faces for edge in face.neighbours if edge != key)
        return [other for other in others if _continues(part.chains[key], part.chains[other])]
    return []


_STRAIGHT = 0.99
"""Cosine of the turn between two edges up to which one goes on in the other."""


def _continues(one: FloatArray, other: FloatArray) -> bool:
    """Whether one chain of points goes on in another without a corner."""
    size = max(float(np.ptp(one, axis=0).max()), float(np.ptp(other, axis=0).max()))
    for a, before in ((one[0], one[1]), (one[-1], one[-2])):
        for b, after in ((other[0], other[1]), (other[-1], other[-2])):
            if np.linalg.norm(a - b) > 1e-6 * size:
                continue
            u, v = a - before, after - b
            length = float(np.linalg.norm(u) * np.linalg.norm(v))
            if length and float(u @ v) > _STRAIGHT * length:
                return True
    return False


def tree_rows(part: PartData, names: Mapping[str, str]) -> list[dict[str, object]]:
    """Rows of the tree: key, depth, label, what it is, size; `names` are those of the session, by key."""
    rows: list[dict[str, object]] = []
    for key, entity in part.entities.items():
        unit = {"solid": "mm³", "face": "mm²", "edge": "mm"}[entity.kind]
        rows.append(
            {
                "key": key,
                "kind": entity.kind,
                "solid": entity.solid,
                "label": names.get(key) or part.label(key),
                "number": entity.id,
                "shape": entity.shape,
                "size": f"{entity.measure:.4g} {unit}",
                "color": entity.color,
            }
        )
    return rows


def described(part: PartData, keys: Sequence[str], names: Mapping[str, str], most: int = 3) -> str:
    """What is picked, in a few words; `names` are those of the session, by key."""
    if not keys:
        return "nothing"
    words = [names.get(key) or part.label(key) for key in keys[:most]]
    more = f" and {len(keys) - most} more" if len(keys) > most else ""
    return ", ".join(words) + more
