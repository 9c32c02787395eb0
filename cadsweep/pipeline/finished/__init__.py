"""What is done to a finished mesh, by the vertices, edges, faces and cells that its nodes are in.

============ =======================================================================================
module       what it does
============ =======================================================================================
refinement   every hexahedron into eight; `family`: nested meshes
like         the mesh of one part on another: `matching` pairs their `graphs`, `template` is the mesh
model_faces  what of the model cells that cuts made lie on
derivatives  nodes by a parameter of the model; `movement` how far faces and edges go
pairs        nodes on matched faces
============ =======================================================================================
"""
