"""What ``sweep_mesh`` promises: a checked mesh, the options it was asked for, or a named error."""

from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def test_mesh_passes_every_check_and_has_the_volume_of_the_cad(plate):
    mesh = cs.sweep_mesh(plate, size=1.5, layers=3)
    report = mesh.info["quality"]
    assert report.valid
    assert report.n_inverted == 0
    assert report.volume == pytest.approx(mesh.info["cad_volume"], rel=0.01)
    assert mesh.n_hexes == 3 * len(mesh.structure.quads)


def test_every_boundary_quad_has_one_name(plate):
    mesh = cs.sweep_mesh(plate, size=2.0, layers=2)
    quads = np.concatenate(list(mesh.boundaries.values()))
    keys = np.sort(quads, axis=1)
    assert len(np.unique(keys, axis=0)) == len(keys)
    n_quads = len(mesh.structure.quads)
    assert len(mesh.boundaries["source"]) == len(mesh.boundaries["target"]) == n_quads


def test_overlapping_names_are_all_boundaries(tmp_path):
    work = cq.Workplane().box(4, 4, 2)
    work.faces("|Z").tag("caps")
    work.faces(">Z").tag("top")
    work.faces(">Z or >X").tag("corner")
    mesh = cs.sweep_mesh(work, size=1.0, layers=2, order=2, nodes=27)
    areas = mesh.quality().areas
    assert {name: areas[name] for name in ("caps", "top", "corner")} == pytest.approx(
        {"caps": 32, "top": 16, "corner": 24}
    )
    assert set(areas) == {"caps", "top", "corner", "side_1", "side_2", "side_3"}
    assert mesh.info["quality"].valid
    assert any("'top' and 'caps' share 1 face" in note for note in mesh.info["notes"])
    cs.pipeline.write_factors(work, tmp_path / "block.sweep.npz", size=1.0, layers=2)
    factored = cs.pipeline.expand(tmp_path / "block.sweep.npz")
    cs.stream_mesh(work, tmp_path / "block.vtkhdf", size=1.0, layers=2)
    for other in (factored, cs.read(tmp_path / "block.vtkhdf")):
        assert other.quality().valid
        assert {name: len(quads) for name, quads in other.boundaries.items()} == {
            name: len(quads) for name, quads in mesh.boundaries.items()
        }


def test_colours_of_the_cad_reach_the_mesh_and_its_files(tmp_path):
    work = cq.Workplane().box(4, 4, 2)
    part = cq.Assembly(work, name="block", color=cq.Color(0, 0, 1), material=cq.Material("steel 37"))
    part.addSubshape(work.faces(">Z").val(), name="~hot", color=cq.Color(1, 0, 0))
    part.addSubshape(work.faces(">X").val(), name="~walls", color=cq.Color(0, 1, 0))
    part.addSubshape(work.faces("<X").val(), name="~walls")
    expected = {"boundaries": {"hot": "#ff0000"}, "parts": {"block": "#0000ff"}}  # the walls are of two colours
    mesh = cs.sweep_mesh(part, size=1.0, layers=2)
    assert mesh.info["colors"] == expected
    assert mesh.info["material"] == "steel_37"
    assert cs.sweep_mesh(part, size=1.0, layers=2, isolated=True).info["colors"] == expected
    mesh.write(tmp_path / "block.vtu")
    cs.stream_mesh(part, tmp_path / "block.vtkhdf", size=1.0, layers=2)
    for suffix in (".vtu", ".vtkhdf"):
        assert cs.read(tmp_path / f"block{suffix}").info["colors"] == expected


def test_size_is_a_length_of_the_model(plate):
    coarse, fine = (cs.sweep_mesh(plate, size=s, layers=1) for s in (3.0, 1.5))
    # Halving the edge length makes four times as many quads; the boundary and the hole blur it.
    assert 2.5 < fine.n_hexes / coarse.n_hexes < 6


def test_refinement_brings_the_volume_to_that_of_the_cad(elbow):
    errors = []
    for size in (2.0, 1.0):
        mesh = cs.sweep_mesh(elbow, size=size)
        errors.append(abs(mesh.info["quality"].volume / mesh.info["cad_volume"] - 1))
    assert errors[1] < 0.4 * errors[0]  # second order, and counts are whole numbers


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_unit_of_length_does_not_matter(scale):
    box = cq.Workplane().box(scale, scale, 2 * scale)
    mesh = cs.sweep_mesh(box, size=scale / 4)
    assert mesh.info["quality"].volume == pytest.approx(2 * scale**3)


def test_source_is_the_face_that_was_named():
    box = cq.Workplane().box(3, 4, 5)
    mesh = cs.sweep_mesh(box, size=1.0, source=">X")
    assert np.allclose(mesh.points[mesh.boundaries["source"]][..., 0], 1.5)


def test_fractions_are_the_places_of_the_layers():
    box = cq.Workplane().box(1, 1, 1, centered=False)
    mesh = cs.sweep_mesh(box, size=0.5, source="<Z", fractions=[0, 0.1, 0.5, 1])
    assert np.unique(mesh.points[:, 2].round(12)).tolist() == [0, 0.1, 0.5, 1]


def test_a_full_ring_closes_on_itself(ring):
    mesh = cs.sweep_mesh(ring, size=1.0)
    assert mesh.structure.periodic
    assert mesh.info["quality"].valid
    assert not {"source", "target"} & set(mesh.boundaries)


def test_half_a_ring_needs_two_layers(ring):
    """One layer over half a turn lies between two places of one plane."""
    with pytest.raises(cs.InputError, match=r"layers=3 is fewer than the 4 .*two where it turns back"):
        cs.sweep_mesh(ring, size=1.0, layers=3)
    assert cs.sweep_mesh(ring, size=1.0, layers=4, allow_coarse=True).info["quality"].valid


def test_a_grooved_ring_is_swept_around_its_axis_and_a_straight_one_along_it():
    """The flanks of the groove lean by 60 degrees from the bore, which shears layers square to the axis to 0.5."""
    section = [(4, 0), (9, 0), (9, 1), (5.536, 3), (9, 5), (9, 6), (4, 6)]
    grooved = cq.Workplane("XZ").polyline(section).close().revolve(360, (0, 0), (0, 1))
    mesh = cs.sweep_mesh(grooved, size=1.0)
    assert "the full ring is cut open" in " ".join(mesh.info["notes"])
    assert mesh.info["quality"].min_scaled_jacobian > 0.5
    along = cs.sweep_mesh(grooved, size=1.0, source=">Z")
    assert len(along.boundaries["source"]) == len(along.boundaries["target"])

    straight = cq.Workplane().circle(9).circle(4).extrude(6)
    assert "source" in cs.sweep_mesh(straight, size=1.0).boundaries


def test_a_ring_whose_last_cell_lies_inside_is_written_and_read(tmp_path):
    """All neighbours of the last cell have lower numbers, so in OpenFOAM's files it owns no face."""
    mesh = cs.sweep_mesh(cq.Workplane(cq.Solid.makeTorus(20, 2.5)), size=1.0, layers=7, allow_coarse=True)
    for name in ("ring.vtu", "polyMesh"):
        mesh.write(tmp_path / name)
        back = cs.read(tmp_path / name)
        assert back.n_hexes == mesh.n_hexes
        assert back.quality().valid


def rounded_tube():
    outer = cq.Workplane().rect(30, 20).extrude(12).edges("|Z").fillet(5)
    return outer.cut(cq.Workplane().rect(26, 16).extrude(12).edges("|Z").fillet(3))


@pytest.mark.parametrize(
    "shape",
    [
        lambda: cq.Workplane().circle(10).circle(8.5).extrude(10),
        lambda: cq.Workplane().circle(10).circle(4.5).extrude(4),
        lambda: cq.Workplane().ellipse(10, 7).ellipse(8, 5).extrude(5),
        rounded_tube,
    ],
)
def test_a_wall_without_corners_is_filled_with_rings_of_quads(shape):
    mesh = cs.sweep_mesh(shape())
    outer, hole = mesh.structure.loops
    assert len(outer) == len(hole)
    assert len(mesh.structure.quads) % len(outer) == 0
    assert mesh.info["quality"].min_scaled_jacobian > 0.9
    assert mesh.info["quality"].volume == pytest.approx(mesh.info["cad_volume"], rel=0.01)


def test_a_frame_keeps_a_square_at_every_corner():
    """Rings of quads would cut its corners in half."""
    mesh = cs.sweep_mesh(cq.Workplane().rect(30, 20).rect(26, 16).extrude(5), size=2.0)
    assert mesh.info["quality"].min_scaled_jacobian > 0.99


@pytest.mark.parametrize("nodes", [20, 27])
@pytest.mark.parametrize("part", ["elbow", "ring"])
def test_order_2_bends_with_the_cad(part, nodes, request):
    shape = request.getfixturevalue(part)
    straight = cs.sweep_mesh(shape, size=2.0)
    curved = cs.sweep_mesh(shape, size=2.0, order=2, nodes=nodes)
    assert curved.hexes.shape[1] == nodes
    volume = curved.info["cad_volume"]
    off = [abs(m.info["quality"].volume - volume) for m in (straight, curved)]
    assert off[1] < 0.01 * off[0]


def test_the_same_part_gives_the_same_bits(plate):
    one, two = (cs.sweep_mesh(plate, size=2.0) for _ in range(2))
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.hexes, two.hexes)


def test_a_mesh_too_coarse_for_its_curves_says_so():
    bar = cq.Workplane().circle(10).extrude(30)
    coarse, fine = cs.sweep_mesh(bar, size=9.0, allow_coarse=True), cs.sweep_mesh(bar, size=1.5)
    lost = 1.0 - coarse.quality().volume / coarse.info["cad_volume"]
    assert lost > 0.02
    assert [note for note in coarse.info["notes"] if f"the volume is -{lost:.1%} off the CAD's" in note]
    assert not [note for note in fine.info["notes"] if "off the CAD's" in note]


def test_what_cannot_be_swept_is_refused_with_reasons():
    with pytest.raises(cs.NotSweepableError) as caught:
        cs.sweep_mesh(cq.Workplane().sphere(5), decompose=False)
    assert caught.value.reasons


@pytest.mark.parametrize(
    "options",
    [
        {"size": 0},
        {"size": float("nan")},
        {"layers": 0},
        {"layers": 1.5},
        {"layers": True},
        {"bias": 0},
        {"functional": "K"},
        {"fractions": [0, 0.5]},
        {"fractions": [0, 0.7, 0.6, 1]},
        {"order": 9},
        {"nodes": 27},
        {"source": ">Z", "target": ">Z"},
        {"colour": "red"},
        {"timeout": 5},
    ],
    ids=str,
)
def test_options_out_of_range_are_refused_by_name(options):
    with pytest.raises(cs.InputError, match=next(iter(options))):
        cs.sweep_mesh(cq.Workplane().box(1, 1, 1), **options)


def test_a_named_imprint_that_no_sweep_follows_keeps_its_boundary(padded):
    mesh = cs.sweep_mesh(padded, size=1.0)
    assert mesh.info["quality"].valid
    middles = mesh.points[mesh.boundaries["pad"]].mean(axis=1)
    assert (np.abs(middles - [0, -10 * np.sqrt(3) / 2, 12]) <= [2, 1e-6, 4]).all()
    # the quads of 1 whose middles lie in 4 x 8 are between 3 x 7 and 5 x 9
    assert 21 <= mesh.info["quality"].areas["pad"] <= 45
    assert any("'pad'" in note and "outline" in note for note in mesh.info["notes"])


@pytest.mark.parametrize("size", [2.2, 3.0, 4.0])
def test_the_rings_of_a_wall_are_divided_alike_inside_and_outside(size):
    # Its bend is quartered at one station and halved at the other.
    part = cs.load(Path(__file__).parent.parent / "parts" / "sweepable" / "pipe_straight_bend.py")
    mesh = cs.sweep_mesh(part, size=size, allow_coarse=True)
    assert mesh.quality().min_scaled_jacobian > 0.5
