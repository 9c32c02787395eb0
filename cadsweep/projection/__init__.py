"""Projection: from the source cap and the rings of all layers to every node of a sweep.

Place in the flow: between ``surface`` and ``smoothing``; numpy and scipy alone, no CAD in sight.

::

    fit_affine, pseudo_normal      the paper's maps, eqs. (6), (9), (10)         functionals, affine, fitting, normals
    project_target                 the target cap on its surface                 target, relax
    project_layers                 all layers of a sweep as one small product    layers, residual, factored, kernels
"""

from .affine import AffineMap, fit_affine
from .factored import FactoredSweep
from .layers import project_layers
from .normals import pseudo_normal
from .target import TargetCap, project_target

__all__ = [
    "AffineMap",
    "FactoredSweep",
    "TargetCap",
    "fit_affine",
    "project_layers",
    "project_target",
    "pseudo_normal",
]
