"""Surfaces of a mesh of several parts, each checked by itself.

Place in the flow: called by :func:`cadsweep.quality.check.check_mesh` where a mesh has several parts, because two
parts that touch along an edge are legitimate although the boundary of both together is no 2-manifold there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..mesh import HexMesh
from . import conformity
from .boundary import place, quad_keys
from .metrics import enclosed_volume
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


def part_surfaces(mesh: HexMesh) -> list[PartSurface]:
    """Split the surface of a mesh by parts; parts that overlap are left out."""
    uses = np.zeros(mesh.n_hexes, dtype=np.int64)
    for ids in mesh.parts.values():
        uses[ids] += 1
    if (uses > 1).any():
        return []
    n = max(mesh.n_nodes, 1)
    quads = []
    for ids in mesh.parts.values():
        own = np.ascontiguousarray(mesh.hexes[ids, :8])
        quads.append(conformity.face_nodes(own, conformity.match_faces(own, n).once))
    named = name_quads(quads, {**mesh.boundaries, **mesh.interfaces})
    return [
        PartSurface(name=name, quads=own, named=own_named, volume=enclosed_volume(mesh.points, own))
        for name, own, own_named in zip(mesh.parts, quads, named, strict=True)
    ]


def name_quads(surfaces: Sequence[IntArray], names: Mapping[str, IntArray]) -> list[dict[str, IntArray]]:
    """Quads of each of several surfaces that have a name, by name, turned as in the surface.

    Names are looked for among the quads of all surfaces, once: of hundreds of parts nearly none has a name.
    """
    every = np.concatenate([*surfaces, np.zeros((0, 4), dtype=np.int64)])
    part_of = np.repeat(np.arange(len(surfaces)), [len(own) for own in surfaces])
    keys = conformity.row_keys(every)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    found: list[dict[str, IntArray]] = [{} for _ in surfaces]
    for name, quads in ((name, np.asarray(own)) for name, own in names.items()):
        if not len(quads):
            continue
        own_keys = conformity.row_keys(quads[:, :4])
        wanted = distinct(own_keys)
        first, last = np.searchsorted(keys, wanted), np.searchsorted(keys, wanted, side="right")
        most = int((last - first).max(initial=0))  # 2 where the quads are between two parts
        rows = np.sort(np.concatenate([order[first[last - first > k] + k] for k in range(most)] or [order[:0]]))
        by_key = np.argsort(own_keys, kind="stable") if quads.shape[1] > 4 else None
        for part in np.unique(part_of[rows]).tolist():
            mine = every[rows[part_of[rows] == part]]
            if by_key is not None:
                same = by_key[np.searchsorted(own_keys[by_key], conformity.row_keys(mine))]
                mine = _turned_like(mine, quads[same])
            found[part][name] = mine
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


def interface_problems(mesh: HexMesh) -> list[str]:
    """Hold the named interfaces against the faces between hexahedra of different parts: each exactly once."""
    if not mesh.interfaces:
        return []
    part = np.full(mesh.n_hexes, -1, dtype=np.int64)
    for j, ids in enumerate(mesh.parts.values()):
        part[ids] = j
    faces = conformity.face_nodes(mesh.hexes, np.arange(6 * mesh.n_hexes))
    keys = conformity.row_keys(faces)
    order = np.argsort(keys)
    keys, owner = keys[order], np.repeat(part, 6)[order]
    pair = np.flatnonzero((keys[1:] == keys[:-1]) & (owner[1:] != owner[:-1]))
    given = distinct(conformity.row_keys(np.concatenate([np.asarray(q)[:, :4] for q in mesh.interfaces.values()])))
    return _hold_interfaces(mesh.points, faces[order[pair]], keys[pair], given)


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
