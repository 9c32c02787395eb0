"""Nek5000 and NekRS, ``.re2``: elements, curved sides and conditions, binary.

Place in the flow: a format module of :mod:`cadsweep.io`. The file has the version ``#v003``: numbers of eight bytes,
and one set of conditions that Nek reads. An element is its eight corners, so node numbers are not kept, and Nek joins
what is at one place: a mesh with two nodes there is refused. Of order 2 the middle of every edge that is not straight
is a curved side ``m``, as Nek makes its 27 nodes from.

Every outer quad has a condition: a letter, ``MSH`` unless `letters` says another, and in its fifth number the
boundary's identifier, which is Nek's ``boundaryID``: boundaries in the mesh's order from 1, where they overlap their
disjoint blocks. Periodic ones are ``P`` with their partners. Quads between parts are inside for Nek and not written.
The element's group (``igroup``) is the part, from 0.

What Nek has no room for stands in a second set of conditions, which readers see as one of element 1 and Nek does not
read: 32 characters in the first four numbers, a number in the fifth, and as letter ``name`` (of a boundary, once for
each identifier), ``part`` (of a group) or ``nodes`` (of an element).

Reading knows files of either order of bytes and the versions 2 to 4, curved sides ``m`` alone. Corners that agree but
for rounding are one node.

References
----------
Nek5000, ``core/reader_re2.f``; documentation, "Mesh file (.re2)": corners, edges and sides 1 to 6 of an element.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import BinaryIO, Literal, cast

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..cells import HEX_EDGES
from ..errors import InputError, did_you_mean
from ..lattice import number_lattice
from ..mesh import HexMesh
from .compare import ExpectedBytes
from .labels import Blocks, LabelledMesh
from .periodic_faces import answering_quads
from .places import same_places
from .sides import count_users, find_sides, quads_of_sides, unnamed_sides
from .vtk_cells import write_bytes

MAX_NAME = 32
MOST_ORDER = 2
SIDES = np.array([5, 6, 1, 2, 3, 4])
"""Nek's number of the sides in the order of ``HEX_FACES``; its edges have the order of ``HEX_EDGES``."""

MOST_GROUPS = 11
"""Nek has material groups to 10."""

_TAG = 6.54321
_CHUNK = 1 << 14
_LETTERS = "MSH"
_RECORD = np.dtype([("hex", "<f8"), ("side", "<f8"), ("values", "<f8", 5), ("kind", "S8")])
_NEAR = 1e-6
"""Corners of other programs' files that are nearer than this, as a share of the shortest edge, are one."""


def write(
    stream: BinaryIO, mesh: LabelledMesh, *, letters: Mapping[str, str] | None = None, groups: bool = True
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    letters : mapping of str to str
        Nek's letters of boundaries: ``{"inlet": "v", "outlet": "O", "wall": "W"}``; the others' are ``MSH``.
    groups : bool
        Write parts as groups of elements; else all are of group 0, and parts are not kept.
    """
    _put(stream, mesh, letters or {}, groups)


def _put(stream: BinaryIO, mesh: LabelledMesh, letters: Mapping[str, str], groups: bool) -> None:
    size, m = mesh.hexes.shape[1], len(mesh.hexes)
    if size == 27:
        raise InputError("Nek has no hex27; make the mesh with order=2, nodes=20")
    for name, letter in letters.items():
        if name not in mesh.faces.names:
            raise InputError(f"there is no boundary {name!r} for the letter{did_you_mean(name, mesh.faces.names)}")
        if not 1 <= len(letter.encode()) <= 3:
            raise InputError(f"a letter of Nek has 1 to 3 characters, not {letter!r}")
    n_groups = len(mesh.volumes.members) if groups else 1
    if n_groups > MOST_GROUPS:
        raise InputError(
            f"Nek has {MOST_GROUPS} groups of elements, the mesh {n_groups} parts; write with groups=False"
        )
    corners = mesh.hexes[:, :8]
    joined, _ = same_places(mesh.points)
    if len(joined) < len(mesh.points):
        raise InputError("two nodes are at one place, which Nek joins; make the mesh with shared interfaces")
    stream.write(f"#v003{m:9d}{3:3d}{m:9d} cadsweep".ljust(80).encode() + np.array(_TAG, dtype="<f4").tobytes())
    of_hex = mesh.volumes.of_cell if groups else np.zeros(m, dtype=np.int64)
    for start in range(0, m, _CHUNK):
        own = corners[start : start + _CHUNK]
        rows = np.empty((len(own), 25), dtype="<f8")
        rows[:, 0] = of_hex[start : start + _CHUNK]
        rows[:, 1:] = mesh.points[own].transpose(0, 2, 1).reshape(len(own), 24)
        write_bytes(stream, rows)
    bent = _bent_edges(mesh)
    _write_records(stream, _records(bent[0] + 1, bent[1] + 1, mesh.points[mesh.hexes[bent[0], 8 + bent[1]]], b"m"))
    conditions, faces = _conditions(mesh, letters)
    _write_records(stream, conditions)
    tags = [(name, j, b"name") for name in faces.names for j, own in enumerate(faces.members, 1) if name in own]
    tags += [(name, j, b"part") for j, name in enumerate(mesh.volumes.exclusive_names() if groups else ())]
    _write_records(stream, np.concatenate([_tag(*tag) for tag in [("", size, b"nodes"), *tags]]))


def _bent_edges(mesh: LabelledMesh) -> tuple[IntArray, IntArray]:
    """Hex and edge of every edge whose middle is not that of its ends, bit for bit."""
    if mesh.hexes.shape[1] == 8:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    found = []
    for edge, (a, b) in enumerate(HEX_EDGES):
        middle = _middles(mesh.points[mesh.hexes[:, a]], mesh.points[mesh.hexes[:, b]])
        found.append((middle != mesh.points[mesh.hexes[:, 8 + edge]]).any(axis=1))
    hexes, edges = np.nonzero(np.stack(found, axis=1))
    return hexes, edges


def _middles(starts: FloatArray, ends: FloatArray) -> FloatArray:
    return 0.5 * starts + 0.5 * ends


def _conditions(mesh: LabelledMesh, letters: Mapping[str, str]) -> tuple[np.ndarray, Blocks]:
    """A record for every outer quad, and the blocks of the named ones; those of unnamed quads have the next number."""
    users = count_users(mesh.hexes, mesh.quads, len(mesh.points)) if len(mesh.quads) else np.empty(0, dtype=np.int64)
    outer = np.flatnonzero(users == 1)
    extra = unnamed_sides(mesh.hexes, mesh.quads, len(mesh.points))
    of, sides = (own[outer] for own in mesh.sides) if len(outer) else (outer, outer)
    block = mesh.faces.of_cell[outer]
    used = np.unique(block)
    members = tuple(mesh.faces.members[j] for j in used)
    names = tuple(name for name in mesh.faces.names if any(name in own for own in members))
    faces = Blocks(names=names, members=members, of_cell=np.searchsorted(used, block))
    chosen = [next((letters[name] for name in own if name in letters), _LETTERS) for own in (*members, ())]
    if len(extra):
        others = find_sides(mesh.hexes, extra, len(mesh.points))
        of, sides = np.concatenate([of, others[0]]), np.concatenate([sides, others[1]])
    number = np.concatenate([faces.of_cell, np.full(len(extra), len(members))])
    records = _records(of + 1, SIDES[sides], np.zeros((len(of), 3)), b"")
    records["values"][:, 4] = number + 1
    records["kind"] = np.array([f"{letter:<3}".encode() for letter in chosen], dtype="S8")[number]
    place = np.full(len(mesh.quads), -1, dtype=np.int64)
    place[outer] = np.arange(len(outer))
    for (one, other), pairs in mesh.periodic.items():
        here, there = mesh.faces.named(one), mesh.faces.named(other)
        order, _ = answering_quads(mesh.quads[here, :4], mesh.quads[there, :4], pairs)
        ends = place[here], place[there[order]]
        for rows, partners in (ends, ends[::-1]):
            records["kind"][rows] = b"P  "
            records["values"][rows, 0] = records["hex"][partners]
            records["values"][rows, 1] = records["side"][partners]
    return records, faces


def _records(hexes: IntArray, sides: IntArray, values: FloatArray, kind: bytes) -> np.ndarray:
    rows = np.zeros(len(hexes), dtype=_RECORD)
    rows["hex"], rows["side"], rows["kind"] = hexes, sides, kind
    rows["values"][:, :3] = values
    return rows


def _tag(text: str, number: int, kind: bytes) -> np.ndarray:
    rows = np.zeros(1, dtype=_RECORD)
    rows["hex"], rows["side"], rows["kind"] = 1, 1, kind.ljust(8)
    rows["values"][0, :4] = np.frombuffer(text.encode().ljust(32), dtype="<f8")
    rows["values"][0, 4] = number
    return rows


def _write_records(stream: BinaryIO, records: np.ndarray) -> None:
    stream.write(np.array(len(records), dtype="<f8").tobytes())
    write_bytes(stream, records.view(np.uint8))


def verify(
    stream: BinaryIO, mesh: LabelledMesh, *, letters: Mapping[str, str] | None = None, groups: bool = True
) -> None:
    """Compare every byte of a file that was just written with what it should be."""
    sink = ExpectedBytes(stream)
    _put(cast(BinaryIO, sink), mesh, letters or {}, groups)
    sink.finish()


def read(stream: BinaryIO) -> HexMesh:
    """Read elements, their curved sides, and boundaries by their identifiers, or letters where there are none."""
    content = stream.read()
    head = content[:80].decode("ascii", "replace")
    version, words = head[:5], head[5:].split()
    if version not in {"#v002", "#v003", "#v004"} or len(content) < 84:
        raise InputError("it does not begin with #v002, #v003 or #v004")
    m, dimension = (int(head[5:14]), int(head[14:17])) if version != "#v004" else (int(words[0]), int(words[1]))
    marks: list[Literal["<", ">"]] = [
        order for order in ("<", ">") if abs(np.frombuffer(content, f"{order}f4", 1, 80)[0] - _TAG) < 1e-5
    ]
    if not marks or dimension != 3 or m < 1:
        raise InputError("it has no elements in three dimensions, or no mark of the order of its bytes")
    real = f"{marks[0]}f8"
    if len(content) < 84 + 200 * m:
        raise InputError("it is cut short: elements are missing")
    rows = np.frombuffer(content, real, 25 * m, 84).reshape(m, 25)
    places = rows[:, 1:].reshape(m, 3, 8).transpose(0, 2, 1).reshape(-1, 3).astype(np.float64)
    groups = rows[:, 0].astype(np.int64)
    sets, at = [], 84 + 200 * m
    while at < len(content):
        count = int(np.frombuffer(content, real, 1, at)[0])
        if count < 0 or len(content) < at + 8 + 64 * count:
            raise InputError("it is cut short: curved sides or conditions are missing")
        sets.append(np.frombuffer(content, _RECORD.newbyteorder(marks[0]), count, at + 8))
        at += 8 + 64 * count
    if len(sets) < 2:
        raise InputError("it is cut short: curved sides or conditions are missing")
    curved, conditions = sets[:2]
    tags = [
        (own["kind"].decode().strip(), own["values"][:4].tobytes().decode().strip(), int(own["values"][4]))
        for own in (sets[2] if len(sets) > 2 and sets[2]["kind"][:1] == b"nodes   " else ())
    ]
    points, number = same_places(places) if tags else _joined(places)
    hexes = number.reshape(m, 8)
    if len(curved) or ("nodes", "", 20) in tags:
        points, hexes = _of_order_2(points, hexes, curved)
    boundaries = _boundaries(hexes, conditions, tags)
    named = {number: text for kind, text, number in tags if kind == "part"}
    parts = {
        named.get(j, f"group_{j}"): np.flatnonzero(groups == j) for j in np.unique(groups).tolist() if named or not tags
    }
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def _boundaries(hexes: IntArray, conditions: np.ndarray, tags: list[tuple[str, str, int]]) -> dict[str, IntArray]:
    inner = np.isin(np.char.strip(conditions["kind"].astype("S3")), (b"E", b""))
    own = conditions[~inner]
    of, side = own["hex"].astype(np.int64) - 1, np.argsort(SIDES)[own["side"].astype(np.int64) - 1]
    if len(of) and (of.min() < 0 or of.max() >= len(hexes)):
        raise InputError("a condition names an element that is not there")
    ids = own["values"][:, 4].astype(np.int64)
    quads = quads_of_sides(hexes, of, side)
    if tags:
        names = {text: [n for k, t, n in tags if (k, t) == ("name", text)] for kind, text, _ in tags if kind == "name"}
        return {name: quads[np.isin(ids, numbers)] for name, numbers in names.items()}
    if ids.any():
        return {f"boundary_{j}": quads[ids == j] for j in np.unique(ids).tolist()}
    letters = np.char.strip(own["kind"].astype("S3"))
    return {letter.decode(): quads[letters == letter] for letter in np.unique(letters)}


def _of_order_2(points: FloatArray, hexes: IntArray, curved: np.ndarray) -> tuple[FloatArray, IntArray]:
    """Points and hexes (m, 20) with the middles of edges."""
    kinds = np.unique(curved["kind"].astype("S1")).tolist()
    if kinds not in ([], [b"m"]):
        raise InputError(f"it has curved sides of the kinds {b' '.join(kinds).decode()}; m is read")
    lattice = number_lattice(hexes, len(points), 2)
    hexes = np.ascontiguousarray(lattice.hexes[:, :20])
    of, edge = curved["hex"].astype(np.int64) - 1, curved["side"].astype(np.int64) - 1
    if len(of) and (of.min() < 0 or of.max() >= len(hexes) or edge.min() < 0 or edge.max() > 11):
        raise InputError("a curved side names an element or an edge that is not there")
    ends = points[lattice.edges]
    every = np.concatenate([points, _middles(ends[:, 0], ends[:, 1])])
    every[hexes[of, 8 + edge]] = curved["values"][:, :3]
    return every, hexes


def _joined(places: FloatArray) -> tuple[FloatArray, IntArray]:
    """The same, where some that are one differ by rounding."""
    points, number = same_places(places)
    corners = points[number.reshape(-1, 8)]
    ends = corners[:, HEX_EDGES]
    near = _NEAR * float(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).min())
    pairs = scipy.spatial.cKDTree(points).query_pairs(near, output_type="ndarray")
    n = len(points)
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, first, label = np.unique(label, return_index=True, return_inverse=True)
    return points[first], label[number]
