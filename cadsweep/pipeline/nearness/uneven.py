"""Edges around sweeps divided unevenly, so that a boundary comes nearer with few segments.

Place in the flow: :mod:`.cells_accuracy` asks for it where faces sag, before it divides their edges evenly. Only cells
whose linking sides nobody else has: what a neighbour takes part in is divided evenly.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from ...brep import Part
from ...plan import Plan
from ...surface import Division
from ...sweep import Intervals, Sweep
from .cap_sizes import InsideSizes, sizes_along_rims
from .curvature import divide_by_curvature


def divide_unevenly(  # noqa: PLR0917
    part: Part,
    plan: Plan,
    counts: Sequence[Intervals],
    sizes: Mapping[int, float],
    inside: InsideSizes | None,
    divisions: Mapping[int, Division],
    distance: float,
    *,
    kept: Collection[int],
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions, by key, of edges of caps that are bent, or whose cap is, in few places.

    Parameters
    ----------
    sizes : mapping of int to float
        Of the edges that are to be finer, divided evenly; by key, working units.
    inside : callable or None
        Wanted lengths on caps.
    divisions : mapping of int to callable
        How edges are divided unevenly already.
    distance : float
        Greatest distance of a chord from its edge.
    kept : collection of int
        Edges that stay as they are divided.
    """
    found: dict[int, float] = {}
    divided: dict[int, Division] = {}
    for cell in sorted(plan.by_themselves(part)):
        sweep = plan.ways[cell].fill
        assert isinstance(sweep, Sweep), "what is by itself is swept"
        keys = sweep.solid.edge_keys.tolist()
        fixed = {e for e, key in enumerate(keys) if key in kept}
        known = {e: divisions[key] for e, key in enumerate(keys) if key in divisions}
        present = {e.id: e.length / max(1, int(counts[cell].counts[e.id])) for e in sweep.solid.edges}
        finer = {e: sizes[key] for e, key in enumerate(keys) if key in sizes}
        lengths, own = divide_by_curvature(sweep, {e: present[e] for e in finer}, distance, fixed={*fixed, *known})
        if inside is not None:
            n = {e.id: e.length / (present | finer | lengths)[e.id] for e in sweep.solid.edges}
            along, more = sizes_along_rims(sweep, n, known | own, inside, fixed=fixed, uneven=True)
            lengths, own = lengths | along, own | more
        found |= {keys[e]: size for e, size in lengths.items()}
        divided |= {keys[e]: division for e, division in own.items()}
    return found, divided
