"""Sizes that change from place to place: fine there, coarse away from it, on edges, sides and inside caps."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import InputError

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


@pytest.fixture(scope="module")
def plate():
    return cq.Workplane().box(60, 40, 10)


def edge_lengths(mesh):
    """Middles and lengths of the hexahedra's edges across the z axis."""
    quads = mesh.boundaries["target"]
    corners = mesh.points[quads]
    ends = np.roll(corners, -1, axis=1)
    return ((corners + ends) / 2).reshape(-1, 3), np.linalg.norm(ends - corners, axis=2).ravel()


def test_quads_are_small_at_a_place_and_as_large_as_asked_away_from_it(plate):
    at = np.array([-10.0, 20.0, 5.0])
    mesh = cs.sweep_mesh(plate, size=5, source="<Z", local_sizes=[{"at": at.tolist(), "radius": 3, "size": 0.8}])
    middles, lengths = edge_lengths(mesh)
    away = np.linalg.norm(middles - at, axis=1)
    assert np.median(lengths[away < 3]) == pytest.approx(0.8, rel=0.3)
    assert np.median(lengths[away > 25]) == pytest.approx(5, rel=0.2)
    wanted = np.minimum(0.8 + 0.3 * np.maximum(away - 3, 0), 5)
    assert np.percentile(lengths / wanted, 95) < 2
    assert (lengths < 3 * wanted).all()
    heights = np.diff(np.unique(mesh.points[:, 2].round(6)))
    assert heights[-3:] == pytest.approx(0.8, rel=0.2)  # at the top, where the place is, though no rail is near
    assert heights[0] > 1.5
    assert len(mesh.hexes) < 5000  # 60 x 40 x 10 at 0.8 would be 46,000


def test_a_function_sets_the_sizes_of_edges_of_sides_too(plate):
    mesh = cs.sweep_mesh(plate, size=5, source="<Z", local_sizes=lambda points: 0.5 + 0.3 * np.abs(points[:, 2] - 5))
    heights = np.diff(np.unique(mesh.points[:, 2].round(6)))
    middles = np.unique(mesh.points[:, 2].round(6))[:-1] + heights / 2
    assert heights == pytest.approx(0.5 + 0.3 * np.abs(middles - 5), rel=0.15)


def test_a_place_in_the_middle_of_the_other_cap_counts(plate):
    mesh = cs.sweep_mesh(plate, source="<Z", size=[4, {"at": (5, 3, 5), "radius": 5, "size": 1.0}])
    middles, lengths = edge_lengths(mesh)
    away = np.linalg.norm(middles - np.array([5, 3, 5]), axis=1)
    assert np.median(lengths[away < 4]) == pytest.approx(1.0, rel=0.3)
    assert np.median(lengths[away > 20]) > 2


def test_a_name_is_a_place():
    work = cq.Workplane().box(60, 40, 10).faces(">Z").workplane().center(15, 5).hole(6)
    mesh = cs.sweep_mesh(work, size=5, source="<Z", local_sizes=[cs.LocalSize(at="edges:%CIRCLE", size=0.6)])
    middles, lengths = edge_lengths(mesh)
    away = np.hypot(middles[:, 0] - 15, middles[:, 1] - 5) - 3
    assert np.median(lengths[away < 0.3]) == pytest.approx(0.6, rel=0.3)
    assert np.median(lengths[away > 25]) > 3


def test_a_size_may_be_places_or_a_function(plate):
    place = {"at": (-10, 20, 5), "radius": 3, "size": 0.8}
    mesh = cs.sweep_mesh(plate, source="<Z", size=[place, 5])
    same = cs.sweep_mesh(plate, source="<Z", size=5, local_sizes=[place])
    assert np.array_equal(mesh.points, same.points)
    # A function goes before the default size where it is larger, too.
    coarse = cs.sweep_mesh(plate, source="<Z", size=lambda points: np.full(len(points), 10.0))
    assert coarse.n_hexes == 6 * 4 * 1
    with pytest.raises(InputError, match="one number beside the places"):
        cs.sweep_mesh(plate, size=[place, 5, 6])
    with pytest.raises(InputError, match="without local_sizes"):
        cs.sweep_mesh(plate, size=[place], local_sizes=[place])


def test_stacks_are_fine_around_a_place(plate):
    """A boss on a plate with a pocket: fine at the rim of the boss' top, where a level and columns go through."""
    work = plate.faces(">Z").workplane().center(10, 5).circle(8).extrude(12)
    work = work.faces("<Z").workplane().center(-20, -5).rect(10, 10).cutBlind(-4)
    plain = cs.sweep_mesh(work, size=5)
    mesh = cs.sweep_mesh(work, size=5, local_sizes=[{"at": (18, 5, 17), "radius": 1, "size": 0.8}])
    heights = np.unique(mesh.points[:, 2].round(6))
    assert np.diff(heights)[-1] == pytest.approx(0.8, rel=0.3)
    assert np.diff(heights).max() > 2
    top = mesh.points[np.abs(mesh.points[:, 2] - 17) < 1e-9]
    distances = np.sort(np.linalg.norm(top - (18, 5, 17), axis=1))
    assert distances[0] == 0 or distances[0] < 0.8
    assert distances[distances > 1e-6][0] < 1.2
    assert plain.n_hexes < mesh.n_hexes < 6 * plain.n_hexes


def test_solids_that_touch_share_what_is_fine():
    assembly = cq.Assembly()
    assembly.add(cq.Workplane().box(20, 20, 10), name="low")
    assembly.add(cq.Workplane().box(20, 20, 10).translate((0, 0, 10)), name="high")
    place = np.array([10, 10, 5])
    mesh = cs.sweep_mesh(assembly, size=[4, {"at": place.tolist(), "radius": 1, "size": 0.5}])
    between = mesh.interfaces["low__high"]
    ends = mesh.points[np.stack([between, np.roll(between, -1, axis=1)], axis=-1)].reshape(-1, 2, 3)
    away = np.linalg.norm(ends.mean(axis=1) - place, axis=1)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert np.median(lengths[away < 1]) == pytest.approx(0.5, rel=0.3)
    assert lengths.max() > 2.5
    # By a name that one of the solids alone has.
    named = cs.sweep_mesh(assembly, size=[4, {"at": "edges:>Z and |X", "size": 1.0}])
    top = named.points[np.abs(named.points[:, 2] - 15) < 1e-9]
    assert np.diff(np.unique(top[np.abs(top[:, 1] - 10) < 1e-9][:, 0])) == pytest.approx(1.0)


def test_what_is_wrong_with_a_place_is_said(plate):
    with pytest.raises(InputError, match="local size 1: there is no 'raduis'"):
        cs.sweep_mesh(plate, local_sizes=[{"at": (0, 0, 0), "raduis": 1, "size": 1}])
    with pytest.raises(InputError, match="No face matches 'rim'"):
        cs.sweep_mesh(plate, local_sizes=[{"at": "rim", "size": 1}])
    with pytest.raises(InputError, match="a positive length for each of"):
        cs.sweep_mesh(plate, local_sizes=lambda points: np.zeros(len(points)))
    with pytest.raises(InputError, match="without layers and fractions"):
        cs.sweep_mesh(plate, layers=3, local_sizes=[{"at": (0, 0, 0), "size": 1}])


def test_the_command_line_reads_the_same_table():
    from cadsweep.cli.types import Place

    assert Place().convert("0.5@10,0,5:3", None, None) == {"at": (10.0, 0.0, 5.0), "radius": 3.0, "size": 0.5}
    assert Place().convert("0.5@vertices:>X:3", None, None)["at"] == "vertices:>X"
