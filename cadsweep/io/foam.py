"""OpenFOAM mesh: a folder named ``polyMesh``, as in ``case/constant/polyMesh``.

Place in the flow: a format module of :mod:`cadsweep.io`, the only one whose output is a folder.

A face has one patch here. Patches are the disjoint blocks of the boundaries, named by the rule of
:meth:`~cadsweep.io.labels.Blocks.exclusive_names`; every name of a face stands in ``inGroups`` of its patch, so a
boundary condition may be given for a name even where it spans several patches. Parts are cell zones (disjoint, by the
same rule). Faces without a name are the patch ``defaultFaces``; named quads inside the mesh, as interfaces are, are
face zones. A patch that is named ``wall``, or ends in ``_wall``, is of the type ``wall``; others are of the type
``patch``, or of what `patch_types` says.

Boundaries that are periodic and one patch each are ``cyclic``, their faces in the same order.

Order 1 only. A hex comes back turned, because OpenFOAM keeps faces and not corners. Reading knows text files.

References
----------
OpenFOAM user guide, "Mesh description"; faces are ordered by owner, then neighbour ("upper triangular order"), normals
point out of the owner.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..arrays import IntArray
from ..compiled import compiled
from ..errors import InputError, did_you_mean
from ..mesh import HexMesh
from .atomic import NewFolder
from .compare import Groups, all_boundaries, disjoint_boundaries, disjoint_parts
from .labels import LabelledMesh, make_blocks, without_quads
from .pairing import neighbours
from .periodic_faces import answering_quads
from .sides import corner_keys, cyclic, quads_of_sides
from .text import parse_numbers, write_rows

logger = logging.getLogger(__name__)

MOST_ORDER = 1

DEFAULT_PATCH = "defaultFaces"
"""Name of the boundary's quads that have none, as OpenFOAM's own tools call them."""

FILES = frozenset({"points", "faces", "owner", "neighbour", "boundary", "cellZones", "faceZones", "pointZones", "sets"})
"""What may stand in a folder that is replaced."""


ZONES = "face_zones"
"""Where `LabelledMesh.info` keeps the named quads inside the mesh."""

PATCH_TYPES = ("patch", "wall", "symmetry", "symmetryPlane", "empty", "wedge")

TURNED = True
"""A hex comes back with other first corner."""


def kept_groups(mesh: LabelledMesh, *, patch_types: Mapping[str, str] | None = None) -> Groups:
    """All boundaries (as patches or their groups), the patches of other names, face zones, and the disjoint parts."""
    del patch_types
    zones = mesh.info.get(ZONES, {})
    return {**disjoint_boundaries(mesh), **all_boundaries(mesh), **zones}, disjoint_parts(mesh)


def with_whole_boundary(mesh: LabelledMesh) -> LabelledMesh:
    """Take named quads inside the mesh for face zones, and give the boundary's quads without a name one."""
    across = neighbours(mesh.hexes, len(mesh.points))
    of, row = mesh.sides if len(mesh.quads) else (np.empty(0, dtype=np.int64),) * 2
    inner = across[6 * of + row] >= 0
    zones: dict[str, IntArray] = {}
    for name in mesh.faces.names if inner.any() else ():
        ids = mesh.faces.named(name)
        if inner[ids].any():
            called = name if inner[ids].all() else _distinct_name(f"{name}_inside", mesh.faces.names)
            zones[called] = mesh.quads[ids[inner[ids]]]
    unnamed = across < 0
    unnamed[6 * of + row] = False
    rest = np.flatnonzero(unnamed)
    extra = quads_of_sides(mesh.hexes, rest // 6, rest % 6)
    outside = without_quads(mesh, inner)
    sets = {name: outside.faces.named(name) for name in outside.faces.names}
    n_kept = len(outside.quads)
    if len(extra):
        sets[_distinct_name(DEFAULT_PATCH, mesh.faces.names)] = np.arange(n_kept, n_kept + len(extra))
    faces = make_blocks(sets, n_kept + len(extra))
    quads = np.concatenate([outside.quads, extra])
    return replace(mesh, quads=quads, faces=faces, info={**mesh.info, ZONES: zones})


def _distinct_name(name: str, taken: tuple[str, ...]) -> str:
    while name in taken:
        name += "_"
    return name


def patch_type(names: Collection[str], given: Mapping[str, str]) -> str:
    """The type of a patch by its names: what was given for one of them, ``wall`` by its name, or ``patch``."""
    for name in names:
        if name in given:
            return given[name]
    walls = [name for name in names if name.lower() == "wall" or name.lower().endswith("_wall")]
    return "wall" if walls else "patch"


def write_folder(folder: NewFolder, mesh: LabelledMesh, *, patch_types: Mapping[str, str] | None = None) -> None:
    """Write a labelled mesh into an empty folder.

    Parameters
    ----------
    patch_types : mapping of str to str, optional
        Type of the patch of a boundary: ``wall``, ``patch``, ``symmetry``, ``symmetryPlane``, ``empty``, ``wedge``.
    """
    patch_types = patch_types or {}
    for name, kind in patch_types.items():
        if name not in mesh.faces.names:
            raise InputError(
                f"there is no boundary '{name}' to be a {kind}{did_you_mean(name, mesh.faces.names)}; "
                f"there are {', '.join(mesh.faces.names)}"
            )
        if kind not in PATCH_TYPES:
            raise InputError(f"'{kind}' is no type of a patch; there are {', '.join(PATCH_TYPES)}")
    faces, owner, neighbour, patches = ordered_faces(mesh)
    cyclic_of = _pair_patches(mesh, faces, owner, patches)
    note = f"nPoints:{len(mesh.points)} nCells:{len(mesh.hexes)} nFaces:{len(faces)} nInternalFaces:{len(neighbour)}"
    with folder.open("points") as stream:
        stream.write(_head("vectorField", "points") + b"%d\n(\n" % len(mesh.points))
        write_rows(stream, "(%r %r %r)\n", mesh.points)
        stream.write(b")\n")
    with folder.open("faces") as stream:
        stream.write(_head("faceList", "faces") + b"%d\n(\n" % len(faces))
        write_rows(stream, "4(%d %d %d %d)\n", faces)
        stream.write(b")\n")
    for name, values in (("owner", owner), ("neighbour", neighbour)):
        with folder.open(name) as stream:
            stream.write(_head("labelList", name, note=note) + b"%d\n(\n" % len(values))
            write_rows(stream, "%d\n", values)
            stream.write(b")\n")
    rows = []
    for name, groups, first, count in patches:
        inside = f"        inGroups        {len(groups)}({' '.join(groups)});\n" if groups else ""
        kind = patch_type((name, *groups), patch_types)
        if name in cyclic_of:
            kind = "cyclic"
            inside += f"        neighbourPatch  {cyclic_of[name]};\n        matchTolerance  0.0001;\n"
        rows.append(
            f"    {name}\n    {{\n        type            {kind};\n{inside}"
            f"        nFaces          {count};\n        startFace       {first};\n    }}\n"
        )
    text = f"{len(rows)}\n(\n{''.join(rows)})\n"
    with folder.open("boundary") as stream:
        stream.write(_head("polyBoundaryMesh", "boundary") + text.encode())
    zones = mesh.volumes.exclusive_names()
    with folder.open("cellZones") as stream:
        stream.write(_head("regIOobject", "cellZones") + b"%d\n(\n" % len(zones))
        for block, name in enumerate(zones):
            ids = mesh.volumes.cells(block)
            stream.write(f"{name}\n{{\n    type cellZone;\n    cellLabels List<label>\n{len(ids)}\n(\n".encode())
            write_rows(stream, "%d\n", ids)
            stream.write(b")\n;\n}\n")
        stream.write(b")\n")

    if mesh.info.get(ZONES):
        _write_face_zones(folder, mesh.info[ZONES], faces[: len(neighbour)])


def _pair_patches(
    mesh: LabelledMesh, faces: IntArray, owner: IntArray, patches: Sequence[tuple[str, tuple[str, ...], int, int]]
) -> dict[str, str]:
    """Put the faces of periodic patches in the order of their partners', in place; the partner of each patch."""
    ranges = {name: (first, first + count) for name, _, first, count in patches}
    found: dict[str, str] = {}
    for (one, other), pairs in mesh.periodic.items():
        if one not in ranges or other not in ranges:
            logger.warning("'%s' and '%s' are periodic, and not one patch each: they are plain patches", one, other)
            continue
        (a, b), (c, d) = ranges[one], ranges[other]
        order, turned = answering_quads(faces[a:b], faces[c:d], pairs)
        faces[c:d], owner[c:d] = turned, owner[c:d][order]
        found |= {one: other, other: one}
    return found


def _write_face_zones(folder: NewFolder, zones: Mapping[str, IntArray], inner: IntArray) -> None:
    """Faces of the zones; a face that turns the other way than its quad is flipped."""
    with folder.open("faceZones") as stream:
        stream.write(_head("regIOobject", "faceZones") + b"%d\n(\n" % len(zones))
        for name, quads in zones.items():
            _, codes = corner_keys(np.concatenate([inner, quads[:, :4]]))
            face_of = np.full(int(codes.max()) + 1, -1, dtype=np.int64)
            face_of[codes[: len(inner)]] = np.arange(len(inner))
            ids = face_of[codes[len(inner) :]]
            flipped = ~(cyclic(inner[ids]) == cyclic(quads[:, :4])).all(axis=1)
            order = np.argsort(ids)
            stream.write(f"{name}\n{{\n    type faceZone;\n    faceLabels List<label>\n{len(ids)}\n(\n".encode())
            write_rows(stream, "%d\n", ids[order])
            stream.write(f")\n;\n    flipMap List<bool>\n{len(ids)}\n(\n".encode())
            write_rows(stream, "%d\n", flipped[order].astype(np.int64))
            stream.write(b")\n;\n}\n")
        stream.write(b")\n")


def _head(kind: str, name: str, *, note: str = "") -> bytes:
    note = f'    note        "{note}";\n' if note else ""
    return (
        f"FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {kind};\n{note}"
        f'    location    "constant/polyMesh";\n    object      {name};\n}}\n\n'
    ).encode()


def ordered_faces(
    mesh: LabelledMesh,
) -> tuple[IntArray, IntArray, IntArray, list[tuple[str, tuple[str, ...], int, int]]]:
    """All faces in OpenFOAM's order, owners, neighbours, and patches (name, groups, first face, number)."""
    across = neighbours(mesh.hexes, len(mesh.points))
    beyond = np.where(across > np.arange(len(across)), across // 6, len(mesh.hexes)).reshape(-1, 6)
    row = np.argsort(beyond, axis=1, kind="stable")
    sides = (6 * np.arange(len(beyond))[:, None] + row)[np.take_along_axis(beyond, row, axis=1) < len(beyond)]
    neighbour = across[sides] // 6
    listed, start = [sides], len(sides)
    patches: list[tuple[str, tuple[str, ...], int, int]] = []
    quads = 6 * mesh.sides[0] + mesh.sides[1]
    if (across[quads] >= 0).any() or len(quads) != np.count_nonzero(across < 0):
        raise InputError("a quad of the boundary is no side of just one hexahedron: OpenFOAM cannot read such a mesh")
    for block, name in enumerate(mesh.faces.exclusive_names()):
        these = np.sort(quads[mesh.faces.cells(block)])
        groups = tuple(n for n in mesh.faces.members[block] if n != name)
        patches.append((name, groups, start, len(these)))
        listed.append(these)
        start += len(these)
    faces = np.concatenate(listed)
    return quads_of_sides(mesh.hexes, faces // 6, faces % 6), faces // 6, neighbour, patches


def read_folder(folder: Path) -> HexMesh:
    """Read a mesh of hexes; the corners of a hex begin anywhere."""
    points = _numbers(_list(folder, "points"), np.float64).reshape(-1, 3)
    owner, neighbour = (_numbers(_list(folder, name)) for name in ("owner", "neighbour"))
    rows = _numbers(_list(folder, "faces"))
    if len(rows) == 0 or len(rows) % 5 or (rows[::5] != 4).any():
        raise InputError("it has faces that are no quads, or is cut short; meshes of hexahedra are read")
    if len(rows) != 5 * len(owner) or len(neighbour) > len(owner):
        raise InputError("its files do not fit together, or one is cut short")
    faces = rows.reshape(-1, 5)[:, 1:]
    n_cells = int(np.max(np.concatenate([owner, neighbour]))) + 1  # the last cell of a ring may own no face
    inner = len(neighbour)
    of = np.concatenate([owner, neighbour])
    around = np.concatenate([faces, faces[:inner, ::-1]])
    order = np.argsort(of, kind="stable")
    if (np.bincount(of, minlength=n_cells) != 6).any():
        raise InputError("it has cells without six faces; meshes of hexahedra are read")
    hexes = _corners(around[order].reshape(n_cells, 6, 4))
    boundaries: dict[str, list[IntArray]] = {}
    text = _list(folder, "boundary").decode()
    for name, body in re.findall(r"(\S+)\s*\{([^{}]*)\}", text):
        count, start = (int(re.search(rf"{key}\s+(\d+)", body)[1]) for key in ("nFaces", "startFace"))  # type: ignore[index]
        groups = re.search(r"inGroups\s+(?:List<word>\s*)?\d*\s*\(([^()]*)\)", body)
        for key in dict.fromkeys([name, *(groups[1].split() if groups else [])]):
            boundaries.setdefault(key, []).append(faces[start : start + count])
    parts = {}
    if (folder / "cellZones").exists():
        for name, ids in re.findall(rb"(\w+)\s*\{[^{}]*?\d+\s*\(([\d\s]*)\)[^{}]*\}", _list(folder, "cellZones")):
            parts[name.decode()] = _numbers(ids)
    if (folder / "faceZones").exists():
        pattern = rb"(\w+)\s*\{[^{}]*?faceLabels[^(]*\(([\d\s]*)\)[^{}]*?flipMap[^(]*\(([\w\s]*)\)[^{}]*\}"
        for name, ids, flips in re.findall(pattern, _list(folder, "faceZones")):
            rows_of = faces[_numbers(ids)]
            turned = np.array([word in {b"1", b"true", b"yes", b"on"} for word in flips.split()], dtype=bool)
            boundaries.setdefault(name.decode(), []).append(np.where(turned[:, None], rows_of[:, ::-1], rows_of))
    return HexMesh(
        points=points, hexes=hexes, boundaries={k: np.concatenate(v) for k, v in boundaries.items()}, parts=parts
    )


_BRACKETS = bytes.maketrans(b"()", b"  ")


def _numbers(text: bytes, dtype: type = np.int64) -> np.ndarray:
    return parse_numbers(text.translate(_BRACKETS), dtype)


def _list(folder: Path, name: str) -> bytes:
    """The text between the outer brackets of a file's list."""
    text = (folder / name).read_bytes()
    if not text.isascii() or re.search(rb"format\s+binary", text[:2000]):
        raise InputError(f"its file {name} is binary; write it as text (foamFormatConvert)")
    text = re.sub(rb"/\*.*?\*/", b"", text, flags=re.DOTALL)
    text = re.sub(rb"//.*", b"", text)
    head = text.find(b"}") + 1
    begin, end = text.find(b"(", head), text.rfind(b")")
    if begin < head or end < begin:
        raise InputError(f"its file {name} holds no list, or is cut short")
    return text[begin + 1 : end]


def _corners(around: IntArray) -> IntArray:
    """Corners (m, 8) in VTK's order of cells given by their outward faces (m, 6, 4)."""
    hexes = _upright(np.ascontiguousarray(around))
    if (hexes < 0).any():
        raise InputError("it has cells with six quads that are no hexahedra")
    return hexes


@compiled(cache=True, nogil=True)
def _upright(around):  # type: ignore[no-untyped-def]
    """The first face, turned inwards, and what each of its corners is joined to beyond it; -1: nothing."""
    hexes = np.full((len(around), 8), -1, dtype=np.int64)
    for h in range(len(around)):
        hexes[h, :4] = around[h, 0, ::-1]
        for face in range(1, 6):
            for k in range(4):
                tail, head = around[h, face, k], around[h, face, (k + 1) % 4]
                at = -1
                for j in range(4):
                    at = j if hexes[h, j] == tail and at > -2 else at
                    at = -2 if hexes[h, j] == head else at
                if at >= 0:
                    hexes[h, 4 + at] = head
    return hexes
