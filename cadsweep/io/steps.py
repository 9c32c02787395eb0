"""Many positions of the nodes of one mesh in one ``.vtkhdf`` file: hexahedra once, points a time step.

Place in the flow: studies whose cases have one mesh write it; ParaView steps through it as time. Arrays are those of
:mod:`cadsweep.io.vtkhdf`, besides ``Points``, which has the points of all steps one after the other, and the group
``Steps``, which says where each begins.

References
----------
VTK file formats, "VTKHDF File Format", section "Transient data", version 2.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import BinaryIO

import h5py
import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..mesh import HexMesh
from . import vtk_cells
from .labels import label_mesh
from .vtkhdf import open_grid, write_arrays


def write_steps(
    stream: BinaryIO,
    mesh: HexMesh,
    steps: Iterable[FloatArray],
    *,
    times: Sequence[float],
    fields: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write the places (n, 3) of the nodes of `mesh` at every step.

    Parameters
    ----------
    times : sequence of float
        Of every step, rising.
    fields : mapping of str to array, optional
        What else is known of the steps: names, or numbers.

    Raises
    ------
    InputError
        A step has other nodes than the mesh.
    """
    labelled = label_mesh(mesh)
    n, n_steps = len(labelled.points), len(times)
    with h5py.File(stream, "w", libver=("v108", "v110")) as file:
        root = open_grid(file)
        for name, count in (("Points", n), ("Cells", len(mesh.hexes)), ("ConnectivityIds", mesh.hexes.size)):
            root[f"NumberOf{name}"] = np.array([count], dtype=np.int64)
        places = root.create_dataset("Points", (n_steps * n, 3), dtype=np.float64)
        for step, points in enumerate(steps):
            if points.shape != (n, 3):
                raise InputError(f"step {step} has points of shape {points.shape}; the mesh has ({n}, 3)")
            places[step * n : (step + 1) * n] = points
        root["Connectivity"] = labelled.hexes.reshape(-1)
        root["Offsets"] = vtk_cells.offsets(labelled.hexes)
        root["Types"] = vtk_cells.types(labelled.hexes)
        cells, names, _ = vtk_cells.grid_arrays(labelled)
        write_arrays(root.create_group("CellData"), cells)
        write_arrays(root.create_group("FieldData"), names)
        write_arrays(root.create_group("Cases"), dict(fields or {}))
        group = root.create_group("Steps")
        group.attrs["NSteps"] = np.int64(n_steps)
        group["Values"] = np.array(times, dtype=np.float64)
        nought = np.zeros(n_steps, dtype=np.int64)
        group["NumberOfParts"] = np.ones(n_steps, dtype=np.int64)
        group["PartOffsets"] = nought
        group["PointOffsets"] = np.arange(n_steps, dtype=np.int64) * n
        group["CellOffsets"] = nought[:, None]
        group["ConnectivityIdOffsets"] = nought[:, None]
        offsets = group.create_group("CellDataOffsets")
        for name in cells:
            offsets[name] = nought  # the same cell data at every step
        sizes = group.create_group("FieldDataSizes")
        starts = group.create_group("FieldDataOffsets")
        for name, values in names.items():
            sizes[name] = np.tile([1 if values.ndim == 1 else values.shape[1], len(values)], (n_steps, 1))
            starts[name] = nought
