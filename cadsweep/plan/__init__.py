"""One sweep for every cell of a part, chosen together: who meshes which shared face, and in what order.

Place in the flow: ``recognition`` gives the candidate sweeps of each cell; ``intervals`` and ``surface`` follow the
:class:`Plan`. :mod:`.ways` lists what a candidate asks of the faces of its cell, :mod:`.search` chooses, :mod:`.around`
begins where cells follow each other around a ring.

Not handled: rings whose section does not come back to itself, and two caps that carry outlines which do not answer each
other; these plans are refused, the latter with the faces.
"""

from .search import Plan, make_plan
from .ways import Fill, Role, Way, list_ways, way_of

__all__ = ["Fill", "Plan", "Role", "Way", "list_ways", "make_plan", "way_of"]
