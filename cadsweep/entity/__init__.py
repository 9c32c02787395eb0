"""What is done to a finished mesh: by the vertex, edge, face or cell of the CAD model that its nodes are in."""
