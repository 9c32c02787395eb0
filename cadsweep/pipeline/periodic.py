"""Faces whose meshes answer each other node by node: sectors, representative volumes, cascades.

The motion that carries one face to the other is found from the CAD model and checked on all its edges. Both faces get
equal counts, and the nodes of the second are the images of those of the first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from .. import cad
from ..arrays import FloatArray, IntArray
from ..brep import Edge, Face, Part, Solid
from ..errors import InputError, SurfaceMeshError
from ..options import SweepOptions
from ..surface import Division, Motion, turned
from ..sweep import Intervals, Sweep

SAME = 1e-5
"""Distance, in sizes of the part, up to which a face carried to another one lies on it."""
_SAMPLES = 5
"""Places along an edge that must answer places on the other face."""
_PARALLEL = 1e-9
"""Sine of the angle of two normals below which they are parallel."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Match:
    """Two faces, or groups of faces, and the motion from the first to the second.

    Attributes
    ----------
    words : (str, str)
        What the user calls them.
    faces : (frozenset of int, frozenset of int)
    motion : Motion
    edges : dict of int to (int, bool)
        Edge of the first to that of the second, and whether it runs from start to start.
    """

    words: tuple[str, str]
    faces: tuple[frozenset[int], frozenset[int]]
    motion: Motion
    edges: dict[int, tuple[int, bool]]


def find_matches(part: Part, sweep: Sweep, options: SweepOptions) -> tuple[Match, ...]:
    """The matched faces of a sweep.

    Raises
    ------
    InputError
        A name that no face has, faces that no translation or rotation carries to each other, or faces that are
        neither both sides nor the two caps of the sweep.
    """
    found = []
    for one, other in (options.periodic or {}).items():
        faces = tuple(frozenset(cad.select_faces(part, word)) for word in (one, other))
        _check_roles(sweep, faces[0], faces[1], (str(one), str(other)))
        found.append(_match(sweep.solid, (faces[0], faces[1]), (str(one), str(other))))
    return tuple(found)


def _check_roles(sweep: Sweep, first: frozenset[int], second: frozenset[int], words: tuple[str, str]) -> None:
    sides = {side.face for side in sweep.linking_sides}
    caps = {frozenset(sweep.source), frozenset(sweep.target)}
    if first & second:
        raise InputError(f"periodic: '{words[0]}' and '{words[1]}' have a face in common")
    if (first <= sides and second <= sides) or {first, second} == caps:
        return
    raise InputError(
        f"periodic: '{words[0]}' and '{words[1]}' are neither both sides of the sweep from "
        f"{sweep.solid.faces[sweep.source[0]].label()} nor its two caps: choose the caps with source and target"
    )


def _match(solid: Solid, faces: tuple[frozenset[int], frozenset[int]], words: tuple[str, str]) -> Match:
    one, other = ([solid.faces[f] for f in sorted(own)] for own in faces)
    near = SAME * solid.size + solid.tolerance
    for motion in motions_between(one, other):
        ours, theirs = ({e: solid.edges[e] for face in own for e in face.edges} for own in (one, other))
        edges, alone = edge_images(ours, theirs, motion, near)
        if not alone:
            return Match(words=words, faces=faces, motion=motion, edges=edges)
    raise InputError(
        f"periodic: no translation or rotation carries '{words[0]}' to '{words[1]}': their outlines differ"
    )


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


def tied_counts(
    sweep: Sweep, matches: Sequence[Match], counts: Intervals, demanded: Mapping[tuple[int, ...], int]
) -> dict[tuple[int, ...], int]:
    """Counts that make matched edges around the loops equal, beside those that are demanded.

    Raises
    ------
    InputError
        Two edges that answer each other are asked to have unlike counts.
    """
    single = {edges[0]: n for edges, n in demanded.items() if len(edges) == 1}
    rails = set(sweep.rails)
    found: dict[tuple[int, ...], int] = {}
    for match in matches:
        for a, (b, _) in match.edges.items():
            if a == b or a in rails or b in rails:
                continue
            asked = {single[e] for e in (a, b) if e in single}
            if len(asked) > 1:
                labels = " and ".join(sweep.solid.edges[e].label() for e in (a, b))
                raise InputError(f"periodic: {labels} answer each other, and are asked to have unlike counts")
            n = asked.pop() if asked else max(int(counts.counts[a]), int(counts.counts[b]))
            found |= {(e,): n for e in (a, b) if e not in single and counts.counts[a] != counts.counts[b]}
    return found


def with_images(matches: Sequence[Match], divisions: Mapping[int, Division]) -> dict[int, Division]:
    """The divisions of edges, and of those that answer them on matched faces."""
    found = dict(divisions)
    for match in matches:
        for a, (b, same) in match.edges.items():
            for one, other in ((a, b), (b, a)):
                if one in divisions and other not in divisions:
                    found[other] = divisions[one] if same else turned(divisions[one])
    return found


def side_motions(sweep: Sweep, matches: Sequence[Match]) -> list[tuple[frozenset[int], frozenset[int], Motion]]:
    """Matches of sides, for the surface stage."""
    sides = {side.face for side in sweep.linking_sides}
    return [(*match.faces, match.motion) for match in matches if match.faces[0] <= sides]


def cap_motion(sweep: Sweep, matches: Sequence[Match]) -> Motion | None:
    """The motion from the source to the target, where these are matched."""
    for match in matches:
        if match.faces[0] == frozenset(sweep.source):
            return match.motion
        if match.faces[0] == frozenset(sweep.target):
            return match.motion.inverse()
    return None


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
