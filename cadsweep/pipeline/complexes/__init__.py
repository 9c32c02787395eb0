"""Parts of cells, one or many: a plan for them, one skeleton, and a mesh that has passed its checks.

============ =======================================================================================
module       what it does
============ =======================================================================================
assemblies   solids that touch together, others side by side (`groups`, `beside`, `separate`)
decomposing  a solid that is cut, by the searches in a table
best         of the sets of cells that a search finds the one of the best mesh; poor cells are cut again
complex      cells and how each is filled; `swept` makes one of a lone sweep
complexes    which cells, and a plan; `planning` as plain rows
cells        the cells one after another on one skeleton; `corner_cells` those of blocks at corners
laying       their edges' divisions, sizes and rings, before a node is laid
several      from a plan to a mesh with names; `checking` checks, smooths and raises it
subsets      some of a part's cells alone
============ =======================================================================================
"""
