"""Nodes of a CGNS tree in HDF5.

Place in the flow: for :mod:`.cgns` and :mod:`.cgns_grids`.

References
----------
CGNS, "SIDS-to-HDF5 file mapping" (cgns.github.io).
"""

from __future__ import annotations

from collections.abc import Iterator

import h5py
import numpy as np

from .hdf5 import load


def node(parent: h5py.Group, name: str, label: str, data: np.ndarray | str | None) -> h5py.Group:
    """Make a node of a CGNS tree; text, an array whose axes are turned as HDF5 has them, or nothing."""
    group = parent.create_group(name, track_order=True)
    if isinstance(data, str):
        data, kind = np.frombuffer(data.encode(), dtype=np.int8), "C1"
    elif data is None:
        kind = "MT"
    else:
        kind = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8"}[data.dtype.str[1:]]
    attributes(group, name, label, kind)
    if data is not None:
        group[" data"] = data
    return group


def attributes(group: h5py.Group, name: str, label: str, kind: str) -> None:
    """What every node says of itself."""
    for key, text, length in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
        group.attrs.create(key, text.encode(), dtype=h5py.string_dtype("ascii", length))
    if label != "Root Node of HDF5 File":
        group.attrs["flags"] = np.array([1], dtype=np.int32)


def children(group: h5py.Group, label: str) -> Iterator[h5py.Group]:
    """Nodes under one, of a label."""
    for child in group.values():
        if isinstance(child, h5py.Group) and child.attrs.get("label", b"").strip(b"\0 ") == label.encode():
            yield child


def data(group: h5py.Group) -> np.ndarray:
    """The array of a node."""
    return load(group[" data"])


def text(group: h5py.Group) -> str:
    """The name of a node."""
    return group.attrs["name"].decode("ascii", "replace").strip("\0 ")
