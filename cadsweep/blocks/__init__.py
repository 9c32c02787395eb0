"""A mesh as blocks: the factors of every cell, their names, and the ways to multiply them out.

========= =====================================================================
module    what it knows
========= =====================================================================
block     the factors of one sweep, and which of its quads bound which face
naming    what the boundaries are called
patches   quads of a merged face that go by the name of one of its pieces
reference the CAD figures that a mesh is checked against
files     factors as a file
stream    a mesh larger than memory, slab by slab
========= =====================================================================
"""
