"""Recognition: which faces of a solid are source, target and linking sides.

Place in the flow: takes a :class:`~cadsweep.brep.Solid` from ``cad``, gives a list of
:class:`~cadsweep.sweep.Sweep` to ``intervals`` and ``surface``. The method is in :mod:`.find`.
"""

from .alike import sweeps_of_each
from .corner_blocks import find_corner_blocks
from .description import describe
from .edges import describe_edges
from .find import find_sweeps, search_sweeps
from .growth import find_roundings, worst_rim
from .outlines import ALIKE, find_divisions
from .revolution import find_axis
from .rings import may_be_ring, why_not_closed

__all__ = [
    "ALIKE",
    "describe",
    "describe_edges",
    "find_axis",
    "find_corner_blocks",
    "find_divisions",
    "find_roundings",
    "find_sweeps",
    "may_be_ring",
    "search_sweeps",
    "sweeps_of_each",
    "why_not_closed",
    "worst_rim",
]
