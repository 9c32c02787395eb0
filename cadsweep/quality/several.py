"""Surfaces of a mesh of several parts, each checked by itself.

Place in the flow: called by :func:`cadsweep.quality.check.check_mesh` where a mesh has several parts, because two
parts that touch along an edge are legitimate although the boundary of both together is no 2-manifold there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..cells import BlockStructure
from ..mesh import HexMesh
from . import conformity
from .boundary import place, quad_keys
from .conformity import FaceUse
from .metrics import volume_and_area
from .overlap import BoundaryCrossing, describe_crossings, find_crossings


@dataclass(frozen=True, kw_only=True, eq=False)
class PartSurface:
    """The surface of one part.

    Attributes
    ----------
    name : str
    quads : (q, 4) int64
        Outward, those between parts included.
    named : dict of str to (p, 4 or more) int64
        Those that have a name, as boundary or as interface, with their middle nodes; all turned outward from this part.
    volume : float
        Enclosed by the surface.
    """

    name: str
    quads: IntArray
    named: dict[str, IntArray]
    volume: float


def part_surfaces(mesh: HexMesh, use: FaceUse | None = None) -> list[PartSurface]:
    """Split the surface of a mesh by parts; parts that overlap are left out.

    `use`: of the faces of its hexahedra, where that is known.
    """
    part, alone = _part_of(mesh)
    if not alone:
        return []
    n, hexes = max(mesh.n_nodes, 1), mesh.hexes
    use = use or conformity.match_faces(hexes, n)
    if len(use.crowded):  # who is whose partner is another question in every part
        quads = []
        for ids in mesh.parts.values():
            own = np.ascontiguousarray(hexes[ids, :8])
            quads.append(conformity.face_nodes(own, conformity.match_faces(own, n).once))
    else:
        first, partner = _between(use, part)
        faces = np.concatenate([use.once, first, partner])
        owners = part[faces // 6]
        order = np.lexsort((faces, owners))
        starts = np.searchsorted(owners[order], np.arange(len(mesh.parts) + 1))
        every = conformity.face_nodes(hexes, faces[order])
        quads = [every[a:b] for a, b in pairwise(starts.tolist())]
    named = name_quads(quads, mesh.named_quads())
    return [
        PartSurface(name=name, quads=own, named=own_named, volume=volume_and_area(mesh.points, own)[0])
        for name, own, own_named in zip(mesh.parts, quads, named, strict=True)
    ]


def _part_of(mesh: HexMesh) -> tuple[IntArray, bool]:
    """The part (m,) of every hexahedron, -1 where it is in none, and whether none is in several."""
    part = np.full(mesh.n_hexes, -1, dtype=np.int64)
    alone = True
    for j, ids in enumerate(mesh.parts.values()):
        alone &= not (part[ids] >= 0).any()
        part[ids] = j
    return part, alone


def _between(use: FaceUse, part: IntArray) -> tuple[IntArray, IntArray]:
    """Faces whose two hexahedra are in different parts, those of the one and those of the other."""
    apart = part[use.first // 6] != part[use.partner // 6]
    return use.first[apart].astype(np.int64), use.partner[apart].astype(np.int64)


def lie_in_parts(mesh: HexMesh, blocks: Sequence[BlockStructure]) -> bool:
    """Whether the hexahedra of every block are all in the same part."""
    part, _ = _part_of(mesh)
    return all(
        (part[block.first_hex : block.first_hex + block.n_hexes] == part[block.first_hex]).all() for block in blocks
    )


def name_quads(surfaces: Sequence[IntArray], names: Mapping[str, IntArray]) -> list[dict[str, IntArray]]:
    """Quads of each of several surfaces that have a name, by name, turned as in the surface.

    Names are looked for among the quads of all surfaces, once: of hundreds of parts nearly none has a name.
    """
    found: list[dict[str, IntArray]] = [{} for _ in surfaces]
    given = [(name, np.asarray(own)) for name, own in names.items() if len(own)]
    if not given or not any(map(len, surfaces)):
        return found
    every = np.concatenate(list(surfaces))
    part_of = np.repeat(np.arange(len(surfaces)), [len(own) for own in surfaces])
    keys = conformity.row_keys(every)
    order = np.argsort(keys)
    # All names at once: which quad of which name is at which row.
    own_keys = conformity.row_keys(np.concatenate([own[:, :4] for _, own in given]))
    by_key = np.argsort(own_keys)
    name_of = np.repeat(np.arange(len(given)), [len(own) for _, own in given])[by_key]
    row_of = np.concatenate([np.arange(len(own)) for _, own in given])[by_key]
    keys, own_keys = keys[order], own_keys[by_key]  # both ascending: a search goes ahead in memory
    first, last = (np.searchsorted(keys, own_keys, side=side) for side in ("left", "right"))
    times = last - first  # 2 where a quad is between two parts
    at = order[np.repeat(last - np.cumsum(times), times) + np.arange(times.sum())]
    # By name, part and row, and a quad that a name has twice once.
    places = (np.repeat(name_of, times) * len(surfaces) + part_of[at]) * len(every) + at
    sorting = np.argsort(places)  # as one number: a lexical sort takes ten times as long
    places = places[sorting]
    sorting = sorting[np.concatenate([[True], places[1:] != places[:-1]])]
    name, row, part, at = (
        np.repeat(name_of, times)[sorting],
        np.repeat(row_of, times)[sorting],
        part_of[at[sorting]],
        at[sorting],
    )
    starts = np.flatnonzero(np.diff(name * len(surfaces) + part, prepend=-1))
    for a, b in pairwise([*starts.tolist(), len(at)]):
        called, own = given[int(name[a])]
        mine = every[at[a:b]]
        found[int(part[a])][called] = _turned_like(mine, own[row[a:b]]) if own.shape[1] > 4 else mine
    return found


def _turned_like(corners: IntArray, quads: IntArray) -> IntArray:
    """Quads with middle nodes (q, 8 or 9), turned over where their corners (q, 4) go the other way round."""
    rows = np.arange(len(quads))
    after = corners[rows, (np.argmax(corners == quads[:, :1], axis=1) + 1) % 4]
    turned = quads[:, [0, 3, 2, 1, 7, 6, 5, 4, *range(8, quads.shape[1])]]
    return np.where((after == quads[:, 1])[:, None], quads, turned)


def crossings_apart(
    points: FloatArray,
    surfaces: Sequence[PartSurface],
    boundaries: Mapping[str, IntArray],
    contacts: Mapping[str, tuple[str, str]],
) -> tuple[BoundaryCrossing, ...]:
    """Find where parts cross each other that are in no contact with each other; each by itself is another question.

    Two parts in contact that were meshed each by itself have facets of their own on one curved face, which cross.

    Parameters
    ----------
    points : (n, 3) float64
    surfaces : sequence of PartSurface
    boundaries : mapping of str to (q, 4 or more) int64
    contacts : mapping of str to (str, str)
        Parts in contact, by the name of the contact.
    """
    between = {f"{name}_{side}" for name in contacts for side in (1, 2)}
    ignored = np.sort(
        np.concatenate([conformity.row_keys(np.asarray(boundaries[name])[:, :4]) for name in sorted(between)])
    )
    owners = np.repeat(np.arange(len(surfaces)), [len(own.quads) for own in surfaces])
    quads = np.concatenate([own.quads for own in surfaces])
    # Without the contacts themselves, whose crossings could hide the others.
    kept = np.flatnonzero(~np.isin(conformity.row_keys(quads), ignored))
    pairs, places = find_crossings(points, quads[kept])
    names = [own.name for own in surfaces]
    touching = {frozenset(pair) for pair in contacts.values()}
    by_pair = [frozenset((names[a], names[b])) for a, b in owners[kept[pairs]].tolist()]
    wrong = np.array([len(pair) > 1 and pair not in touching for pair in by_pair], dtype=bool)
    return describe_crossings(points, quads[kept], boundaries, pairs[wrong], places[wrong])


def interface_problems(mesh: HexMesh, use: FaceUse | None = None) -> list[str]:
    """Hold the named interfaces against the faces between hexahedra of different parts: each exactly once.

    `use`: of the faces of its hexahedra, where that is known.
    """
    if not mesh.interfaces:
        return []
    use = use or conformity.match_faces(mesh.hexes, mesh.n_nodes)
    quads = conformity.face_nodes(mesh.hexes, _between(use, _part_of(mesh)[0])[0])
    given = distinct(conformity.row_keys(np.concatenate([np.asarray(q)[:, :4] for q in mesh.interfaces.values()])))
    return _hold_interfaces(mesh.points, quads, conformity.row_keys(quads), given)


def fit_surfaces(quads: IntArray) -> tuple[IntArray, list[str]]:
    """Put closed surfaces together at the quads that two of them have, in opposite directions.

    Parameters
    ----------
    quads : (q, 4) int64
        Of all surfaces, outward from each.

    Returns
    -------
    rows : (r,) int64
        Which of them are left, the surface of the whole, ascending.
    problems : list of str
        What does not fit.
    """
    n = int(quads.max(initial=0)) + 1
    keys = conformity.row_keys(quads)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]]))
    uses = np.diff(np.append(starts, len(keys)))
    problems = []
    if (uses > 2).any():
        problems.append(f"{int((uses > 2).sum())} times a face has more than two hexahedra")
    pairs = starts[uses == 2]
    one, other = (np.stack(quad_keys(turned, n)) for turned in (quads[order[pairs]], quads[order[pairs + 1]][:, ::-1]))
    clashing = int((one != other).any(axis=0).sum())
    if clashing:
        problems.append(f"{clashing} faces are shared by hexahedra that turn the same way round on them")
    return np.sort(order[starts[uses == 1]]), problems


def shared_problems(
    points: FloatArray, surfaces: Sequence[PartSurface], interfaces: Mapping[str, IntArray]
) -> list[str]:
    """What :func:`interface_problems` says, known from the surfaces of the parts alone."""
    if not interfaces:
        return []
    every = np.concatenate([own.quads for own in surfaces])
    keys, first, uses = np.unique(conformity.row_keys(every), return_index=True, return_counts=True)
    given = distinct(conformity.row_keys(np.concatenate(list(interfaces.values()))))
    return _hold_interfaces(points, every[first[uses > 1]], keys[uses > 1], given)


def _hold_interfaces(points: FloatArray, quads: IntArray, wanted: np.ndarray, given: np.ndarray) -> list[str]:
    """Hold quads (q, 4) between parts, with their keys, against the keys of those that have a name."""
    if np.array_equal(np.sort(wanted), given):
        return []
    missing = ~np.isin(wanted, given)
    foreign = int(np.count_nonzero(~np.isin(given, wanted)))
    problems = []
    if missing.any():
        problems.append(
            f"{int(missing.sum())} quads between parts are in no interface, the first is at "
            f"{place(points[quads[np.flatnonzero(missing)[0]]].mean(axis=0))}"
        )
    if foreign:
        problems.append(f"{foreign} quads of interfaces are not between two parts")
    return problems
