"""Work that may crash, hang or eat the memory runs in a process of its own.

Place in the flow: beside it. The command line runs every job here, and ``sweep_mesh(..., isolated=True)``
does so on request: OpenCASCADE and gmsh can end the interpreter on a damaged file, and nothing in the
same process can stop them. A worker may be kept for many tasks (a study's cases), so that the libraries are loaded
once; it is ended only where a task crashed, hung, ate its memory or left something that cannot be put back.

========== ==============================================================================================
module     what it does
========== ==============================================================================================
`parent`   :class:`Worker`, and :func:`run_isolated` for one task: starts it, hands on its progress, turns its end into
           an answer
`worker`   what the worker does first (own session, silence), for every task (limits, the answer) and after it
`place`    the temporary folders of a worker and the guard that empties them if the caller is killed
`guard`    a script of a few milliseconds that outlives a killed caller
`transfer` arrays go through a file in memory, mapped and not copied
`process`  how the worker process is started
`channel`  the messages between the two
========== ==============================================================================================

What it does not do: it is no sandbox. A CadQuery script is a program with its user's rights. POSIX only
where limits and sessions are concerned.
"""

from __future__ import annotations

from .parent import Worker, run_isolated
from .place import leftovers

__all__ = ["Worker", "leftovers", "run_isolated"]
