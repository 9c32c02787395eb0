"""Models of several solids: one conformal mesh, a set a solid, an interface a contact; and cells of one solid."""

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep.errors import InputError, NotSweepableError
from cadsweep.quality import enclosed_volume

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


MODELS = {"two plates": two_plates, "pin": pin_in_plate, "sectors": sectors, "shells": shells}


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
        quads = [q for name, q in mesh.boundaries.items() if name.startswith(f"{model.name}_")]
        for name, q in mesh.interfaces.items():
            first, second = name.split("__")
            quads += [q] if first == model.name else [q[:, ::-1]] if second == model.name else []
        volume = enclosed_volume(mesh.points, np.concatenate(quads))
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
    mesh = cs.sweep_mesh(assembly(plate=plate, bolt=bolt), size=0.8)
    assert mesh.info["quality"].valid
    assert set(mesh.parts) == {"plate", "bolt"}
    assert list(mesh.interfaces) == ["plate__bolt"]
    assert any("cut along" in note for note in mesh.info["notes"])


def test_what_cannot_be_swept_is_named_with_what_it_touches():
    ball = cq.Workplane().sphere(1).translate((1, 1, 3))
    with pytest.raises(NotSweepableError, match="'ball'"):
        cs.sweep_mesh(assembly(base=block(2, 2, 2), ball=ball))


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
