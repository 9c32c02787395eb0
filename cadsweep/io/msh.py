"""Gmsh's MSH: the version and the kind of file, by option.

Place in the flow: the module behind the suffix ``.msh``; see :mod:`cadsweep.io.msh41`, :mod:`cadsweep.io.msh22` and
:mod:`cadsweep.io.msh_read`.
"""

from __future__ import annotations

import mmap
from typing import BinaryIO, cast

from ..errors import InputError
from ..lattice import MOST
from ..mesh import HexMesh
from . import fluent, msh22, msh41
from .compare import ExpectedBytes, Groups, all_boundaries, all_parts, check_same, disjoint_boundaries, disjoint_parts
from .labels import LabelledMesh
from .msh_read import read_content

MOST_ORDER = MOST

VERSIONS = ("4.1", "2.2", "fluent")


def write(stream: BinaryIO, mesh: LabelledMesh, *, binary: bool | None = None, version: str = "4.1") -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    binary : bool, optional
        4.1 is binary, 2.2 is text, unless said otherwise; 2.2 exists as text alone.
    version : {"4.1", "2.2", "fluent"}
        Gmsh's two, or Fluent's format of the same suffix.
    """
    version = str(version)
    if version not in VERSIONS:
        raise InputError(f"the version should be one of {', '.join(VERSIONS)}, not {version!r}")
    if version == "4.1":
        msh41.write(stream, mesh, binary=binary is not False)
    elif binary:
        raise InputError(f"MSH {version} is written as text; leave out binary, or write version 4.1")
    elif version == "fluent":
        fluent.write(stream, mesh)
    else:
        msh22.write(stream, mesh)


def kept_groups(mesh: LabelledMesh, *, version: str = "4.1", binary: bool | None = None) -> Groups:
    """Groups as the file holds them: all in 4.1, disjoint ones in 2.2."""
    del binary
    if str(version) == "2.2":
        return disjoint_boundaries(mesh), disjoint_parts(mesh)
    return all_boundaries(mesh), all_parts(mesh)


def verify(stream: BinaryIO, mesh: LabelledMesh, *, version: str = "4.1", binary: bool | None = None) -> None:
    """Compare a file that was just written with the mesh.

    Of a binary file every byte is compared with what it should be, without making a second mesh of it.
    """
    if str(version) == "fluent":  # which is not read here: what the disk holds is compared byte by byte
        sink = ExpectedBytes(stream)
        fluent.write(cast(BinaryIO, sink), mesh)
        sink.finish()
    elif str(version) == "4.1" and binary is not False:
        sink = ExpectedBytes(stream)
        msh41.write(cast(BinaryIO, sink), mesh)
        sink.finish()
    else:
        check_same(mesh, read(stream), kept_groups(mesh, version=version, binary=binary))


def read(stream: BinaryIO) -> HexMesh:
    """Read MSH 4.1 or 2.2, text or binary."""
    stream.seek(0)
    try:
        content = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
    except ValueError:
        raise InputError("it is empty") from None
    return read_content(content)
