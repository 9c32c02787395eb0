"""What find_sweeps promises, on polyhedra made by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cadsweep.brief import MOST_LINES
from cadsweep.errors import InputError, NotSweepableError
from cadsweep.recognition import describe, find_sweeps
from cadsweep.recognition.score import parallelism

from .recognition_checks import check_sweep
from .recognition_solids import (
    bevelled_bar,
    block_with_pocket,
    box,
    box_with_split_side,
    plate_with_square_holes,
    prism,
    regular,
    renumbered,
    sharp_bracket,
    square,
    tetrahedron,
)

SOLIDS = {
    "box": lambda: box(1, 2, 3),
    "hexagon": lambda: prism(regular(6)),
    "triangle": lambda: prism(regular(3)),
    "plate": lambda: plate_with_square_holes(2),
    "split side": box_with_split_side,
    "stations": lambda: prism(square(), (0.0, 1.0, 1.5, 3.0)),
    "zigzag": lambda: prism(regular(5), (0.0, 1.0, 2.0), shifts=[(0, 0), (0.3, 0), (0, 0)]),
    "bevelled": bevelled_bar,
    "bracket": sharp_bracket,
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_sweep_is_whole_and_well_directed(name):
    sweeps = find_sweeps(SOLIDS[name]())
    for sweep in sweeps:
        check_sweep(sweep)
    scores = [sweep.score for sweep in sweeps]
    assert scores == sorted(scores, reverse=True)
    assert 0 < scores[-1] <= scores[0] <= 1


@settings(max_examples=25, deadline=None)
@given(name=st.sampled_from(sorted(SOLIDS)), seed=st.integers(0, 2**31))
def test_the_numbering_of_faces_does_not_matter(name, seed):
    solid = SOLIDS[name]()
    other, new = renumbered(solid, seed)
    found = {frozenset((frozenset(s.source), frozenset(s.target))) for s in find_sweeps(other)}
    assert found == {
        frozenset((frozenset(int(new[f]) for f in s.source), frozenset(int(new[f]) for f in s.target)))
        for s in find_sweeps(solid)
    }
    for sweep in find_sweeps(other):
        check_sweep(sweep)


def test_a_box_has_three_directions():
    pairs = {frozenset((s.source[0], s.target[0])) for s in find_sweeps(box())}
    assert pairs == {frozenset((0, 1)), frozenset((2, 4)), frozenset((3, 5))}


def test_plate_is_swept_through_its_thickness():
    (sweep,) = find_sweeps(plate_with_square_holes(3))
    assert {sweep.source, sweep.target} == {(0,), (1,)}
    assert len(sweep.source_loops) == 10
    outer = {v for e, _ in sweep.source_loops[0] for v in (sweep.solid.edges[e].start, sweep.solid.edges[e].end)}
    assert np.ptp(sweep.solid.vertices[sorted(outer)], axis=0).max() == 9.0


def test_stations_in_order_from_source_to_target():
    sweep = next(s for s in find_sweeps(prism(regular(5), (0.0, 1.0, 1.5, 3.0))) if len(s.source) == 1)
    heights = [sweep.solid.edges[ring[0]].midpoint[2] for ring in sweep.stations]
    upwards = sweep.source == (0,)
    assert heights == ([1.0, 1.5] if upwards else [1.5, 1.0])
    assert sweep.span_lengths[0] == pytest.approx((1.0, 0.5, 1.5) if upwards else (1.5, 0.5, 1.0))


def test_no_station_where_only_one_column_is_split():
    sweep = next(s for s in find_sweeps(box_with_split_side()) if {s.source, s.target} == {(0,), (1,)})
    assert sweep.stations == ()
    assert sorted(len(side.left) + len(side.right) for side in sweep.linking_sides) == [2, 2, 2, 3, 3]


def test_a_bevel_is_settled_with_its_neighbours():
    solid = bevelled_bar()
    for hint, n_stacked in (((0,), 0), ((3,), 1)):
        for sweep in find_sweeps(solid, source=hint):
            check_sweep(sweep)
            pentagons = [side for side in sweep.linking_sides if side.face in (0, 1)]
            assert all(len(s.bottom + s.right + s.top + s.left) == 5 for s in pentagons)
            assert len(pentagons) == 2 * n_stacked


def test_bracket_is_swept_through_its_folded_sheet():
    (sweep,) = find_sweeps(sharp_bracket())
    assert {sweep.source, sweep.target} == {(2, 7), (4, 5)}
    assert len(sweep.target_faces) == 2
    inner = next(e for e in sweep.target_edges if set(sweep.solid.edges[e].faces) <= set(sweep.source))
    assert set(sweep.solid.edges[sweep.target_edges[inner][0]].faces) == set(sweep.target)


def test_hints_choose_and_turn():
    solid = box(1, 2, 3)
    for f in range(6):
        assert [s.source for s in find_sweeps(solid, source=(f,))] == [(f,)]
        assert [s.target for s in find_sweeps(solid, target=(f,))] == [(f,)]
    assert [(s.source, s.target) for s in find_sweeps(solid, source=(1,), target=(0,))] == [((1,), (0,))]
    for sweep in find_sweeps(solid, source=(3,)):
        check_sweep(sweep)


def test_hints_that_fit_nothing_say_why():
    plate = plate_with_square_holes(1)
    with pytest.raises(NotSweepableError, match=r"(?s)no sweep has the source face 2 .*face 0 .*hole"):
        find_sweeps(plate, source=(2,))
    with pytest.raises(NotSweepableError):
        find_sweeps(box(), source=(0,), target=(2,))
    with pytest.raises(InputError, match="no face 17"):
        find_sweeps(box(), source=(17,))


@pytest.mark.parametrize(
    ("solid", "reason"),
    [(tetrahedron, "only 3 corners"), (block_with_pocket, "3 caps instead of 2")],
)
def test_refusals_have_a_reason_for_every_face(solid, reason):
    made = solid()
    with pytest.raises(NotSweepableError, match="no sweep") as caught:
        find_sweeps(made)
    assert len(str(caught.value).splitlines()) <= MOST_LINES
    assert any(reason in text for text in caught.value.reasons)
    assert len(caught.value.reasons) == len(made.faces)
    for face, text in zip(made.faces, caught.value.reasons, strict=True):
        assert text.startswith(face.label())
        assert "\n" not in text


def test_describe_gives_every_face_a_row_and_every_other_face_a_reason():
    solid = plate_with_square_holes(2)
    sweeps = find_sweeps(solid)
    tables = describe(solid, sweeps)
    assert [row["id"] for row in tables["faces"]] == list(range(len(solid.faces)))
    assert sorted({row["role"] for row in tables["faces"]}) == ["linking side", "source", "target"]
    assert len(tables["sweeps"]) == 1
    assert {row["face"] for row in tables["rejected"]} == set(range(2, len(solid.faces)))
    refused = block_with_pocket()
    with pytest.raises(NotSweepableError) as caught:
        find_sweeps(refused)
    tables = describe(refused, caught.value)
    assert tables["sweeps"] == []
    assert [row["reason"] for row in tables["rejected"]] == list(caught.value.reasons)


@pytest.mark.parametrize("shift", [0.0, 0.5, 2.0])
def test_rails_of_an_extrusion_are_parallel_however_oblique(shift):
    solid = prism(regular(5), (0.0, 1.0, 3.0), shifts=[(0, 0), (shift, 0), (3 * shift, 0)])
    sweep = max(find_sweeps(solid), key=lambda found: len(found.linking_sides))
    assert parallelism(sweep) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("name", ["hexagon", "plate", "zigzag"])
def test_parallelism_does_not_ask_which_cap_is_the_source(name):
    for sweep in find_sweeps(SOLIDS[name]()):
        (back,) = find_sweeps(sweep.solid, source=sweep.target, target=sweep.source)
        assert parallelism(back) == pytest.approx(parallelism(sweep), abs=1e-12)
        assert 0 < parallelism(sweep) <= 1
