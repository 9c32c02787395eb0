"""From OpenCASCADE solids to :mod:`cadsweep.brep` values: ids, loops, angles, geometry, keys."""
