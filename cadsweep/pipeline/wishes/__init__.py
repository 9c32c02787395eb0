"""What the user asks for: words become keys of edges and faces, and these become rules before anything is meshed.

============== ===========================================================================================
module         what it does
============== ===========================================================================================
named_faces    the faces of cells that a word means; `edge_pieces` the pieces of an edge
shared_hints   sizes and counts by key, for every kind of part
biases         edges that are graded; `local_sizes`, `size_divisions` sizes that change from place to place
leaving        what leaves a wall with layers; `cell_walls` says that to cells, `walls`, `stack_walls` to columns
wall_heights   layers along walls kept as high through bends and tapers
periodic       faces that answer each other; `periodic_walls` as walls of columns
rails          layers of edges along a sweep
design_words   what words about the model mean on its design; `grid_sizes` where planes of a fitted grid are closer
cell_asks      all of it by key; `stack_hints`, `stack_sizes` what of it is on the plane of columns, and between levels
============== ===========================================================================================
"""
