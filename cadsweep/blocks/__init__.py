"""A mesh as blocks: the factors of every cell, their names, and the ways to multiply them out.

============ =====================================================================
module       what it knows
============ =====================================================================
naming       what the boundaries are called
former_faces quads of a merged face that go by the name of one of its pieces
reference    the CAD figures that a mesh is checked against
files        factors as a file
cells        cells on one skeleton, their insides as factors
joined       the same as arrays; ``finish`` gives them names
slabs        blocks that are made some layers at a time
block_mesh   blocks in one numbering, with the surface of their parts
stream       a mesh larger than memory, slab by slab
pieces       what each of several processes makes of it
halved_cells a hexahedron in eight, for refinement
============ =====================================================================
"""
