"""How hexahedra and quads hang together: shared faces, boundary surface, duplicates, stray nodes.

Place in the flow: :mod:`cadsweep.quality.check` calls these and turns their numbers into sentences.

Method. A face is found again by its least node: every node keeps a short chain of the faces whose
least node it is, so one pass over the hexahedra finds every face's one or two users in linear time,
without sorting and without storing the faces. A mesh that is one sweep needs none of it
(:mod:`cadsweep.quality.structure`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, distinct
from ..cells import HEX_FACES
from ..compiled import compiled
from . import surface_kernels

_FACES = HEX_FACES.copy()
_ITSELF = np.arange(4)[None]
"""The face of a quad."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FaceUse:
    """Users of the hexahedra's faces; a face is ``6 * hex + row of mesh.HEX_FACES``.

    Attributes
    ----------
    once : (b,) int64
        Faces with one user.
    crowded : (c,) int64
        Faces that come third or later on the same nodes.
    clashing : (d,) int64
        Faces whose partner has the same nodes, and turns the same way or in another order.
    first, partner : (p,) integers
        Faces with two users: those of the one, and of the other. Those of which it is known that both are of one block
        may be missing.
    """

    once: IntArray
    crowded: IntArray
    clashing: IntArray
    first: npt.NDArray[np.signedinteger]
    partner: npt.NDArray[np.signedinteger]

    def of(self, faces: IntArray) -> FaceUse:
        """The same, where what was matched are rows of some faces."""
        return FaceUse(
            once=faces[self.once],
            crowded=faces[self.crowded],
            clashing=faces[self.clashing],
            first=faces[self.first],
            partner=faces[self.partner],
        )


@compiled(cache=True, nogil=True)
def _match(hexes, n_nodes, faces, follower, first, partner, crowded, clashing):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917
    """Chain the faces by their least node; return how many chains' entries, crowded and clashing there are."""
    head = np.full(n_nodes, -1, dtype=follower.dtype)
    n, n_crowded, n_clashing = 0, 0, 0
    n_faces = faces.shape[0]
    for h in range(hexes.shape[0]):
        for f in range(n_faces):
            p = 0
            for c in range(1, 4):
                if hexes[h, faces[f, c]] < hexes[h, faces[f, p]]:
                    p = c
            least = hexes[h, faces[f, p]]
            after = hexes[h, faces[f, (p + 1) % 4]]
            across = hexes[h, faces[f, (p + 2) % 4]]
            before = hexes[h, faces[f, (p + 3) % 4]]
            at = head[least]
            while at >= 0:
                hh = first[at] // n_faces
                ff = first[at] % n_faces
                pp = 0
                while hexes[hh, faces[ff, pp]] != least:
                    pp += 1
                a = hexes[hh, faces[ff, (pp + 1) % 4]]
                o = hexes[hh, faces[ff, (pp + 2) % 4]]
                b = hexes[hh, faces[ff, (pp + 3) % 4]]
                if a == before and o == across and b == after:
                    opposite = True
                    break
                # The same three nodes in another order: three different ones out of three.
                if a + o + b == after + across + before and (
                    (a == after and o == before)
                    or (a == across and o in (after, before))
                    or (a == before and o == after)
                    or (a == after and o == across)
                ):
                    opposite = False
                    break
                at = follower[at]
            if at < 0:
                first[n] = n_faces * h + f
                partner[n] = -1
                follower[n] = head[least]
                head[least] = n
                n += 1
            elif partner[at] >= 0:
                if n_crowded < len(crowded):
                    crowded[n_crowded] = n_faces * h + f
                n_crowded += 1
            else:
                partner[at] = n_faces * h + f
                if not opposite:
                    if n_clashing < len(clashing):
                        clashing[n_clashing] = n_faces * h + f
                    n_clashing += 1
    return n, n_crowded, n_clashing


def match_faces(hexes: IntArray, n_nodes: int) -> FaceUse:
    """Find the users of every face.

    Parameters
    ----------
    hexes : (m, 8 or more) int64
        Indices in [0, n_nodes).
    n_nodes : int
    """
    return _use(hexes, n_nodes, _FACES)


def match_quads(quads: IntArray, n_nodes: int) -> FaceUse:
    """Find the users of faces that are quads (q, 4) of hexahedra, outward; a face is a row of them."""
    return _use(quads, n_nodes, _ITSELF)


def _use(cells: IntArray, n_nodes: int, faces: IntArray) -> FaceUse:
    """Who has the faces of cells, each of them ``len(faces) * cell + row of faces``."""
    n_faces = len(faces) * len(cells)
    kind = np.int32 if n_faces < 2**31 else np.int64
    follower, first, partner, crowded, clashing = (np.empty(n_faces, dtype=kind) for _ in range(5))
    n, n_crowded, n_clashing = _match(cells, n_nodes, faces, follower, first, partner, crowded, clashing)
    alone = np.less(partner[:n], 0)
    shared = ~alone
    return FaceUse(
        once=np.sort(first[:n][alone].astype(np.int64)),
        crowded=crowded[:n_crowded].astype(np.int64),
        clashing=clashing[:n_clashing].astype(np.int64),
        first=first[:n][shared],
        partner=partner[:n][shared],
    )


def face_nodes(hexes: IntArray, faces: IntArray) -> IntArray:
    """Corner nodes (b, 4) of faces given as ``6 * hex + row``, outward."""
    hex_of, row = np.divmod(faces, 6)
    # By places in the flat array: a third of the time of rows and columns.
    return hexes.reshape(-1).take((hexes.shape[1] * hex_of)[:, None] + HEX_FACES.take(row, axis=0))


@compiled(cache=True, nogil=True)
def _scan_hexes(hexes, n_nodes, used):  # type: ignore[no-untyped-def]
    """Mark used nodes; count hexes with indices out of range, and with repeated nodes; the first of each."""
    outside, repeated, first_outside, first_repeated = 0, 0, -1, -1
    width = hexes.shape[1]
    for h in range(hexes.shape[0]):
        fits = True
        for i in range(width):
            node = hexes[h, i]
            if node < 0 or node >= n_nodes:
                fits = False
            else:
                used[node] = True
        if not fits:
            outside += 1
            if first_outside < 0:
                first_outside = h
        same = False
        for i in range(width):
            for j in range(i):
                if hexes[h, i] == hexes[h, j]:
                    same = True
        if same:
            repeated += 1
            if first_repeated < 0:
                first_repeated = h
    return outside, first_outside, repeated, first_repeated


def scan_hexes(hexes: IntArray, n_nodes: int) -> tuple[tuple[int, int, int, int], np.ndarray]:
    """Count hexes with indices out of range and with repeated nodes, the first of each, and used nodes (n,) bool."""
    used = np.zeros(n_nodes, dtype=np.bool_)
    return _scan_hexes(hexes, n_nodes, used), used


@compiled(cache=True, nogil=True)
def _hash_rows(rows, keys):  # type: ignore[no-untyped-def]
    """A key of each row that does not depend on the order of its entries."""
    for r in range(rows.shape[0]):
        total = np.uint64(0)
        for c in range(rows.shape[1]):
            # splitmix64: neighbouring numbers become unrelated ones.
            x = np.uint64(rows[r, c]) + np.uint64(0x9E3779B97F4A7C15)
            x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            total += x ^ (x >> np.uint64(31))
        keys[r] = total


def row_keys(rows: IntArray) -> np.ndarray:
    """A 64-bit value (m,) of each row, whatever the order of its entries; a pair of unlike rows shares one in 2^64."""
    keys = np.empty(len(rows), dtype=np.uint64)
    _hash_rows(np.ascontiguousarray(rows, dtype=np.int64), keys)
    return keys.view(np.int64)  # numpy 2.0 cannot look for unsigned ones among others


def duplicate_rows(rows: IntArray) -> list[tuple[int, int]]:
    """Pairs of rows with the same entries in any order, each row paired with the first of its kind."""
    keys = row_keys(rows)
    ordered = np.sort(keys)
    if not np.any(ordered[1:] == ordered[:-1]):
        return []
    repeated = distinct(ordered[1:][ordered[1:] == ordered[:-1]])
    suspects = np.flatnonzero(np.isin(keys, repeated))
    seen: dict[tuple[int, ...], int] = {}
    pairs = []
    for r in suspects:
        key = tuple(sorted(rows[r].tolist()))
        if key in seen:
            pairs.append((seen[key], int(r)))
        else:
            seen[key] = int(r)
    return pairs


def coincident_pairs(points: FloatArray, distance: float, *, most: int = 1000) -> list[tuple[int, int]]:
    """Pairs of points nearer to each other than `distance`, at most about `most`.

    The points are sorted along one oblique direction; only neighbours in that order can be close.
    """
    sound = np.isfinite(points)
    ids = np.arange(len(points)) if sound.all() else np.flatnonzero(sound.all(axis=1))
    along = points.take(ids, axis=0) @ np.array([0.5377, 0.6173, 0.5741])
    ordered = np.sort(along)  # of values alone: a tenth of what sorting their places takes
    near = ordered[1:] - ordered[:-1] <= distance
    if not near.any():
        return []
    suspects = np.isin(along, np.concatenate([ordered[1:][near], ordered[:-1][near]]))
    ids, along = ids[suspects], along[suspects]
    order = np.argsort(along)
    along, ids = along[order], ids[order]
    pairs: list[tuple[int, int]] = []
    for step in range(1, len(ids)):
        near = np.flatnonzero(along[step:] - along[:-step] <= distance)
        if not len(near) or len(pairs) >= most:
            break
        a, b = ids[near], ids[near + step]
        close = np.linalg.norm(points[a] - points[b], axis=1) <= distance
        pairs += [(min(i, j), max(i, j)) for i, j in zip(a[close].tolist(), b[close].tolist(), strict=True)]
    return pairs


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceShape:
    """Topology of a surface of quads.

    Attributes
    ----------
    euler : int
        Nodes - edges + quads.
    open_edges : (e, 2) int64
        Edges that do not have exactly two quads which run through them in opposite directions.
    pinched_nodes : (p,) int64
        Nodes at which several sheets of the surface meet.
    """

    euler: int
    open_edges: IntArray
    pinched_nodes: IntArray


def surface_shape(quads: IntArray) -> SurfaceShape:
    """Find out whether quads (b, 4) with indices from 0 form a closed, oriented 2-manifold."""
    n_nodes = int(np.max(quads, initial=-1)) + 1
    used = np.zeros(n_nodes, dtype=np.bool_)
    used[quads] = True
    mates = np.empty(4 * len(quads), dtype=np.int64)
    n_edges = surface_kernels.pair_edges(quads, n_nodes, mates)
    sheets = np.empty(n_nodes, dtype=np.int64)
    surface_kernels.count_sheets(quads, n_nodes, mates, sheets)
    lone = np.flatnonzero(mates < 0)
    ends = np.stack([quads.ravel()[lone], quads[lone // 4, (lone + 1) % 4]], axis=1)
    return SurfaceShape(
        euler=int(np.count_nonzero(used)) - n_edges + len(quads),
        open_edges=np.unique(np.sort(ends, axis=1), axis=0) if len(lone) else ends,
        pinched_nodes=np.flatnonzero(sheets > 1),
    )
