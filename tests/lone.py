"""One sweep as a part of one cell: its counts, and its boundary as projection takes it."""

from cadsweep.intervals import CellSweep, KeyDemand, Wishes, assign_shared_intervals
from cadsweep.surface import Skeleton, boundary_of, lay_rings, opposite_angles, surface_mesh


def assign_intervals(sweep, *, edge_sizes=None, edge_counts=None, **wishes):
    """Counts of the edges of a sweep, wishes by the ids of its edges."""
    keys = sweep.solid.edge_keys.tolist()
    demands = [
        KeyDemand(keys=tuple(keys[e] for e in edges), count=n, label="") for edges, n in (edge_counts or {}).items()
    ]
    sizes = {keys[e]: size for e, size in (edge_sizes or {}).items()}
    cell = CellSweep(fill=sweep, grids=tuple(sweep.linking_sides), free=sweep.source, by_itself=True)
    return assign_shared_intervals([cell], Wishes(edge_sizes=sizes, demands=demands, **wishes))[0]


def mesh_surfaces(sweep, counts):
    """The boundary of a sweep but for its target."""
    rings = lay_rings(sweep, counts, {}, {})
    skeleton = Skeleton([sweep.solid], [counts], rings={0: rings})
    for side in sweep.linking_sides:
        skeleton.lay_grid(0, side)
    skeleton.lay_source(0, sweep, opposite_angles(sweep, rings.layout.labels()[2][[0, -1]]))
    return surface_mesh(boundary_of(skeleton, 0, sweep), skeleton, 0, sweep)
