"""The composition root: the only package that joins the stages.

``load`` -> ``find_sweeps`` -> intervals -> surface -> projection -> smoothing -> quality. A candidate
sweep that turns out not to mesh makes room for the next best one, and the mesh says so in its notes;
the user's own choice of caps is never replaced.

============== =========================================================================
module or room what it joins
============== =========================================================================
meshing        what users call
routes         the ways to a mesh of one solid; `designs` and `fitted_grids` are two of them
run            seconds by stage, progress, the time that is left
parts          cad and recognition: a part, and the sweeps of its solid
attempts       what is tried to come to sweeps, as a table; `changes` does it
candidates     the loop over candidate sweeps: which are tried and noted
ranks          one mesh over many processes
origin         what a mesh was made from
tables         all rows of all tables
wishes/        the user's words as keys and rules
nearness/      as near to the CAD as is asked for
columns/       stacks
complexes/     one sweep, assemblies, and solids that are cut: a plan, cells on one skeleton, checks
finished/      refine, like, derivatives: by entity
============== =========================================================================

Names are loaded when first used, and so are the ways of `routes`: one sweep of one solid loads neither stacks nor
decomposition.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..collector import collector_resting

if TYPE_CHECKING:
    from ..progress import Progress
    from .complexes.decomposing import decompose
    from .directions import find_sweeps
    from .finished.derivatives import Sensitivity, sensitivity
    from .finished.family import Family, make_family
    from .finished.refinement import refine
    from .meshing import expand, figures, make_options, stream_mesh, sweep_mesh, write_factors
    from .parts import load

_HOMES = {
    "Family": ".finished.family",
    "Progress": "..progress",
    "Sensitivity": ".finished.derivatives",
    "decompose": ".complexes.decomposing",
    "expand": ".meshing",
    "figures": ".meshing",
    "find_sweeps": ".directions",
    "load": ".parts",
    "make_family": ".finished.family",
    "make_options": ".meshing",
    "refine": ".finished.refinement",
    "sensitivity": ".finished.derivatives",
    "stream_mesh": ".meshing",
    "sweep_mesh": ".meshing",
    "write_factors": ".meshing",
}

__all__ = [
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
