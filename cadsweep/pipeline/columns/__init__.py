"""A stack of columns from its plane to a mesh: `stacking` is the way, `stack_plane` meshes the plane."""
