"""VTK XML unstructured grid, ``.vtu``.

Place in the flow: a format module of :mod:`cadsweep.io`. Written with numpy alone: an XML head, then the arrays as raw
bytes; read back with the standard library, so a damaged file cannot take the process with it.

The grid's cells are the hexes and nothing else, so ``n_cells`` is the number of hexes. Names are kept beside them:

| array | kind | holds |
|---|---|---|
| ``part`` | cells, int32 | which of ``part_names`` the hex belongs to |
| ``boundary`` | cells, int32 | the first of ``boundary_names`` that the hex touches, -1 inside: to colour by |
| ``boundary_names``, ``part_names`` | field, string | the names |
| ``boundary_colors``, ``part_colors`` | field, string | those of the CAD model, ``#rrggbb``; empty: none |
| ``boundary:<name>`` | field, int64 (q, 4, 8 or 9) | node ids of the boundary's quads, outward |
| ``part:<name>`` | field, int64 | hex ids of the part |

Reads ASCII, base64 and raw arrays, uncompressed or with zlib or LZMA, of one piece. Not handled: several pieces, LZ4.

References
----------
VTK file formats, "XML File Formats" (docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html); node order:
``vtkQuadraticHexahedron.h`` and ``vtkTriQuadraticHexahedron.h``.
"""

from __future__ import annotations

import base64
import html
import lzma
import sys
import zlib
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO, cast
from xml.etree import ElementTree

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..lattice import MOST
from ..mesh import HexMesh
from . import vtk_cells
from .compare import ExpectedBytes
from .labels import LabelledMesh

CELL_TYPES = vtk_cells.CELL_TYPES
MOST_ORDER = MOST
_NAMES = {
    "Float64": "f8", "Float32": "f4", "Int64": "i8", "Int32": "i4", "Int16": "i2", "Int8": "i1",
    "UInt64": "u8", "UInt32": "u4", "UInt16": "u2", "UInt8": "u1",
}  # fmt: skip


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    _put(stream, mesh)


def _put(stream: BinaryIO, mesh: LabelledMesh) -> None:
    cells, fields, nodes = vtk_cells.grid_arrays(mesh)
    write_grid(stream, mesh.points, mesh.hexes, cells=cells, fields=fields, nodes=nodes)


def write_grid(
    stream: BinaryIO,
    points: FloatArray,
    hexes: IntArray,
    *,
    cells: Mapping[str, np.ndarray],
    fields: Mapping[str, np.ndarray],
    nodes: Mapping[str, np.ndarray],
    global_ids: tuple[str, str] | None = None,
) -> None:
    """Write a grid of hexes with its data.

    Parameters
    ----------
    cells, fields, nodes : mapping of str to array
        Data of cells, of the grid and of points.
    global_ids : (str, str) or None
        Which of the arrays of points and of cells hold ids that are unique over several files.
    """
    parts: list[np.ndarray] = []
    marks = ("", "") if global_ids is None else tuple(f" GlobalIds={quoted(name)}" for name in global_ids)
    offset = 0

    def array(name: str, values: Any, *, tuples: bool = False) -> str:
        nonlocal offset
        text = values.dtype.kind == "U"
        if text:
            data: np.ndarray = np.frombuffer(b"".join(str(v).encode() + b"\0" for v in values), dtype=np.int8)
            kind = f'type="String" NumberOfTuples="{len(values)}"'
        else:
            data = np.ascontiguousarray(values)
            vtk_type = next(n for n, code in _NAMES.items() if data.dtype == np.dtype(code))
            kind = f'type="{vtk_type}"'
            if data.ndim == 2:
                kind += f' NumberOfComponents="{data.shape[1]}"'
            if tuples:
                kind += f' NumberOfTuples="{len(data)}"'
        head = f'<DataArray {kind} Name={quoted(name)} format="appended" offset="{offset}"/>\n'
        parts.append(data)
        offset += 8 + data.nbytes
        return head

    # Files of version 2.1 and before are read as having edges 10 and 11 of Lagrange cells exchanged.
    version = "2.2" if vtk_cells.CELL_TYPES[hexes.shape[1]] == vtk_cells.LAGRANGE else "1.0"
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    xml = (
        f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="{version}" byte_order="{order}"'
        f' header_type="UInt64">\n<UnstructuredGrid>\n<FieldData>\n'
        + "".join(array(name, values, tuples=True) for name, values in fields.items())
        + f'</FieldData>\n<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(hexes)}">\n<PointData{marks[0]}>\n'
        + "".join(array(name, values) for name, values in nodes.items())
        + f"</PointData>\n<CellData{marks[1]}>\n"
        + "".join(array(name, values) for name, values in cells.items())
        + "</CellData>\n<Points>\n"
        + array("Points", points)
        + "</Points>\n<Cells>\n"
        + array("connectivity", hexes.reshape(-1))
        + array("offsets", vtk_cells.offsets(hexes)[1:])
        + array("types", vtk_cells.types(hexes))
        + '</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'
    )
    stream.write(xml.encode())
    for data in parts:
        stream.write(np.uint64(data.nbytes).tobytes())
        vtk_cells.write_bytes(stream, data)
    stream.write(b"\n</AppendedData>\n</VTKFile>\n")


def quoted(value: str) -> str:
    """A value of an XML attribute, escaped, in quotes; ``xml.sax.saxutils`` has it, and imports all of ``urllib``."""
    escaped = html.escape(value)
    for space in "\n\r\t":
        escaped = escaped.replace(space, f"&#{ord(space)};")
    return f'"{escaped}"'


def verify(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Compare every byte of a file that was just written with what it should be."""
    sink = ExpectedBytes(stream)
    _put(cast(BinaryIO, sink), mesh)
    sink.finish()


def read(stream: BinaryIO) -> HexMesh:
    """Read a grid of hexes with whatever names it holds."""
    arrays = read_arrays(stream)
    del arrays["point_data"]
    return vtk_cells.grid_mesh(**arrays)


def read_arrays(stream: BinaryIO) -> dict[str, Any]:
    """Read the arrays of a grid: what :func:`vtk_cells.grid_mesh` takes, and ``point_data``."""
    content = stream.read()
    start = content.find(b"<AppendedData")
    appended: bytes | memoryview = b""
    head = content
    if start >= 0:
        begin = content.find(b"_", content.find(b">", start)) + 1
        appended = memoryview(content)[begin:]
        head = content[:start] + b"</VTKFile>"
        if b"base64" in content[start:begin]:
            appended = content[begin : content.find(b"<", begin)].strip()
    try:
        root = ElementTree.fromstring(head)
    except ElementTree.ParseError as error:
        raise InputError(f"it is not well-formed XML ({error})") from None
    if root.tag != "VTKFile" or root.get("type") != "UnstructuredGrid":
        raise InputError("it is no VTK unstructured grid")
    pieces = root.findall("./UnstructuredGrid/Piece")
    if len(pieces) != 1:
        raise InputError(f"it has {len(pieces)} pieces; files of one piece are read")
    encoded = b"base64" in content[start : start + 60] if start >= 0 else False
    decoder = _Decoder(root, appended, encoded=encoded)
    piece = pieces[0]
    cells = {e.get("Name", ""): e for e in piece.findall("./Cells/DataArray")}
    points = piece.find("./Points/DataArray")
    if points is None or not {"connectivity", "offsets", "types"} <= set(cells):
        raise InputError("it has no points or no cells")
    n_points, n_cells = int(piece.get("NumberOfPoints", -1)), int(piece.get("NumberOfCells", -1))
    return {
        "points": decoder.values(points).reshape(n_points, 3),
        "connectivity": decoder.values(cells["connectivity"]),
        "offsets": np.concatenate([[0], decoder.values(cells["offsets"])]),
        "types": decoder.values(cells["types"])[: n_cells or None],
        "cell_data": {e.get("Name", ""): decoder.values(e) for e in piece.findall("./CellData/DataArray")},
        "point_data": {e.get("Name", ""): decoder.values(e) for e in piece.findall("./PointData/DataArray")},
        "field_data": dict(decoder.fields(root.findall("./UnstructuredGrid/FieldData/*"))),
    }


class _Decoder:
    """Turns the file's array elements into numpy arrays."""

    def __init__(self, root: ElementTree.Element, appended: bytes | memoryview, *, encoded: bool) -> None:
        mark = "<" if root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        self.mark = mark
        self.header = np.dtype(mark + _NAMES.get(root.get("header_type", "UInt32"), "u4"))
        self.compressor = root.get("compressor")
        self.appended = appended
        self.encoded = encoded

    def values(self, element: ElementTree.Element) -> np.ndarray:
        code = _NAMES.get(element.get("type", ""))
        if code is None:
            raise InputError(f"array {element.get('Name')!r} has the unknown type {element.get('type')!r}")
        if element.get("format") == "ascii":
            values = np.array((element.text or "").split(), dtype=np.float64 if code[0] == "f" else np.int64)
        else:
            values = np.frombuffer(self._bytes(element), dtype=self.mark + code)
        width = int(element.get("NumberOfComponents", 1))
        values = values.astype(np.float64 if code[0] == "f" else np.int64)
        return values.reshape(-1, width) if width > 1 else values

    def fields(self, elements: list[ElementTree.Element]) -> Iterator[tuple[str, Any]]:
        for element in elements:
            name = element.get("Name", "")
            if element.get("type") == "String":
                if element.get("format") == "ascii":
                    raw = bytes(int(token) for token in (element.text or "").split())
                else:
                    raw = bytes(self._bytes(element))
                yield name, [part.decode("utf-8", "replace") for part in raw.split(b"\0")[:-1]]
            elif element.get("type") in _NAMES:
                yield name, self.values(element)

    def _bytes(self, element: ElementTree.Element) -> bytes | memoryview:
        data: bytes | memoryview
        if element.get("format") == "appended":
            offset = int(element.get("offset", "0"))
            data, encoded = self.appended[offset:], self.encoded
        else:
            data, encoded = "".join((element.text or "").split()).encode(), True
        if self.compressor:
            return self._decompressed(data, encoded=encoded)
        size = self.header.itemsize
        if encoded:
            n_bytes = int(np.frombuffer(_from_base64(data, size), dtype=self.header)[0])
            found: bytes | memoryview = _from_base64(data, size + n_bytes)[size:]
        else:
            n_bytes = int(np.frombuffer(data[:size], dtype=self.header)[0])
            found = data[size : size + n_bytes]
        if len(found) != n_bytes:
            raise InputError(f"array {element.get('Name')!r} is cut short: {len(found)} of {n_bytes} bytes")
        return found

    def _decompressed(self, data: bytes | memoryview, *, encoded: bool) -> bytes:
        size = self.header.itemsize
        unpack: Any = {"vtkZLibDataCompressor": zlib.decompress, "vtkLZMADataCompressor": lzma.decompress}.get(
            str(self.compressor)
        )
        if unpack is None:
            raise InputError(f"its compression {self.compressor!r} is not read; write it again without")
        raw: bytes | memoryview = _from_base64(data, size) if encoded else data
        n_blocks = int(np.frombuffer(raw[:size], dtype=self.header)[0])
        n_head = size * (3 + n_blocks)
        head = np.frombuffer((_from_base64(data, n_head) if encoded else data)[:n_head], dtype=self.header)
        if encoded:
            # The head is a base64 stream of its own, padded to a multiple of four letters.
            letters = -(-n_head // 3) * 4
            raw = _from_base64(data[letters:], int(head[3:].sum()))
        else:
            raw = data[n_head:]
        ends = np.concatenate([[0], np.cumsum(head[3:].astype(np.int64))])
        return b"".join(unpack(raw[ends[j] : ends[j + 1]]) for j in range(n_blocks))


def _from_base64(data: bytes | memoryview, n_bytes: int) -> bytes:
    return base64.b64decode(data[: -(-n_bytes // 3) * 4])[:n_bytes]
