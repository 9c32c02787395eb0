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
refinement every hexahedron into eight (one sweep; `cells_refinement`: any other mesh); `family`: nested meshes
like       the mesh of one part on another: `matching` pairs their `graphs`, `template` is the mesh, `sweep_like` and
           `cells_like` carry it
derivatives nodes by a parameter of the model
run        seconds by stage, progress
========== =========================================================================
"""

from ..progress import Progress
from .candidates import SMOOTH_BELOW, smoothed
from .decomposing import decompose_part as decompose
from .derivatives import Sensitivity, sensitivity
from .directions import find_sweeps
from .family import Family, make_family
from .meshing import expand, figures, make_options, stream_mesh, sweep_mesh, write_factors
from .parts import load
from .refinement import refine

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
