"""FEBio's ``Mesh`` section, ``.feb``: nodes, elements by part, node sets, surfaces and pairs of them.

Place in the flow: a format module of :mod:`cadsweep.io`. A model takes the mesh as ``<Mesh from="part.feb"/>``. Every
boundary is a ``Surface`` (outward) and a ``NodeSet`` of its name, every part a domain of ``Elements``, other sets of
hexes an ``ElementSet``; the two sides of a contact between solids that share no nodes are a ``SurfacePair``.

Not handled: hex27.

References
----------
FEBio user's manual 4, "Mesh section": hex8, hex20 (bottom, top, upright edges, as in VTK), quad4, quad8.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..errors import InputError
from ..mesh import HexMesh
from . import decks
from .compare import Groups
from .labels import LabelledMesh
from .text import write_list, write_rows
from .ties import find_ties

_SIZES = (8, 20)
_BLOCK = re.compile(rb"<(Nodes|Elements|NodeSet|Surface|ElementSet)\b([^>]*)>")
_LAST = b"</febio_spec>"


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    first_node: int = 1,
    first_element: int = 1,
    prefix: str = "",
    ties: bool = True,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    first_node, first_element : int
        Numbers of the first node and the first element.
    prefix : str
        Before every name.
    ties : bool
        Write the two sides of contacts between parts that share no nodes as pairs.
    """
    n, size = len(mesh.points), mesh.hexes.shape[1]
    if size not in _SIZES:
        raise InputError("hex27 is not written as FEBio's; make the mesh with order=2, nodes=20")
    decks.check_numbering(prefix=prefix, first_node=first_node, first_element=first_element)
    groups = decks.deck_groups(mesh, prefix)
    stream.write(
        b'<?xml version="1.0" encoding="UTF-8"?>\n<febio_spec version="4.0">\n<Module type="solid"/>\n<Mesh>\n'
    )
    stream.write(f'<Nodes name="{prefix}nodes">\n'.encode())
    write_rows(stream, '<node id="%d">%r,%r,%r</node>\n', np.arange(first_node, n + first_node), mesh.points)
    stream.write(b"</Nodes>\n")
    row = '<elem id="%d">' + ",".join(["%d"] * size) + "</elem>\n"
    for name, ids in groups.parts.items():
        stream.write(f'<Elements type="hex{size}" name="{name}">\n'.encode())
        write_rows(stream, row, ids + first_element, mesh.hexes[ids] + first_node)
        stream.write(b"</Elements>\n")
    for name, face in groups.faces.items():
        width = face.quads.shape[1]
        _list(stream, "NodeSet", name, distinct(face.quads) + first_node)
        stream.write(f'<Surface name="{name}">\n'.encode())
        row = f'<quad{width} id="%d">' + ",".join(["%d"] * width) + f"</quad{width}>\n"
        write_rows(stream, row, np.arange(1, 1 + len(face.quads)), face.quads + first_node)
        stream.write(b"</Surface>\n")
    for name, ids in groups.sets.items():
        _list(stream, "ElementSet", name, ids + first_element)
    for tie in find_ties(mesh) if ties else ():
        sides = f"<primary>{prefix}{tie.dependent}</primary><secondary>{prefix}{tie.independent}</secondary>"
        stream.write(f'<SurfacePair name="{prefix}{tie.name}">{sides}</SurfacePair>\n'.encode())
    stream.write(b"</Mesh>\n" + _LAST + b"\n")


def _list(stream: BinaryIO, kind: str, name: str, ids: IntArray) -> None:
    stream.write(f'<{kind} name="{name}">\n'.encode())
    whole = (len(ids) - 1) // 10 * 10
    write_list(stream, "%d", ids[:whole], per_line=10, between=",", end=",\n")
    write_list(stream, "%d", ids[whole:], per_line=10, between=",")
    stream.write(f"</{kind}>\n".encode())


def kept_groups(mesh: LabelledMesh, *, prefix: str = "", **_options: object) -> Groups:
    """All boundaries, parts and sets."""
    return decks.deck_kept(mesh, prefix)


def read(stream: BinaryIO) -> HexMesh:
    """Read the nodes, hexes, sets and surfaces of a file."""
    content = decks.deck_content(stream, "<!--")
    if _LAST not in content[-200:] or b"<febio_spec" not in content[:1000]:
        raise InputError("it is no FEBio model, or is cut short")
    found = decks.DeckParts.empty()
    quads: dict[str, IntArray] = {}
    place = 0
    while (match := _BLOCK.search(content, place)) is not None:
        kind, options = match[1].decode(), dict(re.findall(r'(\w+)="([^"]*)"', match[2].decode("utf-8", "replace")))
        start, end = match.end(), content.find(f"</{kind}>".encode(), match.end())
        if end < 0:
            raise InputError(f"its {kind} have no end")
        place = end
        if kind == "Nodes":
            for values in _rows(content, start, end, 4, np.float64):
                found.node_tags.append(values[:, 0].astype(np.int64))
                found.points.append(values[:, 1:])
        elif kind == "Elements":
            size = re.fullmatch(r"hex(8|20)\w*", options.get("type", ""))
            if size is None:
                if re.match(r"tet|penta|pyra|hex", options.get("type", "")):
                    raise InputError(f"it has elements of type {options['type']}; hex8 and hex20 are read")
                continue
            rows = np.vstack(list(_rows(content, start, end, 1 + int(size[1]), np.int64)))
            found.hex_tags.append(rows[:, 0])
            found.hexes.append(rows[:, 1:])
            found.parts.setdefault(options.get("name", "part"), []).append(rows[:, 0])
        elif kind == "Surface":
            width = 8 if b"<quad8" in content[start : start + 100] else 4
            quads[options["name"]] = np.vstack(list(_rows(content, start, end, 1 + width, np.int64)))[:, 1:]
        elif kind == "ElementSet":
            found.parts[options["name"]] = [decks.parse_numbers(content[start:end], np.int64)]
    return found.mesh(quads=quads)


_PLAIN = bytes.maketrans(b'">', b"  ")


def _rows(content: decks.mmap.mmap, start: int, end: int, width: int, dtype: type) -> decks.Iterator[np.ndarray]:
    """Numbers (n, width) of lines such as ``<node id="1">0,0,0</node>``."""
    for text in decks.cut_at_lines(content, start, end):
        # All lines of a block have the same marks, of which the first line has every kind.
        marks = dict.fromkeys(re.findall(rb"</?[a-z]+\d?(?: id=)?", text[: text.find(b"\n", 1) + 1 or None]))
        plain = text
        for mark in sorted(marks, key=len, reverse=True):
            plain = plain.replace(mark, b" ")
        yield decks.parse_numbers(plain.translate(_PLAIN), dtype).reshape(-1, width)
