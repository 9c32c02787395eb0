"""What must hold of every sweep and of every set of counts, whatever the part."""

from itertools import pairwise

import numpy as np


def ends(solid, chain):
    """First and last vertex of a chain of directed edges; fails where the chain is broken."""
    steps = [(solid.edges[e].start, solid.edges[e].end)[:: 1 if f else -1] for e, f in chain]
    for (_, b), (c, _) in pairwise(steps):
        assert b == c
    return steps[0][0], steps[-1][1]


def check_sweep(sweep):
    """Roles, directions and closedness of a sweep."""
    solid = sweep.solid
    sides = {side.face for side in sweep.linking_sides}
    roles = [*sweep.source, *sweep.target, *sides]
    assert sorted(roles) == list(range(len(solid.faces)))
    assert len(sides) == len(sweep.linking_sides)
    across = {e for side in sweep.linking_sides for e, _ in side.bottom + side.top}
    assert not across & set(sweep.rails)
    for side in sweep.linking_sides:
        bottom, right, top, left = (ends(solid, c) for c in (side.bottom, side.right, side.top, side.left))
        assert (bottom[1], right[1], left[0], top[0]) == (right[0], top[1], bottom[0], left[1])
        used = [*side.bottom, *side.right, *((e, not f) for e, f in side.top + side.left)]
        assert set(used) == set(solid.faces[side.face].loops[0].directed)
        assert {e for e, _ in side.left + side.right} <= set(sweep.rails)
    caps_edges = {False: set(), True: set()}
    for cap, loops, same in ((sweep.source, sweep.source_loops, False), (sweep.target, sweep.target_loops, True)):
        outline = {d for f in cap for loop in solid.faces[f].loops for d in loop.directed}
        rim = {d for d in outline if (d[0], not d[1]) not in outline}
        given = {(e, f == same) for loop in loops for e, f in loop}
        assert given == rim
        caps_edges[same] = {e for e, _ in given}
        for loop in loops:
            first, last = ends(solid, loop)
            assert first == last
    assert len(sweep.source_loops) == len(sweep.target_loops) == len(sweep.spans) == len(sweep.span_lengths)
    assert sum(len(spans) - 1 for spans in sweep.spans) == len(sweep.stations)
    assert sorted(e for spans in sweep.spans for span in spans for e in span) == sorted(sweep.rails)
    for ring in sweep.stations:
        degree = np.zeros(len(solid.vertices), dtype=int)
        for e in ring:
            degree[[solid.edges[e].start, solid.edges[e].end]] += 1
        assert set(degree[degree > 0]) == {2}
    if sweep.target_faces:
        assert set(sweep.target_faces) == set(sweep.source)
        assert set(sweep.target_faces.values()) == set(sweep.target)
    for e, (t, same) in sweep.target_edges.items():
        beside = {sweep.target_faces.get(f, f) for f in solid.edges[e].faces if f in sweep.source}
        if sweep.target_faces:
            assert beside <= set(solid.edges[t].faces)
        assert isinstance(same, bool)


def check_intervals(sweep, intervals):
    """Sums on opposite sides, layers along every loop, evenness of the source's loops."""
    counts = intervals.counts
    solid = sweep.solid
    assert [len(spans) for spans in intervals.span_layers] == [len(spans) for spans in sweep.spans]
    assert {sum(spans) for spans in intervals.span_layers} == {intervals.n_layers}
    assert counts.min() >= 1
    for side in sweep.linking_sides:
        bottom, right, top, left = (
            sum(counts[e] for e, _ in chain) for chain in (side.bottom, side.right, side.top, side.left)
        )
        assert bottom == top
        assert right == left
    for f in sweep.source:
        for loop in solid.faces[f].loops:
            assert sum(counts[e] for e in loop.edges) % 2 == 0
    height = {v: 0 for loop in sweep.source_loops for v in (ends(solid, loop[:1]))}
    waiting = list(sweep.linking_sides)
    while waiting:
        later = [side for side in waiting if not climb(solid, side, counts, height)]
        assert len(later) < len(waiting)
        waiting = later
    for loop in sweep.target_loops:
        for d in loop:
            assert height[ends(solid, [d])[0]] == intervals.n_layers
    for a, (b, _) in sweep.target_edges.items():
        assert counts[a] == counts[b]


def climb(solid, side, counts, height):
    """Put the vertices of a side on their layers; False where none of its corners is known yet."""
    if ends(solid, side.bottom)[0] not in height:
        return False
    for chain, step in ((side.bottom, 0), (side.right, 1), (side.left, 1), (side.top, 0)):
        for e, f in chain:
            a, b = (solid.edges[e].start, solid.edges[e].end)[:: 1 if f else -1]
            h = height[a] + step * counts[e]
            assert height.setdefault(b, h) == h
    return True
