"""The same mesh on another part: equal arrays, nodes where they belong, refusals that name what has no partner."""

from dataclasses import replace

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import CadError, CadSweepError, InputError
from cadsweep.pipeline import load
from cadsweep.pipeline.attempts import open_and_find
from cadsweep.pipeline.finished.graphs import graph_of
from cadsweep.pipeline.finished.matching import match_graphs
from cadsweep.pipeline.finished.template import make_template

from ..commands import exit_code

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]


def elbow(radius=3.0, angle=90.0):
    return cq.Workplane("XY").circle(1).revolve(angle, (radius, 0, 0), (radius, 1, 0))


def ring(radius=3.0):
    return cq.Workplane("XY").rect(1, 1).revolve(360, (radius, 0, 0), (radius, 1, 0))


def plate(*places, hole=0.4, length=2.0):
    return cq.Workplane().box(length, 1, 0.3).faces(">Z").workplane().pushPoints(places or [(0, 0)]).hole(hole)


def imprinted(cut=0.2):
    """A block whose caps are two faces each, so that edges run inside the caps."""
    left = cq.Workplane().box(1, 1, 0.5).translate((-0.5 + cut, 0, 0))
    right = cq.Workplane().box(1, 1, 0.5).translate((0.5 + cut, 0, 0))
    return left.union(right, clean=False)


def same_arrays(first, second):
    assert np.array_equal(first.hexes, second.hexes)
    assert list(first.boundaries) == list(second.boundaries)
    assert list(first.parts) == list(second.parts) or len(first.parts) == 1
    for name, quads in first.boundaries.items():
        assert np.array_equal(quads, second.boundaries[name])
    assert second.info["quality"].valid


@pytest.mark.parametrize(
    ("base", "options", "variants"),
    [
        (elbow, {"size": 0.5, "layers": 6}, [{"radius": 4.0}, {"angle": 60.0}]),
        (ring, {"size": 0.5, "layers": 12}, [{"radius": 4.0}]),
        (plate, {"size": 0.2, "layers": 2}, [{"hole": 0.5}, {"length": 3.0}]),
        (imprinted, {"size": 0.3}, [{"cut": 0.1}]),
    ],
    ids=["elbow", "ring", "plate", "imprinted"],
)
def test_connectivity_names_and_numbers_are_equal_and_a_part_is_like_itself(base, options, variants):
    mesh = cs.sweep_mesh(base(), allow_coarse=True, **options)
    itself = cs.sweep_mesh(base(), like=mesh)
    same_arrays(mesh, itself)
    assert np.abs(itself.points - mesh.points).max() < 1e-9
    assert itself.info["distance"] == pytest.approx(mesh.info["distance"], abs=1e-9)
    for params in variants:
        variant = cs.sweep_mesh(base(**params), like=mesh)
        same_arrays(mesh, variant)
        assert variant.info["quality"].volume == pytest.approx(variant.info["cad_volume"], rel=0.07)
        # And back again: on edges all is as it was, inside faces the map of a boundary has no exact inverse.
        back = cs.sweep_mesh(base(), like=variant)
        off = np.abs(back.points - mesh.points).max(axis=1)
        on_edges = np.concatenate([nodes for nodes, _ in make_template(mesh, "a test").edges.values()])
        assert off[on_edges % mesh.n_nodes].max() < 1e-6
        assert off.max() < 0.1 * options["size"]


def test_nodes_of_an_elbow_keep_their_places_around_and_along_it():
    mesh = cs.sweep_mesh(elbow(), size=0.5, layers=6, allow_coarse=True)
    wider = cs.sweep_mesh(elbow(radius=5.0), like=mesh)

    def places(points, radius):
        x, y, z = points.T
        return np.stack([np.hypot(x - radius, z) - radius, y, np.arctan2(z, radius - x)], axis=1)

    surface = np.unique(np.concatenate([quads.ravel() for quads in mesh.boundaries.values()]))
    off = places(wider.points[surface], 5.0) - places(mesh.points[surface], 3.0)
    assert np.abs(off).max() < 1e-6


def test_a_scaled_part_has_the_scaled_mesh():
    mesh = cs.sweep_mesh(plate((-0.3, 0.1), (0.5, -0.1)), size=0.25)
    scaled = plate((-0.3, 0.1), (0.5, -0.1)).val().scale(37.0)
    larger = cs.sweep_mesh(cq.Workplane(scaled), like=mesh)
    same_arrays(mesh, larger)
    assert np.abs(larger.points - 37.0 * mesh.points).max() < 37e-8


def test_a_hole_moves_past_another_and_keeps_its_nodes():
    mesh = cs.sweep_mesh(plate((-0.6, 0), (0.1, 0), length=3.0), size=0.25)
    moved = cs.sweep_mesh(plate((-0.6, 0), (0.6, 0), length=3.0), like=mesh)
    same_arrays(mesh, moved)
    on_hole = np.abs(np.hypot(mesh.points[:, 0] - 0.1, mesh.points[:, 1]) - 0.2) < 1e-9
    assert on_hole.sum() > 8
    assert np.allclose(moved.points[on_hole] - mesh.points[on_hole], [0.5, 0, 0], atol=1e-8)


def test_a_hole_that_moves_by_more_than_its_size_is_not_turned_round():
    mesh = cs.sweep_mesh(plate((-0.6, 0), length=3.0), size=0.2)
    moved = cs.sweep_mesh(plate((0.6, 0), length=3.0), like=mesh)
    same_arrays(mesh, moved)
    on_hole = np.abs(np.hypot(mesh.points[:, 0] + 0.6, mesh.points[:, 1]) - 0.2) < 1e-9
    assert on_hole.sum() > 8
    assert np.allclose(moved.points[on_hole] - mesh.points[on_hole], [1.2, 0, 0], atol=1e-8)


def test_holes_keep_their_nodes_where_their_numbers_in_the_input_change():
    """OpenCASCADE numbers the holes anew as soon as one is higher than the other."""
    mesh = cs.sweep_mesh(plate((-0.5, 0), (0.5, 0)), size=0.25)
    moved = cs.sweep_mesh(plate((-0.5, 0.05), (0.5, 0)), like=mesh)
    same_arrays(mesh, moved)
    steps = moved.points - mesh.points
    still, shifted = (np.hypot(mesh.points[:, 0] - x, mesh.points[:, 1]) < 0.2 + 1e-9 for x in (0.5, -0.5))
    assert np.abs(steps[still]).max() < 1e-8
    assert np.allclose(steps[shifted], [0, 0.05, 0], atol=1e-8)


@pytest.mark.parametrize("params", [{"radius": 6.0}, {"angle": 130.0}])
def test_a_bore_is_not_turned_in_its_pipe(params):
    def pipe(radius=3.0, angle=60.0):
        return cq.Workplane("XY").circle(1).circle(0.6).revolve(angle, (radius, 0, 0), (radius, 1, 0))

    first, second = (graph_of(open_and_find(load(part), None, None)[0].solids[0]) for part in (pipe(), pipe(**params)))
    match = match_graphs(first, second)

    def beside(graph, vertex):
        places = np.array(graph.vertices)
        distances = np.linalg.norm(places - places[vertex], axis=1)
        return int(np.argsort(distances)[1])

    for vertex, partner in match.vertices.items():
        assert match.vertices[beside(first, vertex)] == beside(second, partner)


def test_as_many_holes_as_there_are_find_their_places():
    rng = np.random.default_rng(3)
    places = [(x, y) for x in np.linspace(-0.9, 0.9, 7) for y in np.linspace(-0.4, 0.4, 4)]
    first = graph_of(load(plate(*places, hole=0.1)).solids[0])
    moved = [tuple(place) for place in np.array(places) + rng.uniform(-0.05, 0.05, (len(places), 2))]
    second = graph_of(load(plate(*moved, hole=0.1)).solids[0])
    match = match_graphs(first, second)
    assert len(set(match.faces.values())) == len(first.loops) == len(match.faces)
    starts = np.array([[first.vertices[v], second.vertices[w]] for v, w in match.vertices.items()])
    assert np.abs(starts[:, 0] - starts[:, 1]).max() < 0.06  # no hole is nearer to another's place


def test_what_smoothing_moved_goes_along():
    mesh = cs.sweep_mesh(elbow(), size=0.5, layers=4, allow_coarse=True)
    origin, structure = mesh.origin, mesh.structure
    inner = np.setdiff1d(np.arange(structure.n_nodes), np.concatenate(structure.loops))
    points = mesh.points.copy()
    points[2 * structure.n_nodes + inner] += [0.0, 0.01, 0.0]
    moved = origin.joined.moved((points - origin.part.offset) / origin.part.scale)
    base = replace(mesh, points=points, origin=replace(origin, joined=moved))
    itself = cs.sweep_mesh(elbow(), like=base)
    assert np.abs(itself.points - base.points).max() < 1e-9
    assert np.abs(itself.points - mesh.points).max() == pytest.approx(0.01)


def test_a_file_of_factors_is_as_good_as_the_mesh(tmp_path):
    from cadsweep.pipeline import expand, write_factors

    path = tmp_path / "base.sweep.npz"
    mesh = write_factors(imprinted(), path, size=0.3)
    from_file = cs.sweep_mesh(imprinted(0.1), like=path)
    from_mesh = cs.sweep_mesh(imprinted(0.1), like=mesh)
    same_arrays(mesh, from_file)
    assert np.array_equal(from_file.points, from_mesh.points)
    assert np.array_equal(expand(path).points, mesh.points)
    refined = cs.sweep_mesh(imprinted(0.1), like=path, order=2, refine=1)
    assert refined.hexes.shape == (8 * mesh.n_hexes, 20)


def test_parts_that_do_not_correspond_are_refused_with_the_face_that_has_no_partner():
    mesh = cs.sweep_mesh(plate(), size=0.3)
    with pytest.raises(CadError, match=r"(?s)do not correspond:\sface \d+ .* no partner"):
        cs.sweep_mesh(plate((-0.5, 0), (0.5, 0)), like=mesh)
    named = plate()
    named.faces(">Z").tag("lid")
    with pytest.raises(CadError, match="'lid'"):
        cs.sweep_mesh(named, like=mesh)
    with pytest.raises(CadSweepError):
        cs.sweep_mesh(cq.Workplane().sphere(1), like=mesh)


def test_what_the_mesh_brings_along_cannot_be_asked_for(tmp_path):
    mesh = cs.sweep_mesh(plate(), size=0.5, layers=1)
    with pytest.raises(InputError, match="brings its own layers"):
        cs.sweep_mesh(plate(), like=mesh, layers=3)
    with pytest.raises(InputError, match="like must be"):
        cs.sweep_mesh(plate(), like=3)
    mesh.write(tmp_path / "plate.vtu")
    with pytest.raises(InputError, match="needs the CAD model"):
        cs.sweep_mesh(plate(), like=cs.read(tmp_path / "plate.vtu"))


def test_a_variant_that_the_mesh_does_not_fit_is_refused():
    mesh = cs.sweep_mesh(elbow(angle=90.0), size=0.5, layers=2, allow_coarse=True)
    with pytest.raises(CadSweepError):  # two layers around three quarters cut through the middle
        cs.sweep_mesh(elbow(radius=1.05, angle=350.0), like=mesh)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_symmetric_part_is_matched_by_its_faces_numbers_or_by_place(turns):
    """A box fits itself in four ways with its caps kept: numbers decide, and where they say nothing, places."""
    solid = cs.load(cq.Workplane().box(2, 1, 0.5)).solids[0]
    graph = graph_of(solid)
    assert match_graphs(graph, graph).faces == {face: face for face in range(6)}
    order = np.roll(np.arange(6), turns)
    place = {int(old): new for new, old in enumerate(order)}
    shuffled = replace(
        graph,
        **{name: tuple(getattr(graph, name)[old] for old in order) for name in ("loops", "face_names", "face_labels")},
        face_keys=tuple(f"other {i}" for i in range(6)),
    )
    assert match_graphs(graph, shuffled).faces == place


def test_the_command_makes_the_same_mesh(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.py").write_text(
        "import cadquery as cq\nhole = 0.4\n"
        "show_object(cq.Workplane().box(2, 1, 0.3).faces('>Z').workplane().hole(hole))\n"
    )

    def mesh(*args):
        return exit_code(["mesh", "part.py", "--quiet", *args], monkeypatch)

    assert mesh("-o", "base.sweep.npz", "--size", "0.3") == 0
    assert mesh("-o", "other.vtu", "--like", "base.sweep.npz", "--param", "hole=0.5") == 0
    assert capfd.readouterr().err == ""
    from cadsweep.pipeline import expand

    assert np.array_equal(cs.read(tmp_path / "other.vtu").hexes, expand(tmp_path / "base.sweep.npz").hexes)
    assert mesh("-o", "o.vtu", "--like", "base.sweep.npz", "--size", "1") == 1
    assert mesh("-o", "o.sweep.npz", "--like", "base.sweep.npz") == 2


def stepped(height=1.0):
    """Columns of two heights."""
    return cq.Workplane().box(4, 2, 1).faces(">Z").workplane().rect(1.5, 1).extrude(height)


def crossing(width=1.5):
    """Blocks that stick out in three directions: no sweep and no stack, so cells."""
    block = cq.Workplane().box(6, 2, 1.5).union(cq.Workplane().box(width, 2, 2).translate((0, 0, 1.75)))
    return block.union(cq.Workplane().box(width, 3, 1).translate((0, 2.5, 0)))


def stacked(gap=0.5):
    """Two solids that touch, and one that stands apart."""
    model = cq.Assembly(name="pair")
    model.add(cq.Workplane().box(2, 2, 1), name="low")
    model.add(cq.Workplane().box(2, 2, gap), name="high", loc=cq.Location((0, 0, 0.5 + gap / 2)))
    model.add(cq.Workplane().box(1, 1, 1), name="beside", loc=cq.Location((5, 0, 0)))
    return model


@pytest.mark.parametrize(
    ("base", "params"), [(stepped, {"height": 1.5}), (crossing, {"width": 1.7}), (stacked, {"gap": 0.7})]
)
def test_columns_cells_and_assemblies_have_one_mesh_from_memory_and_from_a_file(base, params, tmp_path):
    from cadsweep.pipeline import expand, write_factors

    path = tmp_path / "base.sweep.npz"
    mesh = write_factors(base(), path, size=0.5)
    assert mesh.structure is None
    itself = cs.sweep_mesh(base(), like=mesh)
    same_arrays(mesh, itself)
    assert np.abs(itself.points - mesh.points).max() < 1e-9
    variant = cs.sweep_mesh(base(**params), like=mesh)
    same_arrays(mesh, variant)
    assert {name: len(quads) for name, quads in variant.interfaces.items()} == {
        name: len(quads) for name, quads in mesh.interfaces.items()
    }
    assert variant.info["quality"].volume == pytest.approx(variant.info["cad_volume"], rel=1e-9)
    assert np.array_equal(expand(path).points, mesh.points)
    assert np.array_equal(cs.sweep_mesh(base(**params), like=path).points, variant.points)
    twice = cs.sweep_mesh(base(**params), like=path, order=2)
    assert twice.hexes.shape == (mesh.n_hexes, 20)


def test_solids_without_partners_are_named():
    mesh = cs.sweep_mesh(stacked(), size=0.5)
    other = cq.Assembly(name="pair")
    other.add(cq.Workplane().box(2, 2, 1), name="low")
    other.add(cq.Workplane().box(1, 1, 1), name="beside", loc=cq.Location((5, 0, 0)))
    with pytest.raises(CadError, match="no solid 'high' in this part"):
        cs.sweep_mesh(other, like=mesh)
    apart = cq.Assembly(name="pair")
    apart.add(cq.Workplane().box(2, 2, 1), name="low")
    apart.add(cq.Workplane().box(2, 2, 0.5), name="high", loc=cq.Location((0, 0, 3)))
    apart.add(cq.Workplane().box(1, 1, 1), name="beside", loc=cq.Location((5, 0, 0)))
    with pytest.raises(CadError, match="touches other solids"):
        cs.sweep_mesh(apart, like=mesh)
    with pytest.raises(CadError, match="has 3"):
        cs.sweep_mesh(stacked(), like=cs.sweep_mesh(plate(), size=0.5))


def test_caps_that_have_to_be_relaxed_still_answer_each_other():
    """The hole moves so far that carried caps are folded; relaxed apart they would twist the prisms between them."""
    mesh = cs.sweep_mesh(plate((-0.6, 0), length=3.0), size=0.2, layers=2)
    moved = cs.sweep_mesh(plate((0.6, 0.1), length=3.0), like=mesh)
    same_arrays(mesh, moved)
    n = mesh.structure.n_nodes
    first, last = moved.points[:n, :2], moved.points[-n:, :2]
    assert np.abs(first - last).max() < 1e-7
