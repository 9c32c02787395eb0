"""Decomposition: a solid that no sweep fits is cut into cells that all sweep and agree.

Place in the flow: between ``cad`` and ``plan``; ``pipeline`` gives it what recognises, plans and cuts as callables.

========== ===================================================================================
module     what it does
========== ===================================================================================
`curved`   the same through solids of any kind, by OpenCASCADE
`search`   :class:`Search`: which cut through which cell, best first
`planar`   a complex of cells with plane faces, in a pool of shared vertices and facets
`dividing` a cell cut by a plane, its neighbours' faces with it
`tracing`  polygons of a plane graph
`solids`   cells as ``brep.Solid``
`words`    what it says of itself
========== ===================================================================================
"""

from .planar import is_planar
from .search import Search, State
from .words import explain, explain_cells, outline_of, say, why_left

__all__ = ["Search", "State", "explain", "explain_cells", "is_planar", "outline_of", "say", "why_left"]
