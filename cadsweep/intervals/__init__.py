"""Intervals: how many segments every edge of the solid gets.

Place in the flow: takes a :class:`~cadsweep.sweep.Sweep`, or cells, gives
:class:`~cadsweep.sweep.Intervals` to ``surface``. :mod:`.sizes` derives the wanted counts,
:mod:`.whole` settles all edges of a part together, by the :mod:`.equations` between them: :mod:`.loops` knows those of
caps, :mod:`.levels` those along a sweep, :mod:`.rails` chains of rails and spans.

Not handled: counts that change from layer to layer (a hex mesh swept from one quad mesh cannot).
"""

from .cell_sweeps import CellSweep, KeyDemand, Wishes
from .rails import rail_chains, span_chain
from .sizes import Split, default_size
from .whole import assign_shared_intervals, cell_sizes

__all__ = [
    "CellSweep",
    "KeyDemand",
    "Split",
    "Wishes",
    "assign_shared_intervals",
    "cell_sizes",
    "default_size",
    "rail_chains",
    "span_chain",
]
