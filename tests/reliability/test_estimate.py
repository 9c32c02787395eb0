"""What a mesh costs is known before it is made, and what is too much is refused with the size that fits."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

import cadsweep
from cadsweep.budget import check_budget, check_refined
from cadsweep.errors import InputError
from cadsweep.estimate import Estimate, estimate, estimate_size
from cadsweep.machine import free_memory


def plate_sweep(width=10.0, height=2.0):
    """A square plate: what the estimate reads of a sweep."""
    edges = [SimpleNamespace(length=width)] * 8 + [SimpleNamespace(length=height)] * 4
    faces = [SimpleNamespace(area=width**2)] + [SimpleNamespace(area=width * height)] * 4
    solid = SimpleNamespace(edges=edges, faces=faces, size=width * 2)
    return SimpleNamespace(
        solid=solid,
        source=(0,),
        linking_sides=[SimpleNamespace(face=i) for i in range(1, 5)],
        source_loops=(tuple((i, True) for i in range(4)),),
        target_loops=(tuple((i, True) for i in range(4, 8)),),
        rails=(8, 9, 10, 11),
    )


def test_counts_of_a_plate_are_those_of_its_grid():
    # 10 x 10 quads of size 1 on the cap, two layers of height 1
    expected = estimate_size(plate_sweep(), size=1.0)
    assert (expected.n_quads, expected.n_layers, expected.n_hexes) == (100, 2, 200)
    counts = SimpleNamespace(counts=np.full(4, 10), n_layers=7, size=1.0)
    assert estimate(plate_sweep(), counts).n_hexes == 700


def test_nothing_is_estimated_where_nothing_is_asked():
    assert estimate_size(plate_sweep()) is None


def test_wishes_for_single_edges_are_counted():
    # A count of 4,000 on one edge of the cap is at least 1,000 quads; the rails have 20 layers of 0.1.
    expected = estimate_size(plate_sweep(), size=1.0, edge_counts={(5,): 4000}, edge_sizes={8: 0.1})
    assert (expected.n_quads, expected.n_layers) == (1000, 20)
    # One small edge size says nothing of the other edges: 10 + 3 x 1 segments beside it are no grid of 10 x 10.
    assert estimate_size(plate_sweep(), size=1.0, edge_sizes={0: 0.5}).n_quads == 100


@pytest.mark.parametrize("size", [1e-9, 1e-200, 5e-324])
def test_any_tiny_size_is_refused_with_figures(size):
    with pytest.raises(InputError, match=r"(?s)hexes.*GB.*try size"):
        check_budget(estimate_size(plate_sweep(), size=size), max_memory=4.0)


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("limits", [{"max_hexes": 50_000}, {"max_memory": 1.0}])
def test_the_size_that_is_named_fits(factor, limits):
    sweep = plate_sweep(10.0 * factor, 2.0 * factor)
    with pytest.raises(InputError) as caught:
        check_budget(estimate_size(sweep, size=0.004 * factor), **limits)
    size = float(re.search(r"try size (\S+)", str(caught.value))[1])
    check_budget(estimate_size(sweep, size=size), **limits)


def test_the_number_of_layers_that_is_named_fits():
    with pytest.raises(InputError, match="layers") as caught:
        check_budget(estimate_size(plate_sweep(), layers=10**8), max_memory=4.0)
    layers = int(re.search(r"try ([\d,]+) layers", str(caught.value))[1].replace(",", ""))
    check_budget(estimate_size(plate_sweep(), layers=layers), max_memory=4.0)
    assert layers > 1000


def test_no_size_beyond_the_part_is_proposed():
    with pytest.raises(InputError) as caught:
        check_budget(estimate_size(plate_sweep(), layers=10**8), max_hexes=10**5)
    assert "size" not in str(caught.value)


def test_a_streamed_mesh_needs_memory_for_its_cap_alone():
    whole = estimate_size(plate_sweep(), size=0.1, layers=10**6)
    streamed = estimate_size(plate_sweep(), size=0.1, layers=10**6, streamed=True)
    assert whole.n_hexes == streamed.n_hexes
    assert streamed.n_bytes < whole.n_bytes / 10


@pytest.mark.parametrize("layers", [None, 2])
def test_beyond_five_million_a_size_for_a_tenth_is_named(layers):
    # A plate of 10 x 10 x 2 at size 0.02 has 250,000 quads and 100 layers; at 0.005 there are 4 million quads.
    expected = estimate_size(plate_sweep(), size=0.02 if layers is None else 0.005, layers=layers)
    with pytest.raises(InputError, match=r"(?s)GB.*5,000,000.*for a tenth.*max_hexes") as caught:
        check_budget(expected, max_memory=math.inf)
    size = float(re.search(r"try size (\S+) for a tenth", str(caught.value))[1])
    smaller = estimate_size(plate_sweep(), size=size, layers=layers)
    assert 0.05 * expected.n_hexes < smaller.n_hexes <= 0.1 * expected.n_hexes
    for limit in (expected.n_hexes, math.inf):
        check_budget(expected, max_hexes=limit, max_memory=math.inf)
    with pytest.raises(InputError, match="beyond the limit"):
        check_budget(expected, max_hexes=expected.n_hexes - 1, max_memory=math.inf)


def test_where_a_tenth_is_too_much_the_size_that_is_made_is_named_too():
    # 25,000,000 quads and 1,000 layers: a tenth is 2.5e9.
    expected = estimate_size(plate_sweep(), size=0.002)
    with pytest.raises(InputError, match="for a tenth of it") as caught:
        check_budget(expected, max_memory=16.0)
    made, tenth = re.search(r"try size (\S+) or more.*try size (\S+) for a tenth", str(caught.value)).groups()
    assert 0.05 * expected.n_hexes < estimate_size(plate_sweep(), size=float(tenth)).n_hexes <= 0.1 * expected.n_hexes
    check_budget(estimate_size(plate_sweep(), size=float(made)), max_memory=16.0)


def test_halving_is_counted_before_it_is_done():
    check_refined(24, 5, max_memory=math.inf)  # 786,432
    with pytest.raises(InputError, match=r"24, .* GB, more than the 5,000,000 .* refine=5 \(786,432 hexes\)"):
        check_refined(24, 7, max_memory=math.inf)
    check_refined(24, 7, max_hexes=math.inf, max_memory=math.inf)
    with pytest.raises(InputError, match="more than 4 GB of memory; try refine="):
        check_refined(24, 8, max_hexes=math.inf, max_memory=4.0)
    pytest.importorskip("gmsh")
    box = pytest.importorskip("cadquery").Workplane().box(4, 3, 2)
    with pytest.raises(InputError, match=r"more than 1,000 hexes; try refine=1 \(192 hexes\)"):
        cadsweep.sweep_mesh(box, size=1.0, layers=2, refine=2, max_hexes=1000)


def test_a_streamed_mesh_has_no_limit_of_its_own():
    check_budget(estimate_size(plate_sweep(), size=0.01, streamed=True), max_memory=math.inf)


def test_modest_meshes_pass():
    check_budget(estimate_size(plate_sweep(), size=0.5))
    assert free_memory() > 0.0


def test_an_estimate_reads_well():
    text = str(Estimate(n_quads=100, n_layers=5, n_hexes=500, n_bytes=10**9, seconds=90.0, size=1.0))
    assert text == "about 500 hexes (100 quads x 5 layers), 1 GB, 90 s"
