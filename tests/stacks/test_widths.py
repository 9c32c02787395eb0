"""How wide cells are at their edges, and segments that are no longer than that."""

import cadquery as cq
import numpy as np
import pytest

from cadsweep import load
from cadsweep.intervals import Wishes
from cadsweep.pipeline.columns.stack_narrow import narrow_hints
from cadsweep.pipeline.columns.stacking import find_stacks
from cadsweep.pipeline.wishes.cell_asks import CellAsks
from cadsweep.pipeline.wishes.stack_hints import StackHints
from cadsweep.stacks import Widths
from cadsweep.stacks.widths import pairs_across


def stack():
    """A block of 20 x 10 with a pocket of 4 x 4 whose wall is 0.5 from the short side at x = 10."""
    part = load(cq.Workplane().box(20, 10, 4).cut(cq.Workplane("XY", (7.5, 0, 0)).rect(4, 4).extrude(4)))
    return find_stacks(part)[0], part.scale


def test_the_width_beside_a_wall_is_the_distance_to_it():
    found, scale = stack()
    widths = Widths(found, 2.0 / scale)
    least = {e: own.min() * scale for e, own in widths.widths.items() if np.isfinite(own).any()}
    assert min(least.values()) == pytest.approx(0.5)
    # The side, the pocket's wall along it, and two of its walls that end there: none sees one that it meets.
    assert sum(width == pytest.approx(0.5) for width in least.values()) == 4
    for e, fractions in widths.fractions.items():
        assert (np.diff(fractions) >= 0.0).all()
        assert fractions[[0, -1]].tolist() == [0.0, 1.0]
        assert len(widths.places[e]) == len(widths.widths[e]) == len(fractions)


def test_cells_that_are_asked_together_have_the_pairs_of_each_alone():
    found, scale = stack()
    prism, reach = found.arrangement.prism, 2.0 / scale
    places = Widths(found, reach).places
    cells = [prism.faces[f].edges for f in found.arrangement.bottoms]
    together = pairs_across(prism.edges, cells, places, reach)
    assert len(cells) > 1
    assert len(together.one) > 0
    for c, edges in enumerate(cells):
        alone = pairs_across(prism.edges, [edges], places, reach)
        mine = [own[together.cell == c] for own in together]
        assert all(np.array_equal(a, b) for a, b in zip(alone[1:], mine[1:], strict=True))


def test_segments_are_as_short_as_cells_are_narrow_and_longer_away_from_there():
    found, scale = stack()
    size = 4.0 / scale
    edges = found.arrangement.prism.edges
    hints = narrow_hints(found, StackHints(plane=CellAsks(wishes=Wishes())), np.ones(len(edges), dtype=np.int64), size)
    plane = hints.plane
    side = max(plane.divisions, key=lambda e: edges[e].length)
    n = round(edges[side].length / plane.wishes.most_sizes[side])
    steps = np.diff(plane.divisions[side](n)) * edges[side].length * scale
    assert steps.sum() == pytest.approx(edges[side].length * scale)
    assert (steps[1:] / steps[:-1]).max() < 3.0


def test_what_the_user_asked_of_an_edge_stays():
    found, scale = stack()
    edges = found.arrangement.prism.edges
    sizes = dict.fromkeys(found.arrangement.over, 3.0)
    asked = StackHints(plane=CellAsks(wishes=Wishes(edge_sizes=sizes)))
    hints = narrow_hints(found, asked, np.ones(len(edges), dtype=np.int64), 4.0 / scale)
    assert (hints.plane.wishes.most_sizes, hints.plane.divisions) == ({}, {})
    assert hints.plane.wishes.edge_sizes == sizes
