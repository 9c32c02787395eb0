"""Work that may crash, hang or eat the memory runs in a process of its own.

Place in the flow: beside it. The command line runs every job here, and ``sweep_mesh(..., isolated=True)``
does so on request: OpenCASCADE and gmsh can end the interpreter on a damaged file, and nothing in the
same process can stop them. ``pebble`` starts the worker and notices its end or its time-out; this package
adds what a mesher needs: the stage under way, a memory limit, results of gigabytes, and nothing left behind.

========== ==============================================================================================
module     what it does
========== ==============================================================================================
`parent`   :func:`run_isolated`: starts the worker, hands on its progress, turns its end into an answer
`worker`   what the worker does first (own session, limits, silence) and last (the answer)
`place`    the temporary folders of one run and the guard that empties them if the caller is killed
`guard`    a script of a few milliseconds that outlives a killed caller
`transfer` arrays go through a file in memory, mapped and not copied
`context`  how the worker process is started
========== ==============================================================================================

What it does not do: it is no sandbox. A CadQuery script is a program with its user's rights. POSIX only
where limits and sessions are concerned.
"""

from __future__ import annotations

from .parent import run_isolated
from .place import leftovers

__all__ = ["leftovers", "run_isolated"]
