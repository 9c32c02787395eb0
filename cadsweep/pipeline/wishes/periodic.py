"""Faces whose meshes answer each other node by node: sectors, representative volumes, cascades.

The motion that carries one face, or group of faces, to the other is found from the CAD model and checked on their
outlines; what divides them inside is known when it is known what the part is made of. Both get equal counts, and the
nodes of the second are the images of those of the first: of pieces that cells have of them (:func:`partners_of`), and
of the walls of columns (:mod:`.periodic_walls`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ...arrays import FloatArray, IntArray
from ...brep import Edge, Face, Part
from ...errors import InputError, SurfaceMeshError
from ...options import SweepOptions
from ...surface import Motion, Partners
from .named_faces import Place, faces_called

SAME = 1e-5
"""Distance, in sizes of the part, up to which a face carried to another one lies on it."""
_SAMPLES = 9
"""Places along an edge that must answer places on the other face."""
_PARALLEL = 1e-9
"""Sine of the angle of two normals below which they are parallel."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Match:
    """Two groups of faces and what carries the first to the second.

    Attributes
    ----------
    words : (str, str)
        What the user calls them.
    places : (frozenset of (int, int), frozenset of (int, int))
        Cell and face.
    motion : Motion
    """

    words: tuple[str, str]
    places: tuple[frozenset[Place], frozenset[Place]]
    motion: Motion


def find_matches(part: Part, model: Part, options: SweepOptions) -> list[Match]:
    """The matched faces of a part, before it is known how its cells divide them.

    Raises
    ------
    InputError
        A name that no face has, or faces that no translation or rotation carries to each other.
    """
    found = []
    for one, other in (options.periodic or {}).items():
        words = (str(one), str(other))
        places = (faces_called(part, model, one), faces_called(part, model, other))
        for word, own in zip(words, places, strict=True):
            if not own:
                raise InputError(f"periodic: '{word}' lies between solids: there it is no boundary of the mesh")
        if places[0] & places[1]:
            raise InputError(f"periodic: '{words[0]}' and '{words[1]}' have a face in common")
        sets = [[part.solids[cell].faces[f] for cell, f in sorted(own)] for own in places]
        near = nearness(part)
        rims = [_rim(part, own) for own in places]
        for motion in motions_between(sets[0], sets[1]):
            back = motion.inverse()
            if _lies_on(rims[0], rims[1], motion, near) and _lies_on(rims[1], rims[0], back, near):
                found.append(Match(words=words, places=places, motion=motion))
                break
        else:
            raise no_motion(words)
    return found


def nearness(part: Part) -> float:
    """How far what is carried to something may be off it."""
    return SAME * max(solid.size for solid in part.solids) + max(solid.tolerance for solid in part.solids)


def no_motion(words: tuple[str, str]) -> InputError:
    return InputError(
        f"periodic: no translation or rotation carries '{words[0]}' to '{words[1]}': their outlines differ"
    )


def edges_of(part: Part, places: frozenset[Place]) -> dict[int, Edge]:
    """Edges of faces, by key."""
    return {
        int(part.solids[cell].edge_keys[e]): part.solids[cell].edges[e]
        for cell, f in sorted(places)
        for e in part.solids[cell].faces[f].edges
    }


def _rim(part: Part, places: frozenset[Place]) -> list[Edge]:
    """The edges that one of the faces alone has: the outline, whatever divides it inside."""
    seen = Counter(key for place in places for key in _outline(part, place))
    return [edge for key, edge in edges_of(part, places).items() if seen[key] == 1]


def _lies_on(rim: Sequence[Edge], other: Sequence[Edge], motion: Motion, near: float) -> bool:
    """Whether an outline is carried onto another one."""
    at = np.linspace(0.0, 1.0, _SAMPLES)
    image = motion(np.concatenate([edge.curve.evaluate(at) for edge in rim]))
    return bool((np.min([edge.curve.distance(image) for edge in other], axis=0) <= near).all())


def motions_between(one: Sequence[Face], other: Sequence[Face]) -> list[Motion]:
    """Translation, and rotation, from the centres and normals of two groups of faces of equal areas.

    The rotation comes first where both face the same way: matched faces look away from each other.
    """
    areas = [np.array([face.area for face in faces]) for faces in (one, other)]
    centers = [
        (np.array([f.center for f in faces]) * a[:, None]).sum(axis=0) / a.sum()
        for faces, a in zip((one, other), areas, strict=True)
    ]
    normals = []
    for faces, a in zip((one, other), areas, strict=True):
        total = (np.array([f.normal for f in faces]) * a[:, None]).sum(axis=0)
        normals.append(total / max(float(np.linalg.norm(total)), 1e-300))
    way = centers[1] - centers[0]
    found = [Motion(matrix=np.eye(3), shift=way)]
    axis = np.cross(normals[0], -normals[1])
    cosine = float(-normals[0] @ normals[1])
    if np.linalg.norm(axis) < _PARALLEL and cosine < 0:
        axis = np.cross(normals[0], way)  # half a turn: across the way from the one to the other
    sine = float(np.linalg.norm(axis))
    if sine > 1e-9:
        angle = float(np.arctan2(np.linalg.norm(np.cross(normals[0], normals[1])), cosine))
        matrix = scipy.spatial.transform.Rotation.from_rotvec(angle * axis / sine).as_matrix()
        found.insert(0 if cosine < 0 else 1, Motion(matrix=matrix, shift=centers[1] - matrix @ centers[0]))
    return found


def edge_images(
    ours: Mapping[int, Edge], theirs: Mapping[int, Edge], motion: Motion, near: float
) -> tuple[dict[int, tuple[int, bool]], list[int]]:
    """Which edge every edge is carried to, and whether they run alike; and those of either side without partner."""
    at = np.linspace(0.0, 1.0, _SAMPLES)
    targets = {e: edge.curve.evaluate(at) for e, edge in theirs.items()}
    found: dict[int, tuple[int, bool]] = {}
    for e, edge in ours.items():
        image = motion(edge.curve.evaluate(at))
        for t, points in targets.items():
            for same, seen in ((True, points), (False, points[::-1])):
                if np.linalg.norm(image - seen, axis=1).max() <= near:
                    found.setdefault(e, (t, same))
    alone = [e for e in ours if e not in found]
    return found, alone + [t for t in theirs if t not in {image for image, _ in found.values()}]


def pair_nodes(
    points: FloatArray, nodes: tuple[IntArray, IntArray], motion: Motion, words: tuple[str, str]
) -> IntArray:
    """Nodes (p, 2) of which the motion, in model units, carries the first to the second.

    Raises
    ------
    SurfaceMeshError
        A node has no partner.
    """
    first, second = nodes
    tree = scipy.spatial.cKDTree(points[second])
    far, index = tree.query(motion(points[first]))
    size = float(np.max(np.ptp(points, axis=0)))
    if len(first) != len(second) or len(np.unique(index)) != len(first) or float(np.max(far)) > SAME * size:
        raise SurfaceMeshError(
            f"periodic: the meshes of '{words[0]}' and '{words[1]}' do not answer each other: "
            f"{len(first)} and {len(second)} nodes, the farthest {float(np.max(far)):.3g} from its partner"
        )
    return np.column_stack([first, second[index]])


def partners_of(part: Part, matches: Sequence[Match]) -> list[Partners]:
    """Which edges and faces of the cells are the images of which.

    Raises
    ------
    SurfaceMeshError
        The cells divide two matched faces in different places; names the cell and the edge without an image.
    """
    found = []
    for match in matches:
        one, other = (edges_of(part, own) for own in match.places)
        edges, alone = edge_images(one, other, match.motion, nearness(part))
        if alone:
            raise _divided_differently(part, match, alone[0])
        by_edges = {_outline(part, place): place for place in match.places[1]}
        faces = {}
        for cell, f in match.places[0]:
            image = by_edges.get(frozenset(edges[key][0] for key in _outline(part, (cell, f))))
            if image is None:
                raise _divided_differently(part, match, min(_outline(part, (cell, f))))
            there, g = image
            faces[int(part.solids[cell].face_keys[f])] = int(part.solids[there].face_keys[g])
        found.append(Partners(motion=match.motion, edges=edges, faces=faces))
    return found


def _outline(part: Part, place: Place) -> frozenset[int]:
    cell, f = place
    solid = part.solids[cell]
    return frozenset(int(solid.edge_keys[e]) for e in solid.faces[f].edges)


def _divided_differently(part: Part, match: Match, key: int) -> SurfaceMeshError:
    for own, (word, partner), motion in zip(
        match.places, (match.words, match.words[::-1]), (match.motion, match.motion.inverse()), strict=True
    ):
        for cell, f in sorted(own):
            solid = part.solids[cell]
            if key in solid.edge_keys[list(solid.faces[f].edges)]:
                edge = solid.edges[solid.edge_keys.tolist().index(key)]
                where = solid.units.place(motion(edge.midpoint[None])[0])
                return SurfaceMeshError(
                    f"periodic: {edge.label()} divides {solid.faces[f].label()} of '{word}' (cell {cell} of "
                    f"'{part.models[part.owners[cell]].name}'), and nothing divides '{partner}' at its image, around "
                    f"({where}): cut there, too, with cuts"
                )
    raise AssertionError("the edge is on one of the faces")
