"""Sizes, counts and layers on single edges: the count that is asked for is the count on the mesh."""

from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import InputError, SurfaceMeshError
from cadsweep.options import SweepOptions
from cadsweep.pipeline.attempts import find_candidates
from cadsweep.pipeline.run import Run, silent

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

PARTS = Path(__file__).parents[1] / "parts" / "sweepable"


def chosen(part, /, **options):
    """The part and the sweep that a mesh with these options is made of."""
    part, sweeps = find_candidates(part, SweepOptions(**options), Run(on_progress=silent))
    return part, sweeps[0]


def segments(part, solid, mesh, edge):
    """Segments of an edge, counted on the mesh: its nodes on the curve, less one."""
    points = (mesh.points - part.offset) / part.scale
    curve = solid.edges[edge].curve
    away = np.linalg.norm(curve.evaluate(curve.project(points)) - points, axis=1)
    return int((away < 1e-6 * solid.size).sum()) - 1


def counted(part, /, **options):
    """Mesh a part; the sweep, the mesh, and a function that counts the segments of an edge."""
    used, sweep = chosen(part, **options)
    mesh = cs.sweep_mesh(part, allow_coarse=True, **options)
    return sweep, mesh, lambda edge: segments(used, sweep.solid, mesh, edge)


def layers_of_spans(sweep, count, loop=0):
    """Layers of every span of a loop without T-junctions."""
    return [{count(e) for e in span} for span in sweep.spans[loop]]


@pytest.fixture(scope="module")
def pipe():
    """Straight, bend, straight: three spans on the outer loop, and three on the inner one."""
    return cs.load(PARTS / "pipe_straight_bend.py")


@pytest.fixture(scope="module")
def named_plate():
    """A plate with a hole, and names on a rim, a rail and a face."""
    work = cq.Workplane().box(20, 20, 3).faces(">Z").workplane().hole(6)
    part = cq.Assembly(work, name="plate")
    part.addSubshape(work.edges("%CIRCLE and >Z").val(), name="rim")
    part.addSubshape(work.edges("|Z and >X and >Y").val(), name="~corner rail")
    part.addSubshape(work.faces(">X").val(), name="~pull")
    return part


def edges_named(sweep, name):
    return [edge.id for edge in sweep.solid.edges if edge.name == name]


@pytest.mark.parametrize("layers", [None, 40])
def test_layers_of_a_span_are_those_asked_for(pipe, layers):
    sweep, mesh, count = counted(pipe, size=3.0, layers=layers, rail_layers={"span 1": 4, "span 3": 9})
    for loop in (0, 1):
        first, second, third = layers_of_spans(sweep, count, loop)
        assert (first, third) == ({4}, {9})
        if layers is not None:
            assert second == {layers - 4 - 9}
    (said,) = mesh.info["sweeps"]
    assert [{n} for n in said["span_layers"]] == layers_of_spans(sweep, count)
    assert said["layers"] == sum(said["span_layers"])


def test_the_spans_that_are_left_share_by_length(pipe):
    sweep, _, count = counted(pipe, size=3.0, layers=31, rail_layers={"span 1": 4})
    lengths = sweep.span_lengths[0]
    # 27 layers for a bend of 31.4 and a straight of 25: 15.04 and 11.96
    assert 27 * lengths[1] / (lengths[1] + lengths[2]) == pytest.approx(15.04, abs=0.01)
    assert layers_of_spans(sweep, count) == [{4}, {15}, {12}]


def test_edges_of_one_name_that_follow_each_other_get_their_layers_in_all():
    # One side is split: its rails are two edges each, those of the other sides one; "|Z" are all of them.
    part = cs.load(PARTS / "split_side.py")
    sweep, mesh, count = counted(part, source="<Z", size=2.0, rail_layers={"|Z": 9})
    assert mesh.info["sweeps"][0]["layers"] == 9
    assert sorted(sweep.rails) == sorted(edge.id for edge in sweep.solid.edges if abs(edge.tangents[0][2]) > 0.99)
    assert sorted({count(e) for e in sweep.rails if sweep.solid.edges[e].length > 7}) == [9]


def test_an_edge_that_covers_two_others_gets_their_sum():
    # One side is split: its rails are two edges each, those of the other sides one.
    part = cs.load(PARTS / "split_side.py")
    _, sweep = chosen(part, source="<Z")
    short = [e for e in sweep.rails if sweep.solid.edges[e].length < 8]
    whole = [e for e in sweep.rails if e not in short]
    lower = min(short, key=lambda e: sweep.solid.edges[e].midpoint[2])
    upper = max(short, key=lambda e: sweep.solid.edges[e].midpoint[2])
    _, mesh, count = counted(part, source="<Z", size=2.0, rail_layers={f"edge {lower}": 3, f"edge {upper}": 8})
    assert {count(e) for e in whole} == {11}
    _, mesh, count = counted(part, source="<Z", size=2.0, rail_layers={f"edge {whole[0]}": 11, f"edge {lower}": 3})
    assert count(upper) == 8
    assert mesh.info["sweeps"][0]["layers"] == 11
    with pytest.raises(InputError, match=f"(?s)3 on edge {lower} .*11 on edge {whole[0]} |11 on .*3 on"):
        cs.sweep_mesh(part, source="<Z", rail_layers={f"edge {lower}": 3, f"edge {upper}": 9, f"edge {whole[0]}": 11})


def test_layers_that_do_not_add_up_name_edges_and_counts(pipe):
    with pytest.raises(InputError, match=r"(?s)30 layers in all: 5 on edge \d+ .*20 on edge \d+ .*6 on edge \d+\s"):
        cs.sweep_mesh(pipe, layers=30, rail_layers={"span 1": 5, "span 2": 20, "span 3": 6})
    first, second = chosen(pipe)[1].spans[0][0]
    with pytest.raises(InputError, match=r"(?s)5 on edge \d+ .*6 on edge \d+ .*station 1"):
        cs.sweep_mesh(pipe, rail_layers={f"edge {first}": 5, f"edge {second}": 6, "span 3": 7})
    with pytest.raises(InputError, match=r"no span 4.*spans 1 to 3"):
        cs.sweep_mesh(pipe, rail_layers={"span 4": 5})


def test_naming_a_rail_chooses_the_sweep():
    box = cs.load(cq.Workplane().box(3, 4, 5))
    for axis in "XYZ":
        sweep, mesh, count = counted(box, size=1.0, rail_layers={f"|{axis}": 7})
        assert {count(e) for e in sweep.rails} == {7}
        assert mesh.info["sweeps"][0]["layers"] == 7


def test_bias_and_fractions_go_with_layers_of_spans(pipe):
    _, mesh, _ = counted(pipe, source="<Z", size=4.0, bias=4.0, rail_layers={"span 1": 3})
    points = mesh.points.reshape(-1, mesh.structure.n_nodes, 3)
    heights = np.diff(points[:4, mesh.structure.loops[0], 2].mean(axis=1))
    # three layers with a ratio of 4 from first to last: 1, 2, 4
    assert heights / heights[0] == pytest.approx([1, 2, 4], rel=1e-6)
    fractions = [0, 0.1, 0.2, 0.3, 0.6, 1]
    sweep, _, count = counted(pipe, size=4.0, fractions=fractions, rail_layers={"span 1": 3})
    assert layers_of_spans(sweep, count) == [{3}, {1}, {1}]
    with pytest.raises(InputError, match="5 layers in all: 4 on edge"):
        cs.sweep_mesh(pipe, size=4.0, fractions=fractions, rail_layers={"span 1": 4})


def test_a_divided_edge_gets_its_count_in_all(named_plate):
    sweep, mesh, count = counted(named_plate, size=2.0, counts={"rim": 48})
    pieces = edges_named(sweep, "plate_rim")
    assert len(pieces) == 2
    assert sum(count(e) for e in pieces) == 48
    assert mesh.info["quality"].valid


def test_every_edge_of_a_name_gets_the_count(named_plate):
    sweep, _, count = counted(named_plate, size=2.0, counts={"edges:|X": 14, "%CIRCLE": 20, "corner rail": 3})
    solid = sweep.solid
    straight = [e.id for e in solid.edges if e.kind == "line" and abs(e.tangents[0][0]) > 0.99]
    assert [count(e) for e in straight] == [14] * 4
    assert [count(e.id) for e in solid.edges if e.kind == "circle"] == [10] * 4
    assert {count(e) for e in sweep.rails} == {3}


def test_counts_that_cannot_be_met_name_their_edges(named_plate):
    with pytest.raises(SurfaceMeshError, match=r"(?s)49 on edge \d+ 'plate_rim' .*edge \d+ 'plate_rim' .*even"):
        cs.sweep_mesh(named_plate, counts={"rim": 49})
    with pytest.raises(SurfaceMeshError, match=r"(?s)48 on edge \d+ 'plate_rim' .*40 on edge \d+ .*equal counts"):
        cs.sweep_mesh(named_plate, counts={"rim": 48, "edges:%CIRCLE and <Z": 40, "edges:|X": 10})
    with pytest.raises(InputError, match=r"counts of 'rim' asks for 48 .*counts of 'edges:rim' for 50"):
        cs.sweep_mesh(named_plate, counts={"rim": 48, "edges:rim": 50})
    with pytest.raises(InputError, match=r"3 on edge .*4 on edge|4 on edge .*3 on edge"):
        cs.sweep_mesh(named_plate, counts={"corner rail": 3, "|Z and <X and <Y": 4})


def test_a_size_on_an_edge_holds_there(named_plate):
    sweep, mesh, count = counted(named_plate, size=2.0, sizes={"rim": 0.5, "corner rail": 0.25})
    # Half a circle of radius 3 in segments of 0.5 is 18.8 of them; the rails are 3 long.
    assert [count(e) for e in edges_named(sweep, "plate_rim")] == [19, 19]
    assert mesh.info["sweeps"][0]["layers"] == 12
    assert {count(e) for e in edges_named(sweep, "corner_rail")} == {12}


def test_a_size_on_an_edge_goes_before_that_of_its_face(named_plate):
    sweep, _, count = counted(named_plate, size=2.0, sizes={"pull": 0.5, "edges:|Y and >X": 1.0})
    solid = sweep.solid
    ends = [e.id for e in solid.edges if abs(e.midpoint[0]) > 9.9 and e.id not in sweep.rails]
    assert [count(e) for e in ends if solid.edges[e].midpoint[0] > 0] == [20, 20]
    assert {count(e) for e in sweep.rails} == {6}


def test_a_name_of_a_face_and_of_an_edge_must_be_told_apart():
    work = cq.Workplane().box(4, 4, 1)
    part = cq.Assembly(work, name="part")
    part.addSubshape(work.faces(">X").val(), name="~end")
    part.addSubshape(work.edges("|Z and >X and >Y").val(), name="~end")
    with pytest.raises(InputError, match="'faces:end' or 'edges:end'"):
        cs.sweep_mesh(part, sizes={"end": 0.5})
    sweep, _, count = counted(part, size=1.0, source="<Z", sizes={"edges:end": 0.25})
    assert {count(e) for e in sweep.rails} == {4}


def test_a_ring_keeps_its_counts_when_it_is_cut_open():
    section = [(8, 0), (12, 0), (12, 1), (9, 1), (9, 4), (8, 4)]
    ring = cq.Workplane("XZ").polyline(section).close().revolve(360, (0, 0), (0, 1))
    part = cq.Assembly(ring, name="ring")
    part.addSubshape(ring.edges(cq.selectors.RadiusNthSelector(-1)).edges(">Z").val(), name="~rim")
    sweep, mesh, count = counted(part, size=1.0, counts={"rim": 61})
    assert sum(count(e) for e in edges_named(sweep, "rim")) == 61
    assert mesh.info["sweeps"][0]["layers"] == 61


@pytest.mark.parametrize("name", ["bracket_sharp", "gear", "mitre_square", "split_sides_unequal", "imprinted_both"])
def test_counts_hold_on_parts_of_many_kinds(name):
    part = cs.load(PARTS / f"{name}.py")
    sweep, _, count = counted(part)
    rail, around = sweep.rails[0], sweep.source_loops[0][0][0]
    asked = {f"edge {around}": count(around) + 2}
    _, mesh, counts = counted(part, counts=asked, rail_layers={f"edge {rail}": count(rail) + 2})
    assert (counts(rail), counts(around)) == (count(rail) + 2, count(around) + 2)
    assert mesh.info["quality"].valid


def test_edges_grow_back_from_a_size_and_none_is_squeezed_by_a_bore():
    """Corners and the bore of a plate are fine: between them edges grow, and a ring of equal counts is no reason."""
    plate = cq.Workplane().rect(100, 80).extrude(10).edges("|Z").fillet(5)
    plate = plate.faces(">Z").workplane().pushPoints([(20, 10)]).hole(12)
    mesh = cs.sweep_mesh(plate, sizes={"%CYLINDER": 1.0}, size=6)
    source = mesh.points[: mesh.structure.n_nodes]
    rim = source[mesh.structure.loops[0]]
    lengths = np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)
    # A quarter of the corners' circumference is 7.85: eight segments; between the corners nothing beyond the size.
    assert lengths.min() == pytest.approx(2 * 5 * np.sin(np.pi / 32), rel=0.01)
    assert 4 < lengths.max() < 1.25 * 6
    ratios = np.roll(lengths, -1) / lengths
    assert max(ratios.max(), 1 / ratios.min()) < 1.6
    assert mesh.info["quality"].min_scaled_jacobian > 0.5


@pytest.mark.parametrize("wall", ["faces:>Y", "faces:<X"])
def test_round_edges_grow_back_from_a_size_as_straight_ones_do(wall):
    plate = cq.Workplane().rect(60, 40).extrude(8).edges("|Z").fillet(12)
    mesh = cs.sweep_mesh(plate, size=5.0, sizes={wall: 1.0})
    (loop,) = mesh.structure.loops
    source = mesh.points[: mesh.structure.n_nodes]
    lengths = np.linalg.norm(source[loop] - source[np.roll(loop, -1)], axis=1)
    growth = np.maximum(lengths / np.roll(lengths, 1), np.roll(lengths, 1) / lengths)
    assert lengths.min() < 1.05
    assert lengths.max() > 3.0
    assert growth.max() < 1.4
