"""One sweep as a part of one cell: its counts."""

from cadsweep.intervals import CellSweep, KeyDemand, Wishes, assign_shared_intervals


def assign_intervals(sweep, *, edge_sizes=None, edge_counts=None, **wishes):
    """Counts of the edges of a sweep, wishes by the ids of its edges."""
    keys = sweep.solid.edge_keys.tolist()
    demands = [
        KeyDemand(keys=tuple(keys[e] for e in edges), count=n, label="") for edges, n in (edge_counts or {}).items()
    ]
    sizes = {keys[e]: size for e, size in (edge_sizes or {}).items()}
    cell = CellSweep(fill=sweep, grids=tuple(sweep.linking_sides), free=sweep.source, by_itself=True)
    return assign_shared_intervals([cell], Wishes(edge_sizes=sizes, demands=demands, **wishes))[0]
