"""What the user asks for: words become keys of edges and faces, and these become rules before anything is meshed.

============== ===========================================================================================
module         what it does
============== ===========================================================================================
named_faces    the faces of cells that a word means; `edge_pieces` the pieces of an edge
shared_hints   sizes and counts by key, for every kind of part
biases         edges that are graded; `local_sizes`, `size_divisions` sizes that change from place to place
leaving        what leaves a wall with layers; `walls` says that to a sweep, `cell_walls`, `stack_walls` to others
periodic       faces that answer each other; `periodic_sides` as sides of a sweep, or walls of columns
hints          all of it for one sweep; `cell_asks` for cells, `stack_hints` and `stack_sizes` for columns
============== ===========================================================================================
"""
