"""Intervals: how many segments every edge of the solid gets.

Place in the flow: takes a :class:`~cadsweep.sweep.Sweep`, gives
:class:`~cadsweep.sweep.Intervals` to ``surface``. :mod:`.sizes` derives the wanted counts,
:mod:`.layers` settles the edges along the sweep, :mod:`.loops` those along the loops: two integer
programmes, because no linking side ties the one kind to the other. :mod:`.rails` knows chains of rails and spans.
:mod:`.whole` settles all edges of a part of several cells together, by the :mod:`.equations` between them.

Not handled: counts that change from layer to layer (a hex mesh swept from one quad mesh cannot).
"""

from .assign import assign_intervals
from .cell_sweeps import CellSweep, KeyDemand, Wishes
from .rails import rail_chains, span_chain
from .sizes import Split, default_size
from .whole import assign_shared_intervals, cell_sizes

__all__ = [
    "CellSweep",
    "KeyDemand",
    "Split",
    "Wishes",
    "assign_intervals",
    "assign_shared_intervals",
    "cell_sizes",
    "default_size",
    "rail_chains",
    "span_chain",
]
