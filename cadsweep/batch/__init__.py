"""Parameter studies: one script, many parameters, a table of results; broken off and taken up again.

Place in the flow: beside the command line, above ``pipeline``. Cases are meshed in worker processes
(:mod:`cadsweep.isolation`) that are kept from case to case, so that a bad case costs a line of the table, and a good
one what the same call costs in a process that has its libraries loaded.

A study is a TOML file::

    script = "elbow.py"              # beside the study file; a CAD file does as well
    format = "vtu"                   # a mesh file for every case; "none" keeps the figures alone
    timeout = 600                    # seconds a case
    max_memory = 4                   # GB a case
    same_mesh = true                 # all cases get the mesh of the first; options may not vary then

    [options]                        # of cadsweep.sweep_mesh, for all cases
    layers = 20

    [grid]                           # every combination of the values
    bend_radius = [30, 40, 50]
    angle = [45, 90]
    options.size = [1.0, 2.0]        # mesh options may vary too

    [[cases]]                        # and single cases
    name = "thin wall"
    wall = 0.5
    options.order = 2

A case is known by what it is: the script's text, its parameters, its options. The record of a finished
case is a file of its own, put in place in one step, so that a killed study loses no finished case and does
none again; a changed script or parameter makes a new case.

========= ===================================================
module    what it does
========= ===================================================
`study`   reads the file, makes the cases
`run`     shares the cases among workers, counts
`work`    one case, asked of a worker
`records` the folder of a case, and the table of all
`base`    the one mesh of a study of one mesh
========= ===================================================
"""

from __future__ import annotations

from .run import StudyResult, Tally, run_study
from .study import Case, Study, read_study

__all__ = ["Case", "Study", "StudyResult", "Tally", "read_study", "run_study"]
