"""Parts with caps at many levels: every mesh is valid, and is the part to the digit where the part has flat faces."""

from pathlib import Path

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad
from cadsweep.pipeline import routes
from cadsweep.quality.metrics import quad_areas
from cadsweep.sweep import Sweep


def block(x: float = 10.0, y: float = 8.0, z: float = 4.0) -> cq.Workplane:
    return cq.Workplane().box(x, y, z, centered=(True, True, False))


def pocketed() -> cq.Workplane:
    """Pockets from above and from below that overlap in plan, and a post in one of them."""
    part = block().faces(">Z").workplane().center(-1, 0).rect(6, 5).cutBlind(-1.5)
    part = part.faces("<Z").workplane(invert=True).center(2.5, 0).rect(4, 4).cutBlind(1)
    return part.union(cq.Workplane().box(2, 2, 3.5, centered=(True, True, False)).translate((-2.5, 0, 0)))


def stairs_with_holes() -> cq.Workplane:
    part = block(9, 6, 1).union(cq.Workplane().box(3, 6, 3, centered=(True, True, False)).translate((3, 0, 0)))
    return part.cut(cq.Workplane().circle(0.8).extrude(0.6).translate((3, 1, 2.4)))


def passage() -> cq.Workplane:
    """A triangular passage across a block with a pocket: its floor and roof meet at its edges."""
    bar = cq.Workplane("XZ").polyline([(-2, 1), (2, 1), (0, 2.4)]).close().extrude(20, both=True)
    return block(10, 8, 5).cut(bar).faces(">Z").workplane().center(3, 2).rect(2, 2).cutBlind(-1)


def stepped() -> cq.Workplane:
    """A boss whose corner stands on another one, a thousandth above it: that edge is no sliver."""
    tall = block(3, 3, 5.501).translate((1, 1, 0))
    return block().union(block(3, 3, 5.5).translate((-0.5, -0.5, 0))).union(tall)


@pytest.mark.parametrize("make", [pocketed, stairs_with_holes, passage, stepped])
def test_volume_and_every_flat_area_are_the_parts(make):
    part = make()
    mesh = cs.sweep_mesh(part, size=0.8)
    report = mesh.quality()
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > 0.25
    flat = make is not stairs_with_holes
    assert report.volume == pytest.approx(part.val().Volume(), rel=1e-9 if flat else 5e-3)
    assert sum(report.areas.values()) == pytest.approx(part.val().Area(), rel=1e-9 if flat else 5e-3)


def test_a_boss_flush_with_the_end_of_a_lever_is_a_stack_and_its_tips_are_no_reason_for_cuts(monkeypatch):
    """The arm's upper face runs out where the boss goes on, at a smooth edge that is as high as it."""
    monkeypatch.setitem(
        routes.WAYS, routes.CELLS, lambda *_: pytest.fail("a search for cells that have those tips, too")
    )
    arm = cq.Workplane().slot2D(60, 16).extrude(6)
    lever = arm.union(cq.Workplane().center(22, 0).circle(8).extrude(14)).cut(
        cq.Workplane().center(22, 0).circle(4).extrude(14)
    )
    mesh = cs.sweep_mesh(lever)
    assert mesh.record.way == "columns"
    assert mesh.record.sweeps[0]["columns"] == 2
    assert mesh.quality().volume == pytest.approx(lever.val().Volume(), rel=5e-3)


def test_every_pocket_floor_and_every_wall_keeps_its_name():
    part = pocketed()
    part.faces(cq.selectors.BoxSelector((-5, -4, 2.4), (5, 4, 2.6))).tag("floor")
    mesh = cs.sweep_mesh(part, size=1.0)
    floor = mesh.points[mesh.boundaries["floor"]]
    assert np.ptp(floor[:, :, 2]) == 0.0
    assert floor[0, 0, 2] == 2.5
    assert len(mesh.boundaries) == part.faces().size()


def test_a_stack_is_listed_and_a_plain_sweep_is_preferred():
    stack, *others = cs.find_sweeps(pocketed())  # all its faces are across or along x, y and z
    assert abs(stack.direction[2]) == pytest.approx(1.0)
    assert stack.n_columns <= min(other.n_columns for other in others)
    assert set(stack.source) | set(stack.target) | set(stack.walls) == set(range(len(stack.solid.faces)))
    assert cs.sweep_mesh(block()).structure is not None


def test_a_column_that_runs_out_is_refused_at_its_edge():
    wedge = cq.Workplane("XZ").polyline([(0, 0), (9, 0), (0, 2)]).close().extrude(5)
    part = wedge.union(cq.Workplane().box(2, 2, 6).translate((1.5, -2.5, 0)))
    part = part.cut(cq.Workplane("YZ").circle(0.4).extrude(1).translate((0, -2.5, 0.8)))
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.find_sweeps(part)
    assert any("run out on each other at edge" in reason for reason in refused.value.reasons)


def test_layers_demanded_are_those_of_the_whole_height():
    mesh = cs.sweep_mesh(pocketed(), size=1.0, layers=9)
    assert mesh.info["sweeps"][0]["layers"] == 9
    with pytest.raises(cs.InputError, match="layers"):
        cs.sweep_mesh(pocketed(), size=1.0, layers=1)


def test_counts_and_layers_of_single_edges_are_as_asked():
    part = cs.load(pocketed())
    middles = np.array([edge.midpoint for edge in part.solids[0].edges])
    top, post = (int(np.argmin(np.linalg.norm(middles - at, axis=1))) for at in ((-2.5, 1, 3.5), (-3.5, 1, 3)))
    mesh = cs.sweep_mesh(part, size=1.0, counts={f"edge {top}": 5}, rail_layers={f"edge {post}": 3})
    x, y, z = mesh.points.T
    on_top = np.isclose(z, 3.5) & np.isclose(y, 1.0) & (np.abs(x + 2.5) < 1.0 + 1e-9)
    on_post = np.isclose(x, -3.5) & np.isclose(y, 1.0) & (z > 2.5 - 1e-9) & (z < 3.5 + 1e-9)
    assert (on_top.sum(), on_post.sum()) == (5 + 1, 3 + 1)
    with pytest.raises(cs.InputError, match="does not run along"):
        cs.sweep_mesh(part, size=1.0, rail_layers={f"edge {top}": 3})


@pytest.mark.parametrize("nodes", [20, 27])
def test_order_2_follows_bores_and_cones(nodes):
    part = block(12, 12, 4).faces(">Z").workplane().cskHole(3, 6, 90).faces("<Z").workplane().rect(9, 2).cutBlind(-0.5)
    mesh = cs.sweep_mesh(part, size=1.5, order=2, nodes=nodes)
    report = mesh.quality()
    assert report.valid, report.problems
    assert mesh.info["cad_volume"] == pytest.approx(part.val().Volume(), rel=1e-6)
    straight = cs.sweep_mesh(part, size=1.5).quality()
    assert abs(report.volume - part.val().Volume()) < 0.05 * abs(straight.volume - part.val().Volume())


def test_info_tells_levels_and_columns(tmp_path):
    from cadsweep.cli.show import print_info
    from cadsweep.cli.work import describe_part

    path = tmp_path / "pocketed.step"
    cq.exporters.export(pocketed(), str(path))
    data = describe_part(str(path), params=None, on_progress=lambda stage, share: None)
    best = data["stacks"][0]
    assert np.abs(best["direction"]) == pytest.approx([0, 0, 1])
    # Ground, the pocket from below, the one from above, the post, the top.
    assert np.abs(best["levels"]) == pytest.approx([0, 1, 2.5, 3.5, 4])
    assert best["n_columns"] >= best["n_cells"] > 4
    print_info(data)


def test_lines_that_bound_no_material_do_not_end_the_search():
    # An imprint on a side leaves outlines that fall outside of every cell of the arrangement.
    path = Path(__file__).parents[1] / "parts" / "sweepable" / "imprint_across_seam.py"
    found = cs.find_sweeps(cs.load(path))
    assert any(isinstance(one, Sweep) for one in found)


def test_pockets_that_share_a_sliver_in_plan_are_meshed_however_coarsely():
    """The lens between the two circles has two edges, shorter than the size: four nodes, no fewer, bound a quad."""
    part = cq.Workplane().box(40, 24, 10)
    part = part.cut(cq.Workplane("XY", (-7.5, 0, 1)).circle(8).extrude(9))
    part = part.cut(cq.Workplane("XY", (7.5, 0, -9)).circle(8).extrude(6))
    mesh = cs.sweep_mesh(part, size=6.0, decompose=False)
    assert mesh.quality().valid
    assert mesh.quality().volume == pytest.approx(part.val().Volume(), rel=0.05)


@pytest.mark.parametrize("size", [3.0, 0.8])
def test_a_rounding_between_floor_and_wall_is_no_steeper_in_a_fine_mesh(size):
    pocket = cq.Workplane("XY", (0, 0, 2)).rect(16, 12).extrude(9).edges("|Z").fillet(4).faces("<Z").edges().fillet(3)
    part = cq.Workplane().box(24, 20, 10).cut(pocket)
    report = cs.sweep_mesh(part, size=size, decompose=False).quality()
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > 0.3
    # Two chords of a quarter of a circle at equal steps add 0.1 r**2 to the section, here along some 37 of rounding.
    assert part.val().Volume() < report.volume < part.val().Volume() + 1.5 * 0.1 * 3.0**2 * 37


def test_a_face_that_is_neither_wall_nor_cap_is_named_with_its_lean():
    part = cq.Workplane().box(10, 10, 4).faces(">Z").workplane().hole(3, 2).rotate((0, 0, 0), (1, 1, 0), 0)
    part = part.cut(cq.Workplane("XZ").circle(1.0).extrude(20).translate((3.5, 0, 0)))
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.sweep_mesh(part, decompose=False)
    assert any("turns from facing along it to facing against it" in reason for reason in refused.value.reasons)
    assert not any(
        "e-" in reason.split("leans", maxsplit=1)[-1] for reason in refused.value.reasons if "leans" in reason
    )


def test_the_refusal_of_the_direction_that_most_faces_fit_comes_first():
    part = cq.Workplane().box(20, 12, 6).faces(">Z").workplane().rect(8, 6).cutBlind(-2)
    part = (
        part.faces(">Z")
        .workplane(origin=(7, 0, 0))
        .pushPoints([(0, 3), (0, -3)])
        .hole(2, 3)
        .faces(">X")
        .workplane(origin=(0, 0, -1.5))
        .hole(1.5, 4)
    )
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.sweep_mesh(part, decompose=False)
    stacked = [reason for reason in refused.value.reasons if reason.startswith("no stack of columns along (")]
    assert stacked[0].startswith("no stack of columns along (0, 0, 1), face")  # the bore is all that is wrong with it
    assert "cylinder" in stacked[0]


def test_hexahedra_between_slanted_caps_come_column_by_column_layer_on_layer():
    plate = cq.Workplane().box(40, 40, 10).faces(">Z").workplane().circle(8).extrude(6)
    mesh = cs.sweep_mesh(plate.faces(">Z").edges().chamfer(2))
    sizes = mesh.info["blocks"]
    assert len(sizes) == mesh.info["sweeps"][0]["columns"] > 1
    assert sum(sizes) == mesh.n_hexes
    for own in np.split(mesh.hexes, np.cumsum(sizes)[:-1]):
        floors, roofs = ({tuple(sorted(quad)) for quad in own[:, side]} for side in (slice(4), slice(4, 8)))
        layer = len(floors - roofs)
        assert len(own) % layer == 0
        np.testing.assert_array_equal(own[layer:, :4], own[:-layer, 4:])


def test_an_outline_within_a_wall_that_no_layers_follow_is_given_up_and_keeps_its_name():
    """A round patch on a wall rises and falls over one line of the plane; its arcs begin and end upright."""
    step = cq.Workplane().box(30, 30, 20).cut(cq.Workplane().box(10, 30, 8).translate((10, 0, 6)))
    step = step.cut(cq.Workplane().box(12, 8, 8).translate((-9, 11, 6)))
    plug = cq.Workplane("YZ", origin=(-15, 0, 0)).circle(4).extrude(6)
    part = cq.Workplane(step.cut(plug).val().fuse(plug.val()))  # not cleaned: the plug's end stays a face
    part.faces(cq.selectors.NearestToPointSelector((-15, 0, 0))).tag("patch")
    mesh = cs.sweep_mesh(part, size=2.0)
    assert mesh.record.way == "columns"
    area = quad_areas(mesh.points, mesh.boundaries["patch"]).sum()
    assert area == pytest.approx(np.pi * 4**2, rel=0.15)  # the quads whose middles lie in it


@pytest.mark.parametrize("options", [{}, {"order": 2}, {"refine": 1}])
def test_an_edge_along_the_columns_may_be_divided_where_nothing_else_ends(options):
    part = cs.load(block().faces(">Z").workplane().rect(6, 4).extrude(3))
    (solid,) = part.solids
    (edge, *_) = [edge.id for edge in solid.edges if edge.length == 3.0]
    divided = cad.divide_edges(part, {0: {edge: [0.3, 0.41]}})
    assert len(divided.solids[0].edges) == len(solid.edges) + 2
    mesh, plain = (cs.sweep_mesh(one, without=["way: sweep"], **options) for one in (divided, part))
    assert mesh.info["way"] == "columns"
    np.testing.assert_allclose(mesh.points, plain.points, atol=1e-9)
    again = cs.sweep_mesh(divided, like=cs.sweep_mesh(divided, without=["way: sweep"]), **options)
    assert again.info["quality"].valid
    assert set(again.boundaries) == set(mesh.boundaries)
