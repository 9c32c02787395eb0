"""Parts that no sweep fits: cuts are found until all cells sweep and agree, the same ones every time."""

import numpy as np
import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.decomposition.search import Search
from cadsweep.errors import PlanError
from cadsweep.plan import list_ways, make_plan
from cadsweep.recognition.find import search_sweeps

pytestmark = pytest.mark.cad


def recognise(solid):
    """Sweeps that the plan can use."""
    return [sweep for sweep in search_sweeps(solid, folds=False, most_readings=1).sweeps if list_ways([sweep])]


def search(shape):
    """A search through a shape."""
    (solid,) = load(shape).solids
    found = Search(model=solid, recognise=recognise, make_plan=make_plan)
    return solid, found, next(found.solutions(), None)


def pockets_in_adjacent_sides():
    """A block with one pocket from above and one from a side."""
    block = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().rect(10, 10).cutBlind(-6)
    return block.faces(">X").workplane(centerOption="CenterOfMass").rect(8, 6).cutBlind(-4)


def boxes_cross():
    """Three bars that cross in one place."""
    return cq.Workplane().box(30, 8, 8).union(cq.Workplane().box(8, 30, 8)).union(cq.Workplane().box(8, 8, 30))


def hollow_box():
    """A box with a void in the shape of a box."""
    return cq.Workplane().box(20, 20, 20).cut(cq.Workplane().box(8, 8, 8))


@pytest.mark.parametrize("shape", [pockets_in_adjacent_sides, boxes_cross, hollow_box])
def test_cells_that_sweep_and_agree_are_found(shape):
    solid, found, state = search(shape())
    assert state is not None
    assert len(state.plan.ways) == len(state.cells) == len(state.plan.order)
    assert sum(map(found.pool.volume, state.cells)) == pytest.approx(solid.volume, rel=1e-9)
    model_area = {f.id: f.area for f in solid.faces}
    area = dict.fromkeys(model_area, 0.0)
    for cell in state.cells:
        for f, _ in cell:
            if found.pool.facets[f].origin >= 0:
                area[found.pool.facets[f].origin] += found.pool.facets[f].area
    assert area == pytest.approx(model_area, rel=1e-9)


def test_where_cells_contradict_to_the_end_cuts_are_carried_on_through_what_they_imprint():
    (solid,) = load(boxes_cross()).solids

    def plan_of_bricks(part, fills):
        imprinted = [(c, f.id) for c, cell in enumerate(part.solids) for f in cell.faces if len(cell.faces) > 6]
        if imprinted:
            raise PlanError("a brick is imprinted", faces=imprinted)
        return "plan"

    found = Search(model=solid, recognise=lambda cell: ["anything"], make_plan=plan_of_bricks, most_states=2)
    state = next(found.solutions())
    assert found.carries_on
    assert [len(cell) for cell in state.cells] == [6] * 7  # six arms about the cube that they have in common
    assert found.n_states > 2


def test_the_same_part_gets_the_same_cuts():
    cuts = [search(pockets_in_adjacent_sides())[2].cuts for _ in range(2)]
    assert cuts[0] == cuts[1]


def test_a_part_that_sweeps_is_not_cut():
    _, found, state = search(cq.Workplane().box(3, 4, 5).edges("|Z").chamfer(0.5))
    assert state.cuts == ()
    assert found.n_states == 1


def test_cells_read_from_the_complex_measure_what_the_cad_measures():
    (solid,) = load(pockets_in_adjacent_sides()).solids
    found = Search(model=solid, recognise=recognise, make_plan=make_plan)
    next(found.solutions())
    cell = min(found.seen, key=lambda c: found.seen[c].solid.volume < solid.volume - 1e-6)
    own = found.seen[cell].solid
    for key, mine, theirs in (
        ("area", [f.area for f in own.faces], [f.area for f in solid.faces]),
        ("dihedral", sorted(e.dihedral for e in own.edges), sorted(e.dihedral for e in solid.edges)),
        ("length", sorted(e.length for e in own.edges), sorted(e.length for e in solid.edges)),
    ):
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, err_msg=key)
    for mine, theirs in zip(own.faces, solid.faces, strict=True):
        np.testing.assert_allclose(mine.center, theirs.center, atol=1e-9)
        np.testing.assert_allclose(mine.normal, theirs.normal, atol=1e-9)
        assert mine.key == theirs.key
