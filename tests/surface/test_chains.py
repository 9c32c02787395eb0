"""Pieces of one edge are divided together: they are filled, and the ratio holds from end to end."""

import numpy as np
import pytest

from cadsweep.errors import InputError
from cadsweep.surface import Chain, ChainPiece, divided, graded_fractions, turned

KINDS = {"start": (True, False), "end": (False, True), "both": (True, True), "middle": (False, False)}


def chain(lengths, *, fine, ratio=None, share=None):
    return Chain(
        edges=tuple((e, e % 2 == 0) for e in range(len(lengths))),
        lengths=tuple(lengths),
        fine=fine,
        ratio=ratio,
        share=share,
        first=share,
    )


def segments(own, counts):
    """Lengths from end to end, and how the pieces run."""
    divisions = {e: ChainPiece(chain=own, place=place) for place, (e, _) in enumerate(own.edges)}
    found = divided(divisions, dict(enumerate(counts)))
    rows = [np.diff(found[e]) * length for (e, _), length in zip(own.edges, own.lengths, strict=True)]
    assert [row.sum() for row in rows] == pytest.approx(own.lengths)
    return np.concatenate([row if forward else row[::-1] for row, (_, forward) in zip(rows, own.edges, strict=True)])


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_at_the_nodes_of_the_whole_edge_are_divided_as_it_is(kind):
    whole = chain([10.0], fine=KINDS[kind], ratio=6.0)
    places = whole.whole(24) * 10.0
    lengths = np.diff(places[[0, 5, 16, 24]])
    assert segments(chain(lengths, fine=KINDS[kind], ratio=6.0), [5, 11, 8]) == pytest.approx(np.diff(places))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("counts", [(9, 6, 7), (6, 9, 5), (3, 14, 5)])
def test_any_counts_keep_the_ratio_between_the_ends(kind, counts):
    own = chain([4.0, 3.0, 5.0], fine=KINDS[kind], ratio=3.0)
    along = segments(own, counts)
    far = {"start": -1, "end": 0}.get(kind, len(along) // 2)
    ends = {"start": along[[0]], "end": along[[-1]]}.get(kind, along[[0, -1]])
    ratio = ends / along[far] if kind == "middle" else along[far] / ends
    assert ratio == pytest.approx(3.0)


def test_a_first_length_is_kept_and_one_that_cannot_be_is_refused():
    own = chain([4.0, 3.0, 5.0], fine=(False, True), share=0.02)
    assert segments(own, [6, 5, 9])[-1] == pytest.approx(0.24)
    with pytest.raises(InputError, match="gets 3 segments"):
        chain([1.0, 1.0, 1.0], fine=(True, False), share=1.2).divide({0: 1, 1: 1, 2: 1})


def test_shares_are_those_of_the_whole_edge_and_a_piece_alone_goes_on_across_its_ends():
    own = chain([2.0, 8.0], fine=(True, False), ratio=4.0)
    shares = own.shares(20.0)
    assert shares.sum() == pytest.approx(1.0)
    assert shares[0] > 0.2  # the fine end has more than its length
    alone = ChainPiece(chain=chain([1.0], fine=(True, False), ratio=4.0), place=0)
    assert alone(7) == pytest.approx(graded_fractions(7, start=4.0))
    assert turned(alone)(7) == pytest.approx(1.0 - graded_fractions(7, start=4.0)[::-1])


def test_a_piece_shorter_than_one_segment_leaves_the_ratio_to_the_others():
    own = chain([40.0, 0.5], fine=(True, False), ratio=3.0)
    along = segments(own, [12, 1])
    assert along[-1] == pytest.approx(0.5)
    assert along[-2] / along[0] == pytest.approx(3.0, rel=0.05)
