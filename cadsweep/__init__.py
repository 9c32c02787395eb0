"""cadsweep: extrusion-like CAD parts become meshes of hexahedra by sweeping.

Names are loaded when first used: ``import cadsweep`` imports neither OpenCASCADE nor gmsh.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import verbs
from ._version import __version__

if TYPE_CHECKING:
    from .app.notebook import open_part as open
    from .asked import EdgeBias, LocalSize, WallLayers
    from .brep import Part
    from .errors import (
        CadError,
        CadSweepError,
        InputError,
        InvertedHexError,
        NotSweepableError,
        ProjectionError,
        SurfaceMeshError,
        UnknownNameError,
        WorkerError,
    )
    from .io import read
    from .mesh import HexMesh
    from .pipeline import decompose, find_sweeps, load, make_family, refine, sensitivity, stream_mesh, sweep_mesh
    from .quality import QualityReport
    from .sweep import Sweep

_HOMES = {
    "CadError": "errors",
    "CadSweepError": "errors",
    "InputError": "errors",
    "InvertedHexError": "errors",
    "NotSweepableError": "errors",
    "ProjectionError": "errors",
    "SurfaceMeshError": "errors",
    "UnknownNameError": "errors",
    "EdgeBias": "asked",
    "LocalSize": "asked",
    "WallLayers": "asked",
    "WorkerError": "errors",
    "HexMesh": "mesh",
    "Part": "brep",
    "QualityReport": "quality",
    "Sweep": "sweep",
    "decompose": "pipeline",
    "find_sweeps": "pipeline",
    "load": "pipeline",
    "make_family": "pipeline",
    "refine": "pipeline",
    "sensitivity": "pipeline",
    "open": "app.notebook",
    "read": "io",
    "stream_mesh": "pipeline",
    "sweep_mesh": "pipeline",
}

_VERBS = {
    "check_mesh": "quality",
    "mesh_summary_html": "report",
    "part_card": "report",
    "plot": "view",
    "plot_report": "view",
    "report_card": "report",
    "sweep_card": "report",
    "to_pyvista": "view",
    "write": "io",
}
"""Rooms of what values do for their users: see :mod:`.verbs`."""

__all__ = [
    "CadError",
    "CadSweepError",
    "EdgeBias",
    "HexMesh",
    "InputError",
    "InvertedHexError",
    "LocalSize",
    "NotSweepableError",
    "Part",
    "ProjectionError",
    "QualityReport",
    "SurfaceMeshError",
    "Sweep",
    "UnknownNameError",
    "WallLayers",
    "WorkerError",
    "__version__",
    "decompose",
    "find_sweeps",
    "load",
    "make_family",
    "open",
    "read",
    "refine",
    "sensitivity",
    "stream_mesh",
    "sweep_mesh",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'cadsweep' has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), "open_part" if name == "open" else name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


verbs.look_up_by(lambda verb: getattr(import_module(f".{_VERBS[verb]}", __name__), verb))
