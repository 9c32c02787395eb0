"""Patches of merged faces: every quad has one owner, every owner a quad where there are enough."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cadsweep.blocks.former_faces import describe_shares, own_quads


def strip(n_quads: int, cuts: list[float]) -> tuple[np.ndarray, SimpleNamespace]:
    """Quads (n, 4, 3) in a row of length 1, on a face with a patch between any two cuts; the rest is its own."""
    x = np.linspace(0.0, 1.0, n_quads + 1)
    corners = np.zeros((n_quads, 4, 3))
    corners[:, [0, 3], 0], corners[:, [1, 2], 0] = x[:-1, None], x[1:, None]
    corners[:, 2:, 1] = 1.0
    former = [
        SimpleNamespace(
            area=b - a,
            place=np.array([(a + b) / 2, 0.5, 0.0]),
            piece_at=lambda points, a=a, b=b: (a <= points[:, 0]) & (points[:, 0] < b),
            pieces=(True,),
        )
        for a, b in pairwise(cuts)
    ]
    return corners, SimpleNamespace(former=former, label=lambda: "face 3")


@given(
    st.integers(1, 12),
    st.lists(st.integers(0, 97), min_size=2, max_size=4, unique=True).map(lambda cuts: sorted(c / 97 for c in cuts)),
)
def test_who_has_no_quad_is_named(n_quads, cuts):
    corners, face = strip(n_quads, cuts)
    owners = own_quads(corners, face)
    names = [f"n{j}" for j in range(len(cuts))]
    assert set(owners.tolist()) <= set(range(len(names)))
    without = {name for j, name in enumerate(names) if not (owners == j).any()}
    notes = describe_shares(corners, owners, face, names)
    assert {name for name in names if any(f"'{name}' has no quads" in note for note in notes)} == without
    assert bool(without) <= (n_quads < 2 * len(names))


def test_a_quad_is_owned_where_its_middle_is():
    corners, face = strip(8, [0.25, 0.5])
    assert own_quads(corners, face).tolist() == [0, 0, 1, 1, 0, 0, 0, 0]


def test_pieces_smaller_than_a_quad_get_the_nearest_and_one_stays_for_the_rest():
    corners, face = strip(2, [0.1, 0.11])
    assert own_quads(corners, face).tolist() == [1, 0]
    corners, face = strip(3, [0.0, 1.0])
    assert sorted(own_quads(corners, face).tolist()) == [0, 1, 1]
