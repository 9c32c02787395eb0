"""Counts of segments: identities on every sweep, wishes and demands."""

from itertools import product

import numpy as np
import pytest
import scipy
from hypothesis import given, settings
from hypothesis import strategies as st

from cadsweep.errors import InputError, SurfaceMeshError
from cadsweep.intervals.balance import balance
from cadsweep.intervals.programme import Programme
from cadsweep.recognition import find_sweeps

from ..lone import assign_intervals
from .recognition_checks import check_intervals
from .recognition_solids import box, box_with_split_side, plate_with_square_holes, prism, regular, square
from .test_find import SOLIDS


@pytest.mark.parametrize("name", SOLIDS)
def test_counts_fit_on_every_sweep(name):
    for sweep in find_sweeps(SOLIDS[name]()):
        check_intervals(sweep, assign_intervals(sweep))


@settings(max_examples=40, deadline=None)
@given(name=st.sampled_from(sorted(SOLIDS)), size=st.floats(0.02, 2.0), layers=st.none() | st.integers(3, 40))
def test_counts_fit_for_every_size(name, size, layers):
    sweep = find_sweeps(SOLIDS[name]())[0]
    found = assign_intervals(sweep, size=min(size, sweep.solid.size), layers=layers)
    check_intervals(sweep, found)
    if layers is not None:
        assert found.n_layers == layers


def test_default_makes_some_thousand_hexes():
    for name, make in SOLIDS.items():
        sweep = find_sweeps(make())[0]
        found = assign_intervals(sweep)
        area = sum(sweep.solid.faces[f].area for f in sweep.source)
        assert 1e3 <= area / found.size**2 * found.n_layers <= 1e5, name


def test_size_is_met_where_it_divides_the_edges():
    found = assign_intervals(find_sweeps(box(1, 2, 3), source=(0,))[0], size=0.25)
    assert found.n_layers == 12
    lengths = [edge.length for edge in box(1, 2, 3).edges]
    np.testing.assert_array_equal(found.counts, np.round(np.array(lengths) / 0.25))


def test_thin_parts_get_two_layers_by_default():
    assert assign_intervals(find_sweeps(box(100, 100, 0.01), source=(0,))[0]).n_layers == 2


@pytest.mark.parametrize(("layers", "spans"), [(12, (4, 2, 6)), (24, (8, 4, 12)), (3, (1, 1, 1)), (6, (2, 1, 3))])
def test_layers_are_shared_by_length(layers, spans):
    solid = prism(regular(5), (0.0, 1.0, 1.5, 3.0))
    sweep = next(s for s in find_sweeps(solid, source=(0,)) if len(s.source) == 1)
    found = assign_intervals(sweep, layers=layers)
    assert found.n_layers == layers
    assert tuple(int(found.counts[span[0]]) for span in sweep.spans[0]) == spans
    check_intervals(sweep, found)


def test_fewer_layers_than_spans_names_the_stations():
    sweep = find_sweeps(prism(regular(5), (0.0, 1.0, 1.5, 3.0)), source=(0,))[0]
    with pytest.raises(InputError, match=r"(?s)layers=2 is fewer than the 3 that.*station 1 of edges .*station 2"):
        assign_intervals(sweep, layers=2)


def test_a_split_column_needs_two_layers():
    sweep = next(s for s in find_sweeps(box_with_split_side()) if {s.source, s.target} == {(0,), (1,)})
    with pytest.raises(InputError, match="layers=1"):
        assign_intervals(sweep, layers=1)
    check_intervals(sweep, assign_intervals(sweep, layers=2))


def test_demanded_counts_are_kept():
    sweep = find_sweeps(plate_with_square_holes(1))[0]
    edge = sweep.source_loops[1][0][0]
    found = assign_intervals(sweep, edge_counts={(edge,): 7, (sweep.rails[0],): 5})
    assert found.counts[edge] == 7
    assert found.n_layers == 5
    check_intervals(sweep, found)


def test_an_edge_size_changes_its_edge():
    sweep = find_sweeps(plate_with_square_holes(1))[0]
    edge = sweep.source_loops[1][0][0]
    found = assign_intervals(sweep, size=0.5, edge_sizes={edge: 0.1})
    assert abs(int(found.counts[edge]) - 10) <= 1
    check_intervals(sweep, found)


def test_demands_that_contradict_each_other_name_their_edges():
    sweep = find_sweeps(plate_with_square_holes(1))[0]
    edge, _ = sweep.source_loops[1][0]
    with pytest.raises(SurfaceMeshError, match=f"(?s)edge {edge} .*equal counts"):
        assign_intervals(sweep, edge_counts={(edge,): 4, (sweep.target_edges[edge][0],): 5})
    odd = {(e,): 1 for e, _ in sweep.source_loops[1][:-1]} | {(sweep.source_loops[1][-1][0],): 2}
    with pytest.raises(SurfaceMeshError, match=f"(?s)edge {edge} .*even"):
        assign_intervals(sweep, edge_counts=odd)
    with pytest.raises(InputError, match=f"edge {sweep.rails[0]} "):
        assign_intervals(sweep, edge_counts={(sweep.rails[0],): 3, (sweep.rails[1],): 4})


def test_a_size_that_would_never_end_is_refused():
    with pytest.raises(InputError, match="larger size"):
        assign_intervals(find_sweeps(box())[0], size=1e-9)


def test_counts_scale_with_the_part():
    small, large = (prism(square(s), (0.0, 3.0 * s)) for s in (1.0, 1000.0))
    a, b = (assign_intervals(find_sweeps(s)[0]) for s in (small, large))
    np.testing.assert_array_equal(a.counts, b.counts)


def test_a_size_on_a_rail_sets_its_span_alone():
    sweep = find_sweeps(prism(regular(5), (0.0, 1.0, 1.5, 3.0)), source=(0,))[0]
    found = assign_intervals(sweep, size=0.25, edge_sizes={sweep.spans[0][1][0]: 0.05})
    assert [int(found.counts[span[0]]) for span in sweep.spans[0]] == [4, 10, 6]
    check_intervals(sweep, found)


@settings(max_examples=30, deadline=None)
@given(
    name=st.sampled_from(sorted(SOLIDS)), seed=st.integers(0, 10**6), rail=st.integers(1, 30), around=st.integers(2, 30)
)
def test_demands_are_met_or_named(name, seed, rail, around):
    sweep = find_sweeps(SOLIDS[name]())[0]
    solid = sweep.solid
    rails, others = sorted(sweep.rails), [edge.id for edge in solid.edges if edge.id not in sweep.rails]
    along, across = rails[seed % len(rails)], others[seed % len(others)]
    said = ""
    try:
        found = assign_intervals(sweep, edge_counts={(along,): rail, (across,): around})
    except (InputError, SurfaceMeshError) as error:
        said = str(error)
    if said:
        assert f"{rail} on edge {along} " in said or f"{around} on edge {across} " in said
        return
    assert (found.counts[along], found.counts[across]) == (rail, around)
    check_intervals(sweep, found)


def test_sums_are_demanded_of_several_edges():
    sweep = find_sweeps(prism(regular(6), (0.0, 1.0, 3.0)), source=(0,))[0]
    loop = [e for e, _ in sweep.source_loops[0]]
    chain = (sweep.spans[0][0][0], sweep.spans[0][1][0])
    found = assign_intervals(sweep, size=0.5, edge_counts={tuple(loop[:2]): 14, chain: 12})
    assert [int(found.counts[e]) for e in loop[:2]] == [7, 7]
    # Twelve layers over spans of length 1 and 2
    assert [int(found.counts[e]) for e in chain] == [4, 8]
    assert found.n_layers == 12
    check_intervals(sweep, found)


def test_only_the_demands_that_clash_are_named():
    sweep = find_sweeps(prism(regular(6), (0.0, 1.0, 3.0)), source=(0,))[0]
    first, second = sweep.spans[0][0][:2]
    innocent = sweep.spans[0][1][0]
    with pytest.raises(InputError, match=f"3 on edge {first} .*4 on edge {second} ") as caught:
        assign_intervals(sweep, edge_counts={(innocent,): 5, (first,): 3, (second,): 4})
    assert f"edge {innocent} " not in str(caught.value)


def test_edges_along_and_around_may_share_a_count():
    sweep = find_sweeps(box())[0]
    both = sweep.rails[0], sweep.source_loops[0][0][0]
    found = assign_intervals(sweep, edge_counts={both: 8})
    assert sum(int(found.counts[e]) for e in both) == 8
    check_intervals(sweep, found)


@pytest.mark.parametrize("times", [1, 3])
def test_what_hangs_together_is_stretched_by_one_factor_however_often_that_is_said(times):
    want = np.array([9.0, 4.0, 5.0, 7.0])
    sums = np.array([[1.0, -1.0, -1.0, 0.0]] * times + [[1.0, 0.0, 0.0, 0.0]])
    totals = np.array([0.0] * times + [18.0])
    found = balance(want, np.zeros(4, dtype=bool), scipy.sparse.csr_array(sums), totals)
    np.testing.assert_allclose(found, [18.0, 8.0, 10.0, 7.0], rtol=1e-5)


@given(
    want=st.lists(st.floats(0.3, 6.0), min_size=4, max_size=4),
    weight=st.lists(st.floats(0.2, 3.0), min_size=4, max_size=4),
)
@settings(max_examples=40, deadline=None)
def test_no_counts_near_the_wanted_ones_that_keep_the_sums_are_cheaper(want, weight):
    """Held against all counts within two of what is wanted, one class at least 2; a hundredth is left to the search."""
    sums, evens, least = [{0: 1.0, 1: -1.0, 2: -1.0}], [{1: 1, 3: 1}], {3: 2}
    programme = Programme(
        want=np.array(want), weight=np.array(weight), demanded={}, firm=(), sums=sums, evens=evens, least=least
    )

    def price(counts):
        return float(np.abs(np.array(counts) - want) @ weight)

    def keeps(counts):
        return counts[0] == counts[1] + counts[2] and (counts[1] + counts[3]) % 2 == 0 and counts[3] >= 2

    found = programme.solve()
    near = [[count for count in range(1, 10) if abs(count - w) <= 2.0] for w in want]
    assert keeps(found)
    assert all(price(found) <= 1.02 * price(counts) + 1e-6 for counts in product(*near) if keeps(counts))
