"""Edges and faces in groups: those that share a vertex or a face, in whatever order they are told."""

import pytest

pytest.importorskip("OCP")

import numpy as np

from cadsweep.cad.edit.together import Together


def connected(told):
    """The groups of what was told, one pair after the other until nothing changes."""
    groups = [(set(e), set(v), set(f)) for e, v, f in told]
    while True:
        pair = next(
            ((a, b) for a in groups for b in groups if a is not b and (a[1] & b[1] or a[2] & b[2])),
            None,
        )
        if pair is None:
            return {(frozenset(e), frozenset(f)) for e, _, f in groups}
        groups = [group for group in groups if group not in pair]
        groups.append(tuple(one | other for one, other in zip(*pair, strict=True)))


@pytest.mark.parametrize("seed", range(5))
def test_groups_are_what_hangs_together(seed):
    random = np.random.default_rng(seed)
    told = [({j}, set(random.integers(0, 40, 2).tolist()), set(random.integers(0, 60, 1).tolist())) for j in range(25)]
    together = Together()
    for edges, vertices, faces in told:
        together.join(edges, vertices, faces)
    found = {(frozenset(edges), frozenset(faces)) for edges, faces in together.groups.values()}
    assert found == connected(told)


def test_the_last_joined_stands_last():
    together = Together()
    for edge, vertex in ((0, 0), (1, 1), (2, 2), (3, 0)):
        together.join({edge}, {vertex}, set())
    assert [edges for edges, _ in together.groups.values()] == [{1}, {2}, {0, 3}]
