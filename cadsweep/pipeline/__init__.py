"""The composition root: the only package that joins the stages.

``load`` -> ``find_sweeps`` -> intervals -> surface -> projection -> smoothing -> quality. A candidate
sweep that turns out not to mesh makes room for the next best one, and the mesh says so in its notes;
the user's own choice of caps is never replaced.

========== =========================================================================
module     what it joins
========== =========================================================================
parts      cad and recognition: a part, and the sweeps of its solid
attempts   what is tried to come to sweeps, as a table
changes    what the attempts do: cut open, divide, merge
hints      the user's words for edges: sizes, counts, layers of rails
factoring  intervals, surface and projection: the factors of one sweep
candidates the loop over candidate sweeps: which are tried, smoothed, refused, noted
making     order 2 and checks: one candidate in memory
complexes  the cells of a part and a plan for them (`decomposing`, `assemblies` ask); `several` meshes and checks them
meshing    what users call
origin     what a mesh was made from
refinement every hexahedron into eight; `family`: nested meshes
like       the mesh of one part on another: `matching` pairs their `graphs`, `template` is the mesh
derivatives nodes by a parameter of the model
run        seconds by stage, progress
========== =========================================================================

Names are loaded when first used, and so are the ways of `routes`: one sweep of one solid loads neither stacks nor
decomposition.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..collector import collector_resting

if TYPE_CHECKING:
    from ..progress import Progress
    from .candidates import SMOOTH_BELOW, smoothed
    from .decomposing import decompose
    from .derivatives import Sensitivity, sensitivity
    from .directions import find_sweeps
    from .family import Family, make_family
    from .meshing import expand, figures, make_options, stream_mesh, sweep_mesh, write_factors
    from .parts import load
    from .refinement import refine

_HOMES = {
    "SMOOTH_BELOW": ".candidates",
    "Family": ".family",
    "Progress": "..progress",
    "Sensitivity": ".derivatives",
    "decompose": ".decomposing",
    "expand": ".meshing",
    "figures": ".meshing",
    "find_sweeps": ".directions",
    "load": ".parts",
    "make_family": ".family",
    "make_options": ".meshing",
    "refine": ".refinement",
    "sensitivity": ".derivatives",
    "smoothed": ".candidates",
    "stream_mesh": ".meshing",
    "sweep_mesh": ".meshing",
    "write_factors": ".meshing",
}

__all__ = [
    "SMOOTH_BELOW",
    "Family",
    "Progress",
    "Sensitivity",
    "decompose",
    "expand",
    "figures",
    "find_sweeps",
    "load",
    "make_family",
    "make_options",
    "refine",
    "sensitivity",
    "smoothed",
    "stream_mesh",
    "sweep_mesh",
    "write_factors",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'cadsweep.pipeline' has no attribute {name!r}")
    with collector_resting():
        value = getattr(import_module(_HOMES[name], __name__), name)
    globals()[name] = value
    return value
