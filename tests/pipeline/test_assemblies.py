"""Models of several solids: one conformal mesh, a set a solid, an interface a contact; and cells of one solid."""

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep.errors import CadError, CoarseMeshError, InputError, InvertedHexError, NotSweepableError
from cadsweep.pipeline.complexes import assemblies
from cadsweep.pipeline.complexes.clearance import put_clear
from cadsweep.pipeline.run import Run, silent
from cadsweep.quality import volume_and_area

pytestmark = pytest.mark.cad


def assembly(**solids):
    """A CadQuery assembly of named shapes."""
    whole = cq.Assembly(name="whole")
    for name, shape in solids.items():
        whole.add(shape, name=name)
    return whole


def block(x, y, z, at=(0, 0, 0)):
    """A box from a corner."""
    return cq.Workplane().box(x, y, z, centered=False).translate(at)


def two_plates():
    """A small plate in the middle of a larger one: the contact is inside a cap."""
    return assembly(low=block(12, 12, 2), high=block(4, 4, 3, (4, 4, 2)))


def pin_in_plate():
    """A pin that stands out on both sides of its plate."""
    plate = cq.Workplane().box(12, 12, 3).faces(">Z").workplane().hole(4)
    return assembly(plate=plate, pin=cq.Workplane().circle(2).extrude(9).translate((0, 0, -4.5)))


def sectors():
    """A ring of four sectors, each on top of the one before."""
    one = cq.Workplane("XZ").center(8, 0).rect(2, 3).revolve(90, (-8, 0), (-8, 1))
    return assembly(**{f"sector_{k}": one.rotate((0, 0, 0), (0, 0, 1), 90 * k) for k in range(4)})


def shells():
    """Three shells, each in the next."""
    ring = cq.Workplane
    return assembly(
        fuel=ring().circle(2).extrude(8),
        gap=ring().circle(3).circle(2).extrude(8),
        clad=ring().circle(4).circle(3).extrude(8),
    )


def arm_on_post():
    """An arm that ends on a round post: the contact is inside the post's one side, and only the arm can part it."""
    post = cq.Workplane().circle(5).extrude(20)
    arm = cq.Workplane("YZ").center(0, 10).rect(4, 4).extrude(15).cut(post)
    return assembly(post=post, arm=arm)


def lap_joint():
    """Two lapped plates and a rivet on them: the upper one is imprinted differently from below and from above."""
    rivet = cq.Workplane().circle(2.5).extrude(2).translate((9, 4, 4))
    return assembly(low=block(12, 8, 2), high=block(12, 8, 2, (6, 0, 2)), rivet=rivet)


MODELS = {
    "lap": lap_joint,
    "two plates": two_plates,
    "pin": pin_in_plate,
    "sectors": sectors,
    "shells": shells,
    "arm": arm_on_post,
}


@pytest.mark.parametrize("make", MODELS.values(), ids=MODELS.keys())
def test_touching_solids_share_their_nodes(make):
    part = cs.load(make())
    mesh = cs.sweep_mesh(part, size=1.0)
    assert mesh.info["quality"].valid
    assert list(mesh.parts) == [model.name for model in part.models]
    assert sorted(np.concatenate(list(mesh.parts.values()))) == list(range(mesh.n_hexes))
    nodes = {name: np.unique(mesh.hexes[ids]) for name, ids in mesh.parts.items()}
    for name, quads in mesh.interfaces.items():
        first, second = name.split("__")
        common = np.intersect1d(nodes[first], nodes[second])
        assert np.isin(quads, common).all()
        # Outward from the first: the second's hexahedra lie on the other side.
        normals = np.cross(mesh.points[quads[:, 2]] - mesh.points[quads[:, 0]],
                           mesh.points[quads[:, 3]] - mesh.points[quads[:, 1]])  # fmt: skip
        for quad, normal in zip(quads[:5], normals, strict=False):
            middle = mesh.points[quad].mean(axis=0)
            with_quad = [h for h in mesh.hexes[mesh.parts[second]] if np.isin(quad, h).all()]
            assert len(with_quad) == 1
            assert normal @ (mesh.points[with_quad[0]].mean(axis=0) - middle) > 0


@pytest.mark.parametrize("make", MODELS.values(), ids=MODELS.keys())
def test_every_part_has_its_own_volume_and_every_interface_its_contact(make):
    part = cs.load(make())
    mesh = cs.sweep_mesh(part, size=0.4)
    whole = 0.0
    for model in part.models:
        volume = volume_of(mesh, model.name)
        assert volume == pytest.approx(model.volume * part.scale**3, rel=0.02)
        whole += volume
    assert mesh.info["quality"].volume == pytest.approx(whole, rel=1e-9)


def test_a_contact_in_a_cap_has_the_area_of_the_cad():
    mesh = cs.sweep_mesh(two_plates(), size=1.0)
    assert mesh.info["quality"].areas["low__high"] == pytest.approx(16.0, rel=1e-9)


def test_solids_that_touch_along_an_edge_share_its_nodes_and_no_quad():
    mesh = cs.sweep_mesh(assembly(one=block(2, 2, 2), other=block(2, 2, 2, (2, 2, 0))), size=1.0)
    common = np.intersect1d(*(np.unique(mesh.hexes[ids]) for ids in mesh.parts.values()))
    assert len(common) == 3  # two segments of size 1
    assert not mesh.interfaces


def test_solids_that_touch_nowhere_stand_side_by_side():
    mesh = cs.sweep_mesh(
        assembly(box=block(2, 2, 2), tube=cq.Workplane().circle(3).circle(2).extrude(4).translate((9, 0, 0)))
    )
    assert set(mesh.parts) == {"box", "tube"}
    assert all(name.startswith(("box_", "tube_")) for name in mesh.boundaries)


def test_sizes_are_asked_for_by_solid_and_pass_on_to_the_neighbour():
    coarse = cs.sweep_mesh(two_plates(), size=2.0)
    fine = cs.sweep_mesh(two_plates(), size=2.0, sizes={"high": 0.5})
    assert len(fine.parts["high"]) == 8 * 8 * 6
    assert len(fine.interfaces["low__high"]) == 64 > len(coarse.interfaces["low__high"])


def test_a_word_that_nothing_is_called_by_is_refused_with_the_solids():
    with pytest.raises(InputError, match="low"):
        cs.sweep_mesh(two_plates(), sizes={"lid": 1.0})


def test_an_option_of_one_sweep_is_refused_for_several_solids():
    with pytest.raises(InputError, match="part="):
        cs.sweep_mesh(two_plates(), bias=2.0)


def test_a_solid_of_an_assembly_is_chosen_by_name():
    assert list(cs.sweep_mesh(two_plates(), part="high").parts) == ["high"]


@pytest.mark.parametrize("nodes", [20, 27])
def test_order_2_follows_the_curves_of_all_parts(nodes):
    straight = cs.sweep_mesh(shells(), size=1.0)
    curved = cs.sweep_mesh(shells(), size=1.0, order=2, nodes=nodes)
    exact = np.pi * 16 * 8
    assert abs(curved.info["quality"].volume - exact) < 0.1 * abs(straight.info["quality"].volume - exact)
    assert curved.interfaces["fuel__gap"].shape[1] == (8 if nodes == 20 else 9)


def test_a_bolt_with_a_head_is_cut_into_cells_of_one_part():
    bolt = cq.Workplane().circle(1).extrude(3).faces(">Z").workplane().circle(2).extrude(1)
    plate = block(8, 8, 3, (-4, -4, 0)).faces(">Z").workplane(origin=(0, 0, 0)).hole(2)
    mesh = cs.sweep_mesh(assembly(plate=plate, bolt=bolt), size=0.5)
    assert mesh.info["quality"].valid
    assert set(mesh.parts) == {"plate", "bolt"}
    assert list(mesh.interfaces) == ["plate__bolt"]
    assert any("cut along" in note for note in mesh.info["notes"])


def test_what_cannot_be_swept_is_named_with_what_it_touches():
    ball = cq.Workplane().sphere(1).translate((1, 1, 3))
    with pytest.raises(NotSweepableError, match="'ball'"):
        cs.sweep_mesh(assembly(base=block(2, 2, 2), ball=ball), decompose=False)


def test_a_refusal_says_of_each_cell_in_the_way_why_and_outlines_them_all():
    """Two half balls on a plate: neither sweeps, and both are drawn."""
    half = cq.Workplane().sphere(1).cut(cq.Workplane().box(4, 4, 2).translate((0, 0, -1)))
    balls = {f"ball_{x}": half.translate((x, 2, 2)) for x in (2, 6)}
    with pytest.raises(NotSweepableError) as refused:
        cs.sweep_mesh(assembly(base=block(8, 4, 2), **balls), decompose=False, interfaces="shared")
    error = refused.value
    told = [reason for reason in error.reasons if "has no sweep" in reason]
    assert [reason.split(":")[0] for reason in told] == ["ball_2", "ball_6"]
    drawn = np.concatenate(error.left)
    assert drawn[:, 0].min() < 3
    assert drawn[:, 0].max() > 5


def test_separate_solids_share_no_node_and_name_their_contacts_in_pairs():
    mesh = cs.sweep_mesh(two_plates(), size=1.0, interfaces="separate")
    nodes = [np.unique(mesh.hexes[ids]) for ids in mesh.parts.values()]
    assert not len(np.intersect1d(*nodes))
    assert not mesh.interfaces
    for k, part in enumerate(mesh.parts, start=1):
        quads = mesh.boundaries[f"low__high_{k}"]
        assert np.isin(quads, np.unique(mesh.hexes[mesh.parts[part]])).all()
        assert np.allclose(mesh.points[quads][..., 2], 2.0)


def test_some_solids_alone_are_meshed_by_name():
    whole = assembly(low=block(4, 4, 1), middle=block(4, 4, 1, (0, 0, 1)), high=block(4, 4, 1, (0, 0, 2)))
    assert set(cs.sweep_mesh(whole, size=1.0, only=["low", "middle"]).parts) == {"low", "middle"}
    assert list(cs.sweep_mesh(whole, size=1.0, skip=["middle"]).parts) == ["low", "high"]
    with pytest.raises(InputError, match="middle"):
        cs.sweep_mesh(whole, skip=["centre"])


def test_a_size_that_is_a_slip_is_refused_before_anything_is_made():
    with pytest.raises(InputError, match="more than the 5,000,000"):
        cs.sweep_mesh(two_plates(), size=0.01)
    with pytest.raises(InputError, match="limit of 100 hexes"):
        cs.sweep_mesh(two_plates(), size=0.5, max_hexes=100)


def rod_on_pipe():
    """A rod that stands on the side of a bar: the contact is a saddle inside a closed face."""
    bar = cq.Workplane("YZ").circle(3).extrude(20)
    return assembly(bar=bar, rod=cq.Workplane().circle(1.5).extrude(8).translate((10, 0, 0)).cut(bar))


def test_an_outline_that_leaves_a_separate_solid_a_poor_mesh_is_left_out_of_it():
    """The disc's touches the plate's edges, so that each of its corners runs out to two tips."""
    disc = cq.Workplane().circle(10).extrude(3).translate((0, 0, 1))
    model = cq.Assembly().add(cq.Workplane().box(20, 20, 2), name="plate").add(disc, name="disc")
    mesh = cs.sweep_mesh(model, interfaces="separate")
    assert mesh.record.quality.min_scaled_jacobian > 0.5
    covered = mesh.points[mesh.boundaries["plate__disc_1"]]
    assert (covered[..., 2] == 1.0).all()
    assert any("does not follow the outline of this contact" in note for note in mesh.record.notes)


def test_a_contact_that_no_sweep_can_follow_is_named_and_meshed_without_its_outline_where_solids_are_separate():
    with pytest.raises(NotSweepableError, match=r"(?s)'bar', which touches 'rod' .*interfaces='separate'"):
        cs.sweep_mesh(rod_on_pipe(), decompose=False, interfaces="shared")
    mesh = cs.sweep_mesh(rod_on_pipe(), size=0.8, interfaces="separate")
    assert mesh.info["quality"].valid
    middles = mesh.points[mesh.boundaries["bar__rod_1"]].mean(axis=1)
    # The foot of the rod is all inside them, and they reach out of it by a quad at most.
    away = np.hypot(middles[:, 0] - 10, middles[:, 1])
    assert away.max() < 1.5 + 1.0
    assert (middles[:, 2] > 0).all()
    foot = mesh.points[np.unique(mesh.boundaries["bar__rod_2"])]
    nearest = np.linalg.norm(foot[:, None] - middles[None], axis=2).min(axis=1)
    assert nearest.max() < 0.8


def test_separate_solids_may_have_facets_of_their_own_on_a_curved_contact():
    mesh = cs.sweep_mesh(shells(), size=1.0, sizes={"gap": 0.45}, interfaces="separate")
    assert mesh.info["quality"].valid
    assert not mesh.info["quality"].crossings


def test_what_crosses_however_near_the_facets_come_is_refused():
    mesh = cs.sweep_mesh(cq.Workplane().circle(3).extrude(4))
    tried = []

    def put(made):
        error = InvertedHexError("it runs into itself", hexes=[], min_scaled_jacobian=0.7)
        error.crossing = (tuple(mesh.points[mesh.boundaries["side_1"][0, 0]]),)
        raise error

    def make(cells, tolerance):
        tried.append(tolerance)
        return mesh

    with pytest.raises(InvertedHexError, match="runs into itself"):
        put_clear([([0], mesh)], put, make, Run(on_progress=silent))
    assert 0 < tried[-1] < tried[0] < mesh.info["distance"]


def test_a_broken_solid_is_named_and_can_be_left_out_before_it_is_healed():
    crossed = cq.Workplane().polyline([(2, 0), (3, 1), (3, 0), (2, 1)]).close().extrude(1)
    whole = assembly(one=block(1, 1, 1), other=block(1, 1, 1, (1, 0, 0)), bow=crossed)
    with pytest.raises(CadError, match=r"(?s)'bow'.*skip=\['bow'\]"):
        cs.sweep_mesh(whole, size=0.5)
    mesh = cs.sweep_mesh(whole, size=0.5, skip=["bow"])
    assert list(mesh.parts) == ["one", "other"]
    assert list(mesh.interfaces) == ["one__other"]


def test_overlaps_can_be_had_without_one_of_the_two():
    whole = assembly(one=block(2, 2, 2), other=block(2, 2, 2, (1, 0, 0)), third=block(2, 2, 2, (0, 2, 0)))
    with pytest.raises(CadError, match=r"(?s)overlap by a volume of 4 at \(1.5, 1, 1\).*skip=\['other'\]"):
        cs.load(whole)
    assert [model.name for model in cs.load(whole, skip=["other"]).models] == ["one", "third"]


def test_solids_keep_their_numbers_where_others_of_their_name_are_left_out():
    whole = cq.Assembly(name="whole")
    for k in range(3):
        whole.add(cq.Assembly(name=f"row_{k}").add(block(1, 1, 1, (k, 0, 0)), name="bolt"))
    assert [m.name for m in cs.load(whole, skip=["bolt_1"]).models] == ["bolt_2", "bolt_3"]
    assert [m.name for m in cs.load(whole, only=["bolt_2", "bolt_3"]).models] == ["bolt_2", "bolt_3"]
    # One that is left of several is meshed as one of several: its boundaries are called after it.
    assert all(name.startswith("bolt_2_") for name in cs.sweep_mesh(whole, size=0.5, only=["bolt_2"]).boundaries)


def test_a_refusal_says_what_can_be_meshed_without_what_cannot():
    cone = cq.Workplane().add(cq.Solid.makeCone(0.5, 0, 1, pnt=cq.Vector(0.5, 0.5, 1)))
    whole = assembly(low=block(1, 1, 1), other=block(1, 1, 1, (1, 0, 0)), tip=cone)
    with pytest.raises(NotSweepableError, match=r"(?s)'tip'.*skip=\['tip'\] \(--skip tip\) meshes the other 2 solids"):
        cs.sweep_mesh(whole, size=0.5, decompose=False)
    assert set(cs.sweep_mesh(whole, size=0.5, skip=["tip"]).parts) == {"low", "other"}


def test_a_layer_between_two_solids_is_no_gap_between_them():
    whole = assembly(low=block(10, 10, 4), glue=block(10, 10, 0.01, (0, 0, 4)), high=block(10, 10, 4, (0, 0, 4.01)))
    assert not any("apart" in note for note in cs.load(whole).notes)
    assert any("0.01 apart" in note for note in cs.load(whole, skip=["glue"]).notes)


def test_a_gap_as_wide_as_the_solids_are_large_may_be_closed():
    """What the faces moved by explains the volume that the solids have gained."""
    wide = assembly(low=block(100, 50, 10), high=block(100, 50, 10, (0, 0, 10.05)))
    mesh = cs.sweep_mesh(wide, size=10.0, touch=0.06)
    assert mesh.info["quality"].valid
    assert list(mesh.interfaces) == ["low__high"]


def test_a_part_may_be_called_a_shell():
    core = block(2, 2, 2, (1, 1, 0))
    whole = assembly(core=core, shell=block(4, 4, 2).cut(core))
    assert [model.name for model in cs.load(whole).models] == ["core", "shell"]


def volume_of(mesh, name):
    """What the boundaries and interfaces of a solid enclose."""
    quads = [q for face, q in mesh.boundaries.items() if face.startswith(f"{name}_")]
    for contact, q in mesh.interfaces.items():
        first, second = contact.split("__")
        quads += [q] if first == name else [q[:, ::-1]] if second == name else []
    return volume_and_area(mesh.points, np.concatenate(quads))[0]


def test_a_size_wider_than_a_pin_leaves_it_round():
    """A square in a circle has 2 / pi of its area; a size is an upper bound, and the mesh says where it is finer."""
    mesh = cs.sweep_mesh(pin_in_plate(), size=4.0)
    assert volume_of(mesh, "pin") == pytest.approx(np.pi * 4.0 * 9.0, rel=0.05)
    assert any("finer than the size asked for" in note for note in mesh.info["notes"])


def test_solids_that_counts_make_too_coarse_are_refused_by_name():
    """Four segments of the user's own around a pin: its mesh would have 2 / pi of its volume."""
    with pytest.raises(CoarseMeshError, match=r"(?s)'pin'.*allow_coarse"):
        cs.sweep_mesh(pin_in_plate(), size=4.0, counts={"edges:%CIRCLE": 4})
    coarse = cs.sweep_mesh(pin_in_plate(), size=4.0, counts={"edges:%CIRCLE": 4}, allow_coarse=True)
    assert coarse.info["quality"].valid


@pytest.mark.parametrize("tolerance", [0.05, 0.005])
def test_several_cells_come_as_near_to_the_cad_as_is_asked_for(tolerance):
    """A chord of length h on a circle of radius r is h^2 / 8 r off it: no longer than sqrt(8 r tolerance)."""
    mesh = cs.sweep_mesh(shells(), size=3.0, tolerance=tolerance)
    for radius, name in ((2, "fuel__gap"), (3, "gap__clad")):
        corners = mesh.points[mesh.interfaces[name]]
        middles = (corners + np.roll(corners, 1, axis=1)) / 2
        assert radius - np.hypot(middles[..., 0], middles[..., 1]).min() <= tolerance
    finer = cs.sweep_mesh(shells(), size=3.0, tolerance=tolerance / 4)
    assert finer.n_hexes > mesh.n_hexes


def test_with_nothing_asked_for_no_solid_loses_much():
    whole = assembly(block=block(40, 40, 10), pin=cq.Workplane().circle(1).extrude(5).translate((20, 20, 10)))
    part = cs.load(whole)
    mesh = cs.sweep_mesh(part)
    pin = mesh.parts["pin"]
    corners = mesh.points[mesh.hexes[pin]]
    assert corners[..., 2].min() == pytest.approx(10)
    quads = [q for name, q in mesh.boundaries.items() if name.startswith("pin_")] + [
        mesh.interfaces["block__pin"][:, ::-1]
    ]
    assert volume_and_area(mesh.points, np.concatenate(quads))[0] == pytest.approx(np.pi * 5, rel=0.0051)


def test_slabs_and_factors_are_of_any_solids(tmp_path):
    from cadsweep.pipeline import expand, stream_mesh, write_factors

    assert stream_mesh(two_plates(), tmp_path / "low.vtkhdf", size=1.0, only=["low"])["n_hexes"] == 12 * 12 * 2
    mesh = write_factors(two_plates(), tmp_path / "plates.sweep.npz", size=1.0)
    back = expand(tmp_path / "plates.sweep.npz")
    assert np.array_equal(back.points, mesh.points)
    assert np.array_equal(back.hexes, mesh.hexes)
    assert np.array_equal(back.interfaces["low__high"], mesh.interfaces["low__high"])
    assert back.info["quality"].valid


def test_the_record_knows_where_solids_are_in_the_assembly_and_what_they_are_made_of():
    from types import SimpleNamespace

    steel = SimpleNamespace(name="steel")
    low = cq.Assembly(name="frame").add(block(2, 2, 1), name="plate")
    low.children[0].material = steel
    for far in (0, 5):  # touching, and each by itself
        whole = cq.Assembly(name="machine")
        whole.add(low)
        whole.add(block(2, 2, 1, (0, 0, 1 + far)), name="lid")
        mesh = cs.sweep_mesh(whole, size=1.0)
        assert mesh.info["paths"] == {"plate": "machine/frame/plate", "lid": "machine/lid"}
        assert mesh.info["materials"] == {"plate": "steel"}


def test_nodes_of_a_contact_slide_on_its_face_and_along_its_edges_when_smoothing_needs_them():
    from cadsweep.blocks.interface_slides import find_interface_slides
    from cadsweep.pipeline.complexes.checking import fixed_nodes
    from cadsweep.smoothing import Blocks, improve

    mesh = cs.sweep_mesh(shells(), size=1.0, allow_coarse=True)
    part, joined, names = mesh.origin.part, mesh.origin.joined, mesh.origin.names
    slides = find_interface_slides(part, joined, names, outside=False)
    inside = slides.surface >= 0
    along = slides.curve >= 0
    # Two contacts, each a cylinder in two halves: vertices stay, rims and seams slide along themselves.
    radius = np.hypot(*joined.points[:, :2].T)
    assert inside.any()
    assert along.any()
    assert np.abs(radius[slides.mask][:, None] - [2.0, 3.0]).min(axis=1).max() < 1e-9
    points = joined.points.copy()
    moved = np.flatnonzero(inside & (np.abs(radius - 3.0) < 1e-6) & (points[:, 2] < 4.0))[0]
    points[moved, 2] += 2.0  # along the cylinder, past the next node
    fixed = fixed_nodes(joined, names)
    structure = Blocks(joined.hexes, len(points))
    held = improve(points, structure, fixed=fixed)
    free = improve(points, structure, fixed=fixed, slides=slides)
    assert held.after <= 0.0
    assert free.after >= 0.3
    points[free.nodes] = free.positions
    assert np.abs(np.hypot(*points[inside, :2].T)[:, None] - [2.0, 3.0]).min(axis=1).max() < 1e-9


def test_where_a_tolerance_is_to_be_kept_nothing_slides_on_what_is_bent():
    from cadsweep.blocks.interface_slides import find_interface_slides

    origin = cs.sweep_mesh(shells(), size=1.0, allow_coarse=True).origin
    slides = find_interface_slides(origin.part, origin.joined, origin.names, curved=False)
    kinds = [face.kind for solid in origin.part.solids for face in solid.faces]
    assert {"plane", "cylinder"} <= set(kinds)
    assert all(
        np.ptp(origin.joined.points[slides.surface == j], axis=0).min() < 1e-9 for j in range(len(slides.surfaces))
    )
    for j, curve in enumerate(slides.curves):
        on = origin.joined.points[slides.curve == j]
        assert np.linalg.norm(np.cross(on - on[0], curve.evaluate(np.array([1.0])) - on[0])) < 1e-6


def test_matched_faces_and_walls_are_those_of_the_whole_model():
    """A pin in the plate and a box beside it have sides, too, but not the outermost ones."""
    pin = cq.Workplane().circle(4).extrude(12).translate((0, 0, -3))
    whole = assembly(base=cq.Workplane().box(40, 30, 6).cut(pin), pin=pin, apart=block(6, 6, 6, (0, 0, 20)))
    walls = {"<Y": cs.WallLayers(first=0.2, growth=1.3, n=3)}
    mesh = cs.sweep_mesh(whole, size=3.0, periodic={"<Y": ">Y"}, wall_layers=walls)
    assert list(mesh.periodic) == ["base_side_2__base_side_3"]
    apart = mesh.points[mesh.hexes[mesh.parts["apart"]]]
    assert np.diff(np.unique(apart[..., 1].round(6))).min() > 1.0


def test_a_selector_on_solids_that_touch_means_their_outermost_faces():
    """The smaller plate's own faces are no part of what is matched."""
    whole = assembly(low=block(20, 20, 4), top=block(8, 8, 4, (6, 6, 4)))
    mesh = cs.sweep_mesh(whole, size=2.0, periodic={"<Y": ">Y"})
    (pairs,) = mesh.periodic.values()
    assert np.allclose(mesh.points[pairs[:, 1]] - mesh.points[pairs[:, 0]], (0, 20, 0))
    assert mesh.points[pairs, 2].max() <= mesh.points[mesh.hexes[mesh.parts["low"]], 2].max() + 1e-9


def test_the_record_says_of_each_solid_how_it_was_filled():
    block = cq.Workplane().box(40, 30, 20).faces(">Z").workplane().center(-10, 0).hole(8)
    crossed = block.faces(">X").workplane(centerOption="CenterOfMass").hole(6, 12)
    far = cq.Workplane().box(10, 10, 10).translate((100, 0, 0))
    whole = assembly(crossed=crossed, far=far, lid=cq.Workplane().box(40, 30, 5).translate((0, 0, 12.5)))
    assert cs.sweep_mesh(whole, size=4.0).record.way == {"crossed": "cells", "far": "sweep", "lid": "sweep"}
    assert cs.sweep_mesh(far, size=5.0).record.way == "sweep"


def test_of_many_solids_at_fault_a_third_is_taken_out_at_once_those_that_touch_least():
    bar = cq.Workplane().box(120, 20, 8, centered=(False, True, False))
    model = {"bar": bar}
    for j in range(6):
        model[f"block_{j}"] = cq.Workplane().box(10, 10, 10).translate((12 + 20 * j, 0, 13))
    for j in range(4):
        model[f"cap_{j}"] = cq.Workplane().box(10, 10, 4).translate((12 + 20 * j, 0, 20))
    part = cs.load(assembly(**model))
    error = cs.NotSweepableError("none of them sweeps")
    error.solids = tuple(f"block_{j}" for j in range(6))
    out = assemblies._at_fault(part, range(len(part.solids)), error)
    assert {part.models[owner].name for owner in out} == {"block_4", "block_5"}
    error.solids = ("block_0", "block_4")
    assert {part.models[owner].name for owner in assemblies._at_fault(part, range(len(part.solids)), error)} == {
        "block_4"
    }


def test_a_stack_in_contact_is_cut_into_its_columns():
    """A case with a pocket and a blind hole under a lid whose hole is wider: no other cuts are found for both."""
    case = cq.Workplane().box(40, 30, 12).cut(cq.Workplane().box(20, 20, 8).translate((5, 0, 2)))
    case = case.faces(">Z").workplane(origin=(-14, 0, 6)).hole(4, 7)
    lid = cq.Workplane().box(40, 30, 4).translate((0, 0, 8)).faces(">Z").workplane(origin=(-14, 0, 10)).hole(6)
    mesh = cs.sweep_mesh(assembly(case=case, lid=lid), interfaces="shared")
    touching = 40 * 30 - 20 * 20 - np.pi * 3**2
    (quads,) = mesh.interfaces.values()
    a, b, c, d = (mesh.points[quads[:, j]] for j in range(4))
    assert 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1).sum() == pytest.approx(touching, rel=0.01)
    assert "cut: columns" in mesh.record.rows
    assert mesh.quality().min_scaled_jacobian > 0.3


def test_a_frame_of_tubes_is_cut_across_its_contacts():
    """Two square tubes on whose sides two others end: columns along their length would not fit the contact."""

    def tube(length):
        return cq.Workplane("YZ").rect(4, 4).rect(3, 3).extrude(length)

    between = [tube(16).rotate((0, 0, 0), (0, 0, 1), 90).translate((x, 2, 0)) for x in (6, 24)]
    rails = [tube(30), tube(30).translate((0, 20, 0))]
    solids = dict(zip("abcd", [*rails, *between], strict=True))
    mesh = cs.sweep_mesh(assembly(**solids), interfaces="shared")
    assert sorted(mesh.interfaces) == ["a__c", "a__d", "b__c", "b__d"]
    assert mesh.quality().min_scaled_jacobian > 0.5


def shaft_in_a_bore(gap):
    hub = cq.Workplane().box(20, 20, 10).faces(">Z").workplane().hole(10)
    shaft = cq.Workplane().circle(5 - gap).extrude(30, both=True)
    return cq.Assembly().add(hub, name="hub").add(shaft, name="shaft")


@pytest.mark.parametrize("gap", [0.05, 0.01, 0.002])
@pytest.mark.parametrize("options", [{}, {"size": 2.0, "sizes": {"shaft": 1.3}}])
def test_solids_a_small_clearance_apart_keep_apart(gap, options):
    mesh = cs.sweep_mesh(shaft_in_a_bore(gap), **options)
    assert mesh.info["quality"].valid
    assert set(mesh.parts) == {"hub", "shaft"}
    nodes = {name: np.unique(mesh.hexes[cells]) for name, cells in mesh.parts.items()}
    assert not len(np.intersect1d(*nodes.values()))
    radii = {name: np.hypot(*mesh.points[own, :2].T) for name, own in nodes.items()}
    assert radii["shaft"].max() == pytest.approx(5 - gap)
    assert radii["hub"].min() == pytest.approx(5)


def test_only_those_that_would_cross_others_are_meshed_nearer():
    apart = cq.Workplane().circle(5).extrude(10).translate((30, 0, 0))
    wide, narrow = (cs.sweep_mesh(shaft_in_a_bore(gap).add(apart, name="apart")) for gap in (0.05, 0.01))
    n_wide, n_narrow = ({name: len(own) for name, own in mesh.parts.items()} for mesh in (wide, narrow))
    assert n_narrow["apart"] == n_wide["apart"]
    assert n_narrow["hub"] > n_wide["hub"]
    assert sum("keep apart from the solids beside it" in note for note in narrow.info["notes"]) == 2


def test_in_blocks_they_keep_apart_too(tmp_path):
    whole = cs.sweep_mesh(shaft_in_a_bore(0.01))
    streamed = cs.stream_mesh(shaft_in_a_bore(0.01), tmp_path / "shaft.vtkhdf")
    assert streamed["n_hexes"] == whole.n_hexes
