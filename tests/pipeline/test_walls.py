"""Wall layers: the heights that are asked for stand on the mesh, from the source to the target."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.cells import HEX_EDGES, HEX_FACES
from cadsweep.errors import InputError

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

WALL = cs.WallLayers(first=0.05, growth=1.2, n=6)
TOTAL = 0.05 * (1.2**6 - 1) / 0.2


def opposite_nodes(mesh, quads):
    """For boundary quads, their nodes and the nodes of their hexahedra across, in the same order."""
    sides = np.array(HEX_FACES)
    known = {tuple(sorted(quad)): (h, s) for h, hexa in enumerate(mesh.hexes) for s, quad in enumerate(hexa[sides])}
    near, far = [], []
    for quad in quads:
        h, _ = known[tuple(sorted(quad))]
        hexa = mesh.hexes[h].tolist()
        edges = HEX_EDGES.tolist()
        over = {}
        for a, b in edges:
            if (hexa[a] in quad) != (hexa[b] in quad):
                over |= {hexa[a]: hexa[b], hexa[b]: hexa[a]}
        near.append(quad)
        far.append([over[node] for node in quad])
    return np.array(near), np.array(far)


def heights(mesh, name):
    """Heights of the first layer on a boundary, quad by quad: along the quad's normal, at its four nodes."""
    near, far = opposite_nodes(mesh, mesh.boundaries[name])
    corners = mesh.points[near]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.abs(np.einsum("qci,qi->qc", mesh.points[far] - corners, normal)).mean(axis=1)


def walled(work, selector="#Z", name="wall"):
    work.faces(selector).tag(name)
    return work


def straight_ducts():
    angle = cq.Workplane().polyline([(0, 0), (20, 0), (20, 8), (8, 8), (8, 20), (0, 20)]).close()
    ring = cq.Workplane().rect(20, 14).rect(8, 5).extrude(6)
    return {"convex and re-entrant": walled(angle.extrude(6)), "inside and outside": walled(ring)}


@pytest.mark.parametrize(("name", "part"), straight_ducts().items())
def test_the_first_height_is_kept_on_straight_walls(name, part):
    mesh = cs.sweep_mesh(part, size=2, wall_layers={"wall": WALL})
    assert heights(mesh, "wall") == pytest.approx(0.05, rel=0.01)
    assert mesh.info["quality"].min_scaled_jacobian > 0.3


def test_every_layer_grows_by_the_growth():
    mesh = cs.sweep_mesh(walled(cq.Workplane().circle(5).extrude(4), "%CYLINDER"), size=1.5, wall_layers={"wall": WALL})
    radius = np.hypot(*mesh.points[np.abs(mesh.points[:, 2]) < 1e-9][:, :2].T)
    rows = np.unique(radius[radius > 5 - TOTAL - 1e-6].round(6))[::-1]
    assert rows == pytest.approx(5 - 0.05 * np.array([(1.2**k - 1) / 0.2 for k in range(7)]), abs=1e-5)


def test_heights_are_carried_through_a_bend_a_taper_and_a_loft():
    bend = walled(cq.Workplane().rect(8, 5).revolve(90, (-15, 0, 0), (-15, 1, 0)), "(%PLANE and |Y) or %CYLINDER")
    taper = walled(cq.Workplane().rect(20, 12).workplane(offset=30).rect(8, 8).loft(), "not |Z")
    loft = walled(cq.Workplane().circle(6).workplane(offset=20).circle(3).loft(), "not |Z")
    for part, most in ((bend, 0.02), (taper, 0.01), (loft, 0.05)):
        found = heights(cs.sweep_mesh(part, size=1.5, wall_layers={"wall": WALL}, allow_coarse=True), "wall")
        assert found == pytest.approx(0.05, rel=most), part


def test_rows_end_at_the_nodes_of_an_edge_that_is_no_wall():
    box = walled(cq.Workplane().box(30, 10, 6), "<Z")
    mesh = cs.sweep_mesh(box, size=2, source="<X", wall_layers={"wall": WALL})
    assert heights(mesh, "wall") == pytest.approx(0.05, rel=1e-6)
    levels = np.unique((mesh.points[:, 2] + 3).round(9))
    assert levels[:7] == pytest.approx(0.05 * np.array([(1.2**k - 1) / 0.2 for k in range(7)]), abs=1e-8)
    assert (np.diff(levels)[6:] <= 2.0 * 1.2).all()


def test_a_wall_that_is_a_cap_gets_layers_of_the_sweep():
    work = walled(walled(cq.Workplane().circle(5).extrude(20), "<Z", "floor"), "%CYLINDER")
    other = cs.WallLayers(first=0.1, growth=1.5, n=4)
    mesh = cs.sweep_mesh(work, size=1.5, wall_layers={"wall": WALL, "floor": other})
    assert heights(mesh, "floor") == pytest.approx(0.1, rel=0.01)
    assert heights(mesh, "wall") == pytest.approx(0.05, rel=0.02)
    levels = np.unique(mesh.points[:, 2].round(9))
    assert np.diff(levels)[:4] == pytest.approx(0.1 * 1.5 ** np.arange(4), rel=1e-6)


def test_walls_of_solids_that_touch_and_of_cells():
    """A plate around a pin, its walls divided by cuts: walls are sides and caps of cells, with grids and without."""
    pin = cq.Workplane().circle(3).extrude(8)
    plate = cq.Workplane().box(20, 14, 8, centered=(True, True, False)).cut(pin)
    for name, selector in {"left": "<X", "low": "<Y", "floor": "<Z"}.items():
        plate.faces(selector).tag(name)
    assembly = cq.Assembly()
    assembly.add(plate, name="fluid")
    assembly.add(pin, name="pin")
    mesh = cs.sweep_mesh(assembly, size=1.6, wall_layers=dict.fromkeys(("left", "low", "floor"), WALL))
    for name in ("fluid_left", "fluid_low", "fluid_floor"):
        assert heights(mesh, name) == pytest.approx(0.05, rel=0.01)
    walled = plate.faces("%CYLINDER").tag("hole").end()
    cut = cs.sweep_mesh(walled, size=1.6, cuts=["plane x=0"], wall_layers={"hole": WALL, "left": WALL})
    assert len(cut.record.sweeps) == 2
    assert heights(cut, "left") == pytest.approx(0.05, rel=0.01)
    assert heights(cut, "hole") == pytest.approx(0.05, rel=0.05)
    with pytest.raises(InputError, match="no face of any solid is called 'lefft'"):
        cs.sweep_mesh(assembly, wall_layers={"lefft": WALL})


def test_walls_and_caps_of_a_stack():
    work = cq.Workplane().box(40, 30, 8).faces(">Z").workplane().center(3, 2).circle(6).extrude(10)
    for name, selector in {"boss": "%CYLINDER", "left": "<X", "low": "<Y", "floor": "<Z"}.items():
        work.faces(selector).tag(name)
    mesh = cs.sweep_mesh(work, size=3, wall_layers=dict.fromkeys(("boss", "left", "low", "floor"), WALL))
    for name in ("left", "low", "floor"):
        assert heights(mesh, name) == pytest.approx(0.05, rel=0.01)
    assert heights(mesh, "boss") == pytest.approx(0.05, rel=0.05)
    with pytest.raises(InputError, match=r"layers at .* take .* to the next cap"):
        cs.sweep_mesh(work, size=3, wall_layers={"floor": cs.WallLayers(first=1.0, growth=1.2, n=8)})


def test_walls_that_are_near_each_other_get_thinner_layers_and_a_note():
    slot = walled(cq.Workplane().rect(20, 20).rect(18, 18).extrude(2))
    mesh = cs.sweep_mesh(
        slot, size=1, decompose=False, wall_layers={"wall": cs.WallLayers(first=0.05, growth=1.5, n=6)}
    )
    assert any("thinner along 100%" in note for note in mesh.info["notes"])
    assert heights(mesh, "wall") == pytest.approx(0.05, rel=0.01)  # the growth gives way first
    assert mesh.info["quality"].valid


@pytest.mark.parametrize("degrees", [25, 12, 8])
def test_a_sharp_corner_of_a_section_keeps_the_heights_and_the_best_angle_there_is(degrees):
    slope = np.radians(degrees)
    wedge = cq.Workplane().polyline([(0, 0), (30, 0), (30, 30 * np.tan(slope))]).close().extrude(6)
    mesh = cs.sweep_mesh(walled(wedge), size=2, wall_layers={"wall": WALL})
    assert heights(mesh, "wall") == pytest.approx(0.05, rel=0.01)
    # Two hexahedra share the corner, along its bisector.
    assert mesh.info["quality"].min_scaled_jacobian == pytest.approx(np.sin(slope / 2), rel=0.05)


def test_a_corner_of_six_degrees_has_thinner_layers_or_else_is_the_reason_given(monkeypatch):
    wedge = cq.Workplane().polyline([(0, 0), (60, 0), (60, 60 * np.tan(np.radians(6)))]).close().extrude(10)
    walls = {"wall": cs.WallLayers(first=0.1, growth=1.2, n=8)}
    mesh = cs.sweep_mesh(walled(wedge), size=4, layers=2, wall_layers=walls)
    assert mesh.quality().valid
    assert any("wall layers are thinner" in note for note in mesh.info["notes"])
    monkeypatch.setattr("cadsweep.surface.walls._ROUNDS", 5)  # columns that are not shortened enough
    with pytest.raises(cs.CadSweepError, match="the corner of 6 degrees between two walls at 0, 0, 0 leaves no room"):
        cs.sweep_mesh(walled(wedge), size=4, layers=2, wall_layers=walls)


def around_a_blade(degrees):
    """A duct with a rhomb in the flow, whose faces are `blade`."""
    high = 9 * np.tan(np.radians(degrees / 2))
    duct = cq.Workplane().rect(36, 24).extrude(4)
    duct = duct.cut(cq.Workplane().polyline([(-9, 0), (0, -high), (9, 0), (0, high)]).close().extrude(4))
    blade = [face for face in duct.faces("#Z").vals() if abs(face.Center().y) < 5 and abs(face.Center().x) < 10]
    duct.newObject(blade).tag("blade")
    return duct


@pytest.mark.parametrize("degrees", [30, 12])
def test_a_sharp_tip_in_the_flow_keeps_the_heights_with_short_segments_beside_it(degrees):
    mesh = cs.sweep_mesh(around_a_blade(degrees), size=2, wall_layers={"blade": WALL})
    assert heights(mesh, "blade") == pytest.approx(0.05, rel=0.01)
    assert mesh.info["quality"].min_scaled_jacobian == pytest.approx(np.sin(np.radians(degrees / 2)), rel=0.05)


def test_a_tip_of_five_degrees_lowers_the_layers_at_the_tip_alone_and_says_so():
    mesh = cs.sweep_mesh(around_a_blade(5), size=2, wall_layers={"blade": WALL})
    found = heights(mesh, "blade")
    tip = np.abs(mesh.points[mesh.boundaries["blade"]][..., 0]).max(axis=1) > 9 - 1e-6
    assert found[~tip] == pytest.approx(0.05, rel=0.01)
    assert found[tip].min() > 0.5 * 0.05
    assert any("thinner, at the sharp corner at" in note for note in mesh.info["notes"])


def test_what_wall_layers_cannot_do_is_said():
    box = walled(cq.Workplane().box(30, 10, 6), "<Z")
    with pytest.raises(InputError, match="No face matches 'wal'"):
        cs.sweep_mesh(box, wall_layers={"wal": WALL})
    with pytest.raises(InputError, match=r"take 6 of edge .* which is 6 long"):
        cs.sweep_mesh(box, source="<Z", wall_layers={"wall": cs.WallLayers(first=1, growth=1, n=6)})
    with pytest.raises(InputError, match="fractions place the layers"):
        cs.sweep_mesh(box, source="<Z", fractions=[0, 0.2, 1], wall_layers={"wall": WALL})
    both = {"<Z": WALL, "<Y": cs.WallLayers(first=0.1, n=3)}
    with pytest.raises(InputError, match=r"have \d and \d layers"):
        cs.sweep_mesh(box, source="<X", wall_layers=both)
    with pytest.raises(InputError, match="gets 5 segments, and 6 wall layers"):
        cs.sweep_mesh(box, source="<Z", layers=5, wall_layers={"wall": WALL})
    for wrong in ({"first": 0}, {"first": 0.1, "growth": 0.5}, {"first": 0.1, "n": 2.5}, {"frist": 0.1}):
        with pytest.raises(InputError, match="the wall layers of 'wall'"):
            cs.sweep_mesh(box, wall_layers={"wall": wrong})


def test_the_command_line_reads_the_same_table():
    from cadsweep.cli.types import Assignment, Layers

    read = Assignment(Layers()).convert
    assert read("wall=0.05:1.2:8", None, None) == ("wall", {"first": 0.05, "growth": 1.2, "n": 8})


def test_layers_along_a_cap_are_as_high_between_the_rails_of_a_bend():
    """The angle of a height goes with one over the radius: at the mean of two rails' angles it is a tenth too high."""
    section = cq.Workplane().moveTo(-5, 0).lineTo(5, 0).threePointArc((0, 5), (-5, 0)).close()
    part = cs.load(section.revolve(90, (-20, 0, 0), (-20, 1, 0)))
    mesh = cs.sweep_mesh(part, size=2.0, wall_layers={"faces:>Z": cs.WallLayers(first=0.05, growth=1.2, n=6)})
    layers = mesh.points.reshape(mesh.structure.n_layers + 1, -1, 3)
    off = layers[..., 2].max() - layers[..., 2]
    if off[0].max() > off[-1].max():
        off = off[::-1]
    heights = 0.05 * np.cumsum(1.2 ** np.arange(6))
    assert off[0] == pytest.approx(0.0, abs=1e-9)
    for height, layer in zip(heights, off[1:7], strict=True):
        assert layer == pytest.approx(height, rel=0.01 if height < 0.06 else 0.02)


def test_inside_the_layers_of_a_pipe_are_rings_around_a_core():
    mesh = cs.sweep_mesh(walled(cq.Workplane().circle(10).extrude(30), "%CYLINDER"), size=2, wall_layers={"wall": WALL})
    quads = mesh.structure.quads
    sides, uses = np.unique(
        np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)), axis=0, return_counts=True
    )
    valence = np.bincount(sides.ravel())
    inner = np.setdiff1d(sides, sides[uses == 1])
    assert sorted(valence[inner][valence[inner] != 4]) == [3, 3, 3, 3]


def test_rings_that_serve_a_round_target_lie_in_a_rectangle():
    loft = cq.Workplane().rect(30, 20).workplane(offset=40).circle(10).loft(combine=True)
    mesh = cs.sweep_mesh(walled(loft, "not |Z"), size=3, wall_layers={"wall": WALL})
    assert mesh.info["quality"].min_scaled_jacobian > 0.6


def test_between_the_layers_of_a_round_gap_are_rings():
    mesh = cs.sweep_mesh(walled(cq.Workplane().circle(25).circle(12).extrude(30), "%CYLINDER"), size=5,
                         wall_layers={"wall": WALL}, allow_coarse=True)  # fmt: skip
    quads = mesh.structure.quads
    assert set(np.bincount(quads.ravel())[np.unique(quads)]) == {2, 4}, "quads at a node of the rims, and inside"
