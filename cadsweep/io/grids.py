"""A mesh of hexahedra as structured blocks, as codes want them that compute by i, j and k.

Place in the flow: for :mod:`.plot3d` and :mod:`.cgns_grids`. It asks the finished mesh alone, so one sweep, columns,
cells and assemblies are the same to it.

Method. Walls between blocks are the mesh's boundary, the quads between two solids, and all quads at an edge inside that
has not four hexahedra. From each edge of a wall, to either side, a block may have one hexahedron or two: where it has
more, the quad after two becomes a wall, and so on from there, until walls meet. What lies between walls then has no
corner that points inwards, and is walked along its rows; one that closes on itself is opened where the walk began. A
wall that ends at another one leaves blocks whose sides meet in part, which is a patch of each.

Not handled: a mesh whose caps were not mapped has a wall at nearly every quad. A solid of more than `most` blocks is
refused, with the boundary that has most of the edges where walls begin.

References
----------
Brueckler, Gupta, Mandad, Campen, "The 3D motorcycle complex for structured volume decomposition", Comput. Graph. Forum
41 (2022): walls that end where they meet another.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ..arrays import IntArray
from ..cells import HEX_EDGES, HEX_FACES
from ..compiled import compiled
from ..errors import InputError
from .labels import LabelledMesh
from .pairing import edge_codes, neighbours

MOST_BLOCKS = 64
"""Blocks of one solid, unless the caller says another number: a shaft with a cross bore has 9, a plate with four holes
a dozen, a cap of 400 quads that was not mapped 140."""

_OPPOSITE = np.array([1, 0, 4, 5, 2, 3])
_TOWARDS = np.array([3, 4, 1])
"""Sides towards i, j and k."""


def _tables() -> tuple[IntArray, IntArray]:
    """The other side at each edge of a side; and the corner that three sides have in common, -1 where there is none."""
    sets = [set(face) for face in HEX_FACES.tolist()]
    other = np.empty((6, 4), dtype=np.int64)
    for side, face in enumerate(HEX_FACES.tolist()):
        for j in range(4):
            edge = {face[j], face[(j + 1) % 4]}
            other[side, j] = next(k for k in range(6) if k != side and edge <= sets[k])
    corner = np.full((6, 6, 6), -1, dtype=np.int64)
    for a, b, c in np.ndindex(6, 6, 6):
        common = sets[a] & sets[b] & sets[c]
        if len(common) == 1:
            corner[a, b, c] = common.pop()
    return other, corner


_OTHER, _CORNER = _tables()


@dataclass(frozen=True, kw_only=True, eq=False)
class Grids:
    """The blocks of a mesh.

    Attributes
    ----------
    shapes : (b, 3) int64
        Hexahedra of every block along i, j, k.
    first : (b + 1,) int64
        Where the hexahedra of a block begin, in `order` and `hexes`, i running fastest.
    order : (m,) int64
        Which hexahedron of the mesh each is.
    hexes : (m, 8) int64
        These, turned so that their edges 0-1, 0-3 and 0-4 lie along i, j and k.
    across : (6 m,) int64
        For each side of `hexes`, ``6 h + row of HEX_FACES``, that of the hexahedron beyond it; -1: none.
    """

    shapes: IntArray
    first: IntArray
    order: IntArray
    hexes: IntArray
    across: IntArray

    def nodes(self, block: int) -> IntArray:
        """Nodes (nk + 1, nj + 1, ni + 1) of a block."""
        ni, nj, nk = self.shapes[block].tolist()
        own = self.hexes[self.first[block] : self.first[block + 1]].reshape(nk, nj, ni, 8)
        nodes = np.empty((nk + 1, nj + 1, ni + 1), dtype=np.int64)
        for corner, (i, j, k) in enumerate(_IJK):
            nodes[tuple(slice(1, None) if step else slice(-1) for step in (k, j, i))] = own[..., corner]
        return nodes


_IJK = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


_found: WeakKeyDictionary[LabelledMesh, Grids] = WeakKeyDictionary()
"""Blocks of meshes that are being written: a file is compared with what it should be by making that again."""


def find_grids(mesh: LabelledMesh, *, most: int = MOST_BLOCKS) -> Grids:
    """The structured blocks of a mesh.

    Raises
    ------
    InputError
        A solid has more blocks than `most`, or one closes on itself with a twist.
    """
    if mesh in _found:
        return _found[mesh]
    hexes = mesh.hexes
    across = neighbours(hexes, len(mesh.points))
    solid = mesh.volumes.of_cell
    beyond = np.where(across >= 0, solid[across // 6], -1)
    walls = beyond != np.repeat(solid, 6)
    singular = _singular(hexes, walls, len(mesh.points))
    for side, face in enumerate(HEX_FACES.tolist()):
        edges = [j for j, edge in enumerate(HEX_EDGES.tolist()) if set(edge) <= set(face)]
        walls[side::6] |= singular[:, edges].any(axis=1)
    _spread(hexes, across, walls)
    shapes, order, framed, steps, fault = _walked(hexes, across, walls)
    if fault >= 0:
        x, y, z = mesh.points[hexes[fault]].mean(axis=0)
        raise InputError(f"the block at ({x:.6g}, {y:.6g}, {z:.6g}) closes on itself with a twist: it has no i, j, k")
    first = np.concatenate([[0], np.cumsum(shapes.prod(axis=1))])
    counts = np.bincount(solid[order[first[:-1]]], minlength=len(mesh.volumes.members))
    if counts.max() > most:
        raise InputError(_not_mapped(mesh, int(counts.argmax()), int(counts.max()), most, singular))
    _found[mesh] = Grids(shapes=shapes, first=first, order=order, hexes=framed, across=_framed(across, steps))
    return _found[mesh]


def _not_mapped(mesh: LabelledMesh, solid: int, count: int, most: int, singular: np.ndarray) -> str:
    """What to say of a solid of too many blocks: the boundary that most edges with another number than four end on."""
    hexes, edges = np.nonzero(singular & (mesh.volumes.of_cell == solid)[:, None])
    is_end = np.zeros(len(mesh.points), dtype=bool)
    is_end[mesh.hexes[hexes[:, None], HEX_EDGES[edges]]] = True
    ends = {
        name: int(np.count_nonzero(is_end[np.unique(mesh.quads[mesh.faces.named(name)])])) for name in mesh.faces.names
    }
    part = mesh.volumes.exclusive_names()[solid]
    where = max(ends, key=lambda name: ends[name], default="")
    of = f": boundary {where!r} has {ends[where]} nodes without four quads" if where and ends[where] else ""
    return (
        f"part {part!r} is not mapped: it falls into {count} structured blocks, more than {most}{of}; "
        f"write another format, or take max_blocks={count}"
    )


def _singular(hexes: IntArray, walls: np.ndarray, n_points: int) -> np.ndarray:
    """Whether each edge (m, 12) is on no wall, and not one of four hexahedra."""
    code, count = edge_codes(hexes, n_points)
    on_wall = np.zeros(len(count), dtype=bool)
    for side, face in enumerate(HEX_FACES.tolist()):
        edges = [j for j, edge in enumerate(HEX_EDGES.tolist()) if set(edge) <= set(face)]
        on_wall[code[walls[side::6]][:, edges]] = True
    return ((count != 4) & ~on_wall)[code]


@compiled(cache=True, nogil=True)
def _turned(hexes, across, side, near):  # type: ignore[no-untyped-def]
    """Beyond a side ``6 h + s``: the side, told alike, that goes on from the side `near` of h; -1: they are no pair."""
    h, s = side // 6, side % 6
    beyond = across[side]
    for j in range(4):
        if _OTHER[s, j] == near:
            a, b = hexes[h, HEX_FACES[s, j]], hexes[h, HEX_FACES[s, (j + 1) % 4]]
            g, t = beyond // 6, beyond % 6
            for k in range(4):
                c, d = hexes[g, HEX_FACES[t, k]], hexes[g, HEX_FACES[t, (k + 1) % 4]]
                if (a == c and b == d) or (a == d and b == c):
                    return 6 * g + _OTHER[t, k]
    return -1


@compiled(cache=True, nogil=True)
def _spread(hexes, across, walls):  # type: ignore[no-untyped-def]
    """Make walls (6 m,) of quads after which a block would go on around the edge of a wall for more than two."""
    rows = np.empty(len(walls), dtype=np.int64)
    n = 0
    for side in range(len(walls)):
        if walls[side]:
            rows[n] = side
            n += 1
    k = 0
    while k < n:
        h, s = rows[k] // 6, rows[k] % 6
        k += 1
        for j in range(4):
            near = 6 * h + _OTHER[s, j]
            if walls[near]:
                continue
            far = _turned(hexes, across, near, s)
            if walls[far]:
                continue
            for wall in (far, across[far]):
                walls[wall] = True
                rows[n] = wall
                n += 1


@compiled(cache=True, nogil=True)
def _step(hexes, across, walls, at, axis, sign):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Go from a hexahedron and its frame ``(h, side towards i, j, k)`` a step along an axis; h is -1 at a wall."""
    found = np.empty(4, dtype=np.int64)
    towards = at[1 + axis] if sign > 0 else _OPPOSITE[at[1 + axis]]
    side = 6 * at[0] + towards
    found[0] = -1 if walls[side] else across[side] // 6
    if found[0] >= 0:
        entered = across[side] % 6
        for other in range(3):
            if other != axis:
                found[1 + other] = _turned(hexes, across, side, at[1 + other]) % 6
        found[1 + axis] = _OPPOSITE[entered] if sign > 0 else entered
    return found


@compiled(cache=True, nogil=True)
def _begun(hexes, across, walls, seed):  # type: ignore[no-untyped-def]
    """The first hexahedron of a seed's block, with its frame, and the block's shape."""
    at = np.array([seed, _TOWARDS[0], _TOWARDS[1], _TOWARDS[2]])
    for axis in range(3):
        begin = at[0]
        found = _step(hexes, across, walls, at, axis, -1)
        while found[0] >= 0 and found[0] != begin:
            at = found
            found = _step(hexes, across, walls, at, axis, -1)
    shape = np.ones(3, dtype=np.int64)
    for axis in range(3):
        found = _step(hexes, across, walls, at, axis, 1)
        while found[0] >= 0 and found[0] != at[0] and shape[axis] <= len(hexes):
            shape[axis] += 1
            found = _step(hexes, across, walls, found, axis, 1)
    return at, shape


@compiled(cache=True, nogil=True)
def _walked(hexes, across, walls):  # type: ignore[no-untyped-def]
    """Blocks: shapes (b, 3), hexahedra in their order, turned, their frames, and one that is in no block, else -1."""
    m = len(hexes)
    done = np.zeros(m, dtype=np.bool_)
    order, turned = np.empty(m, dtype=np.int64), np.empty((m, 8), dtype=np.int64)
    shapes, steps = np.empty((m, 3), dtype=np.int64), np.empty((m, 4), dtype=np.int64)
    n_blocks, n = 0, 0
    for seed in range(m):
        if done[seed]:
            continue
        at, shape = _begun(hexes, across, walls, seed)
        ni, nj = shape[0], shape[1]
        if n + shape.prod() > m:
            return shapes[:n_blocks], order, turned, steps, seed
        for place in range(shape.prod()):
            if place % ni > 0:
                at = _step(hexes, across, walls, steps[n + place - 1], 0, 1)
            elif place // ni % nj > 0:
                at = _step(hexes, across, walls, steps[n + place - ni], 1, 1)
            elif place > 0:
                at = _step(hexes, across, walls, steps[n + place - ni * nj], 2, 1)
            if at[0] < 0 or done[at[0]]:
                return shapes[:n_blocks], order, turned, steps, seed
            done[at[0]] = True
            order[n + place] = at[0]
            steps[n + place] = at
            for c in range(8):
                x = at[1] if c in (1, 2, 5, 6) else _OPPOSITE[at[1]]
                y = at[2] if c in (2, 3, 6, 7) else _OPPOSITE[at[2]]
                z = at[3] if c > 3 else _OPPOSITE[at[3]]
                turned[n + place, c] = hexes[at[0], _CORNER[x, y, z]]
        shapes[n_blocks] = shape
        n_blocks += 1
        n += shape.prod()
    return shapes[:n_blocks], order, turned, steps, -1


@compiled(cache=True, nogil=True)
def _framed(across, steps):  # type: ignore[no-untyped-def]
    """What is beyond each side (6 m,) of hexahedra that stand in the order, and are turned, as their frames say."""
    m = len(steps)
    place, row = np.empty(m, dtype=np.int64), np.empty((m, 6), dtype=np.int64)
    own = np.empty((m, 6), dtype=np.int64)
    for n in range(m):
        place[steps[n, 0]] = n
        for axis in range(3):
            for away in range(2):
                now = _OPPOSITE[_TOWARDS[axis]] if away else _TOWARDS[axis]
                before = _OPPOSITE[steps[n, 1 + axis]] if away else steps[n, 1 + axis]
                own[n, now], row[n, before] = before, now
    found = np.full(6 * m, -1, dtype=np.int64)
    for n in range(m):
        for side in range(6):
            beyond = across[6 * steps[n, 0] + own[n, side]]
            if beyond >= 0:
                other = place[beyond // 6]
                found[6 * n + side] = 6 * other + row[other, beyond % 6]
    return found
