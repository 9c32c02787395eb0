"""A grid in several ``.vtu`` files, one a rank, and the ``.pvtu`` file that lists them.

Place in the flow: ``distributed`` writes the pieces and the list; reading joins the pieces to the serial mesh again.
Every piece holds the rank's own layers of hexes, and those of others around them as ghosts:

| array | of | holds |
|---|---|---|
| ``GlobalNodeIds`` | points | number of the node in the whole mesh |
| ``GlobalHexIds`` | cells | number of the hex in the whole mesh |
| ``vtkGhostType`` | points, cells | 1 where another piece owns it (``DUPLICATEPOINT``, ``DUPLICATECELL``) |

A node of several ranks belongs to the lowest of them. The other arrays are those of :mod:`cadsweep.io.vtu`;
``boundary:<name>`` lists the piece's own quads in its own node numbers, so that a piece is a mesh file by itself;
``boundary_places:<name>`` which quads of the whole boundary they are.

Not handled on reading: pieces without global ids, as other programs write them.

References
----------
VTK file formats, "XML File Formats", parallel files; ``vtkDataSetAttributes.h`` for the ghost types.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO
from xml.etree import ElementTree

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..mesh import HexMesh
from . import vtu
from .vtk_cells import GHOSTS, HEX_IDS, NODE_IDS, QUAD_PLACES, colors_of_fields, hexes_of_cells

_POINT_ARRAYS = ((NODE_IDS, "Int64"), (GHOSTS, "UInt8"))
_CELL_ARRAYS = ((HEX_IDS, "Int64"), (GHOSTS, "UInt8"), ("part", "Int32"), ("boundary", "Int32"))


def write_piece(
    stream: BinaryIO,
    points: FloatArray,
    hexes: IntArray,
    *,
    nodes: Mapping[str, np.ndarray],
    cells: Mapping[str, np.ndarray],
    fields: Mapping[str, np.ndarray],
) -> None:
    """Write one piece; `nodes` and `cells` hold the arrays that the table above names."""
    vtu.write_grid(stream, points, hexes, cells=cells, fields=fields, nodes=nodes, global_ids=(NODE_IDS, HEX_IDS))


def write(stream: BinaryIO, mesh: object) -> None:
    """Refuse: the pieces are the work of the ranks of a distributed run."""
    raise InputError(
        "a .pvtu is written by a distributed run: mpiexec -n 2 python -m mpi4py -m cadsweep mesh ...; "
        "for one process choose .vtu"
    )


def write_index(stream: BinaryIO, pieces: Sequence[str]) -> None:
    """Write the file that lists the pieces, by their paths beside it."""

    def arrays(known: Sequence[tuple[str, str]]) -> str:
        return "".join(f'<PDataArray type="{kind}" Name="{name}"/>\n' for name, kind in known)

    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="LittleEndian"'
        ' header_type="UInt64">\n<PUnstructuredGrid GhostLevel="1">\n'
        f'<PPointData GlobalIds="{NODE_IDS}">\n{arrays(_POINT_ARRAYS)}</PPointData>\n'
        f'<PCellData GlobalIds="{HEX_IDS}">\n{arrays(_CELL_ARRAYS)}</PCellData>\n'
        '<PPoints>\n<PDataArray type="Float64" Name="Points" NumberOfComponents="3"/>\n</PPoints>\n'
        + "".join(f"<Piece Source={vtu.quoted(piece)}/>\n" for piece in pieces)
        + "</PUnstructuredGrid>\n</VTKFile>\n"
    )
    stream.write(text.encode())


def read(stream: BinaryIO) -> HexMesh:
    """Read all pieces and join them to one mesh, in its global numbers."""
    try:
        root = ElementTree.fromstring(stream.read())
    except ElementTree.ParseError as error:
        raise InputError(f"it is not well-formed XML ({error})") from None
    if root.tag != "VTKFile" or root.get("type") != "PUnstructuredGrid":
        raise InputError("it is no list of VTK unstructured grids")
    folder = Path(str(getattr(stream, "name", "."))).parent
    node_ids, hex_ids, points, hexes = [], [], [], []
    boundaries: dict[str, list[IntArray]] = {}
    places: dict[str, list[IntArray]] = {}
    parts: list[str] = ["volume"]
    part_of: list[IntArray] = []
    info: dict[str, Any] = {}
    for element in root.findall("./PUnstructuredGrid/Piece"):
        path = folder / element.get("Source", "")
        try:
            with open(path, "rb") as file:
                arrays = vtu.read_arrays(file)
        except FileNotFoundError:
            raise InputError(f"its piece {path} is missing") from None
        if NODE_IDS not in arrays["point_data"] or HEX_IDS not in arrays["cell_data"]:
            raise InputError(f"its piece {path} has no {NODE_IDS} or no {HEX_IDS}")
        if not len(arrays["types"]):
            continue  # of a rank that had nothing to do
        ids = arrays["point_data"][NODE_IDS]
        local, _ = hexes_of_cells(arrays["connectivity"], arrays["offsets"], arrays["types"])
        own = arrays["cell_data"].get(GHOSTS, np.zeros(len(local))) == 0
        node_ids.append(ids)
        points.append(arrays["points"])
        hex_ids.append(arrays["cell_data"][HEX_IDS][own])
        hexes.append(ids[local[own]])
        fields = arrays["field_data"]
        parts = [str(name) for name in fields.get("part_names", parts)]
        part_of.append(np.asarray(arrays["cell_data"].get("part", np.zeros(len(local))))[own])
        info = colors_of_fields(fields)
        for name in fields.get("boundary_names", []):
            quads = np.asarray(fields.get(f"boundary:{name}", ()), dtype=np.int64).reshape(-1, 4)
            boundaries.setdefault(str(name), []).append(ids[quads])
            known = np.asarray(fields.get(f"{QUAD_PLACES}{name}", np.arange(len(quads))), dtype=np.int64)
            places.setdefault(str(name), []).append(known)
    if not points:
        raise InputError("it lists no pieces that hold hexahedra")
    ids = np.concatenate(node_ids)
    all_points = np.full((int(np.max(ids)) + 1, 3), np.nan)
    all_points[ids] = np.concatenate(points)
    order = np.argsort(np.concatenate(hex_ids), kind="stable")
    all_hexes, all_parts = np.concatenate(hexes)[order], np.concatenate(part_of)[order]
    return HexMesh(
        points=all_points,
        hexes=all_hexes,
        boundaries={
            name: np.concatenate(quads)[np.argsort(np.concatenate(places[name]), kind="stable")]
            for name, quads in boundaries.items()
        },
        parts={name: np.flatnonzero(all_parts == j) for j, name in enumerate(parts)},
        info=info,
    )
