"""Projection: from the source cap and the rings of all layers to every node of a sweep.

Place in the flow: between ``surface`` and ``smoothing``; numpy and scipy alone, no CAD in sight.

::

    fit_affine, pseudo_normal      the paper's maps, eqs. (6), (9), (10)         affine, normals
    project_layers                 all layers of a sweep as one small product    layers, residual, factored
"""

from .affine import AffineMap, fit_affine
from .factored import Corrections, FactoredSweep
from .layers import project_layers
from .normals import pseudo_normal

__all__ = ["AffineMap", "Corrections", "FactoredSweep", "fit_affine", "project_layers", "pseudo_normal"]
