"""Intervals: how many segments every edge of the solid gets.

Place in the flow: takes a :class:`~cadsweep.topology.Sweep`, gives
:class:`~cadsweep.topology.Intervals` to ``surface``. :mod:`.sizes` derives the wanted counts,
:mod:`.layers` settles the edges along the sweep, :mod:`.loops` those along the loops: two integer
programmes, because no linking side ties the one kind to the other.

Not handled: counts that change from layer to layer (a hex mesh swept from one quad mesh cannot).
"""

from .assign import assign_intervals

__all__ = ["assign_intervals"]
