"""Every fault is found, by the path that uses the structure and by the one that does not; sound meshes pass both."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from cadsweep.cells import SweptStructure
from cadsweep.mesh import HexMesh
from cadsweep.quality import (
    CadReference,
    boundary_limit,
    check_mesh,
    positive_inside,
    scaled_jacobians,
    structure_problems,
)
from cadsweep.quality.boundary import boundary_blocks

from .quality_meshes import grid_quads, hex_soup, raised, swept_block, swept_mesh, swept_ring, without_structure


def bent(k, xy):
    """Layers of a bend that twists and tapers a little."""
    t = 0.2 * k
    x, y = xy[:, 0] * (1 - 0.03 * k) + 6, xy[:, 1] + 0.1 * k * xy[:, 0]
    return np.c_[x * np.cos(t), y, x * np.sin(t)]


SOUND = {
    "block": swept_block,
    "one layer": lambda: swept_block(layers=1),
    "one hex": lambda: swept_block(1, 1, 1),
    "with a hole": lambda: swept_block(5, 5, 2, hole=(1, 3, 2, 4)),
    "bent": lambda: swept_block(3, 4, 5, place=bent),
    "ring": swept_ring,
}
EULER = {"with a hole": 0, "ring": 0}  # tori; the others are balls, 2


@pytest.mark.parametrize("name", SOUND)
def test_sound_meshes_are_valid_by_both_paths(name):
    mesh = SOUND[name]()
    fast, general = check_mesh(mesh), check_mesh(without_structure(mesh))
    assert fast.problems == general.problems == ()
    assert fast.euler == EULER.get(name, 2)
    one, other = fast.to_dict(), general.to_dict()
    del one["limit"], other["limit"]  # and the limit of poor meshes
    for hexahedron in one["worst"] + other["worst"]:
        del hexahedron["layer"]  # only the structure knows layers
    assert one == other


def test_boundary_quads_may_come_in_any_order_and_begin_at_any_corner():
    mesh = swept_block()
    rng = np.random.default_rng(0)
    shuffled = {
        name: np.stack([np.roll(q, rng.integers(4)) for q in rng.permutation(quads)])
        for name, quads in mesh.boundaries.items()
    }
    for candidate in (mesh, without_structure(mesh)):
        assert check_mesh(replace(candidate, boundaries=shuffled)).valid


def test_hexes_may_come_in_any_order():
    mesh = without_structure(swept_block(place=bent))
    order = np.random.default_rng(0).permutation(mesh.n_hexes)
    assert check_mesh(replace(mesh, hexes=mesh.hexes[order])).valid


def test_volume_and_areas():
    report = check_mesh(swept_block(4, 3, 2))
    assert report.volume == pytest.approx(4 * 3 * 2)
    assert report.areas == pytest.approx({"source": 12, "target": 12, "side": 2 * (4 + 3) * 2})


def moved(mesh, node, to):
    points = mesh.points.copy()
    points[node] = to
    return replace(mesh, points=points)


def change_hexes(mesh, hexes):
    return replace(mesh, hexes=hexes, structure=None)


def fault_nan(mesh):
    return moved(mesh, 7, [0.0, np.nan, 0.0])


def fault_inverted(mesh):
    inner = 1 * mesh.structure.n_nodes + 6  # second layer, second row and column of the 5 x 4 nodes of a layer
    return moved(mesh, inner, mesh.points[inner] + [0, 0, 5])


def fault_collapsed_edge(mesh):
    return moved(mesh, 26, mesh.points[27])


def fault_mirrored(mesh):
    return replace(mesh, points=mesh.points * [1, 1, -1])


def fault_out_of_range(mesh):
    hexes = mesh.hexes.copy()
    hexes[4, 2] = mesh.n_nodes
    return change_hexes(mesh, hexes)


def fault_negative_index(mesh):
    hexes = mesh.hexes.copy()
    hexes[4, 2] = -1
    return change_hexes(mesh, hexes)


def fault_repeated_node(mesh):
    hexes = mesh.hexes.copy()
    hexes[4, 2] = hexes[4, 1]
    return change_hexes(mesh, hexes)


def fault_duplicate_hex(mesh):
    return change_hexes(mesh, np.vstack([mesh.hexes, mesh.hexes[5:6]]))


def fault_turned_duplicate(mesh):
    return change_hexes(mesh, np.vstack([mesh.hexes, mesh.hexes[5:6, [1, 2, 3, 0, 5, 6, 7, 4]]]))


def fault_missing_hex(mesh):
    return change_hexes(mesh, np.delete(mesh.hexes, 3, axis=0))


def fault_orphan(mesh):
    return replace(mesh, points=np.vstack([mesh.points, [[9.0, 9, 9]]]))


def fault_torn(mesh):
    """One hex gets its own copy of an inner node."""
    inner = 1 * mesh.structure.n_nodes + 6
    hexes = mesh.hexes.copy()
    row = np.flatnonzero((hexes == inner).any(axis=1))[0]
    hexes[row][hexes[row] == inner] = mesh.n_nodes
    hexes[row] = np.where(hexes[row] == inner, mesh.n_nodes, hexes[row])
    return replace(change_hexes(mesh, hexes), points=np.vstack([mesh.points, mesh.points[inner]]))


def fault_crowded(mesh):
    """A third hexahedron on a face that has two."""
    extra = np.array([[9.0, 9, 9], [10, 9, 9], [10, 10, 9], [9, 10, 9]])
    below = np.r_[mesh.n_nodes : mesh.n_nodes + 4]
    # A face between the first two layers, met from below by a new hexahedron.
    hexes = np.vstack([mesh.hexes, np.r_[below, mesh.hexes[0, 4:]][None]])
    return replace(change_hexes(mesh, hexes), points=np.vstack([mesh.points, extra]))


def fault_boundary_triangles(mesh):
    return replace(mesh, boundaries=mesh.boundaries | {"side": mesh.boundaries["side"][:, :3]})


def fault_boundary_missing(mesh):
    return replace(mesh, boundaries=mesh.boundaries | {"side": mesh.boundaries["side"][1:]})


def fault_boundary_inward(mesh):
    quads = mesh.boundaries["side"].copy()
    quads[2] = quads[2, ::-1]
    return replace(mesh, boundaries=mesh.boundaries | {"side": quads})


def fault_boundary_twice(mesh):
    side = mesh.boundaries["side"]
    return replace(mesh, boundaries=mesh.boundaries | {"side": np.concatenate([side, np.roll(side[:1], 1, axis=1)])})


def fault_boundary_inside(mesh):
    return replace(mesh, boundaries=mesh.boundaries | {"inside": mesh.hexes[0:1, [4, 5, 6, 7]]})


def fault_boundary_out_of_range(mesh):
    return replace(mesh, boundaries=mesh.boundaries | {"wild": np.array([[0, 1, 2, mesh.n_nodes + 5]])})


FAULTS = {
    fault_nan: "not finite",
    fault_inverted: "inverted",
    fault_collapsed_edge: "inverted",
    fault_mirrored: "inverted",
    fault_out_of_range: "refer to nodes outside",
    fault_negative_index: "refer to nodes outside",
    fault_repeated_node: "use a node twice",
    fault_duplicate_hex: "more than once",
    fault_turned_duplicate: "more than once",
    fault_missing_hex: "have no name",
    fault_orphan: "belong to no hexahedron",
    fault_torn: "coincide",
    fault_crowded: "more than two hexahedra",
    fault_boundary_triangles: "has shape",
    fault_boundary_missing: "have no name",
    fault_boundary_inward: "turn inward",
    fault_boundary_twice: "come twice",
    fault_boundary_inside: "not on the boundary",
    fault_boundary_out_of_range: "outside",
}


def test_boundaries_may_overlap():
    mesh = swept_block(4, 3, 3)
    caps = np.concatenate([mesh.boundaries["source"], mesh.boundaries["target"]])
    half = np.concatenate([mesh.boundaries["target"], mesh.boundaries["side"][::2]])
    grouped = replace(mesh, boundaries=mesh.boundaries | {"caps": caps, "half": half})
    for candidate in (grouped, without_structure(grouped)):
        assert check_mesh(candidate).problems == ()


def test_overlapping_boundaries_fall_into_blocks_in_which_every_quad_comes_once():
    mesh = swept_block(4, 3, 3)
    names = dict(mesh.boundaries)
    assert boundary_blocks(names, mesh.n_nodes) == {(name,): quads for name, quads in names.items()}
    names["caps"] = np.concatenate([names["source"], np.roll(names["target"], 1, axis=1)])
    names["most"] = np.concatenate([names["side"][1:], names["target"]])
    blocks = boundary_blocks(names, mesh.n_nodes)
    assert {key: len(quads) for key, quads in blocks.items()} == {
        ("source", "caps"): len(names["source"]),
        ("target", "caps", "most"): len(names["target"]),
        ("side", "most"): len(names["side"]) - 1,
        ("side",): 1,
    }


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.__name__)
def test_every_fault_is_found_by_both_paths(fault):
    mesh = fault(swept_block(4, 3, 3))
    for candidate in (mesh, without_structure(mesh)):
        report = check_mesh(candidate)
        assert not report.valid
        assert any(FAULTS[fault] in problem for problem in report.problems), report.problems
        json.dumps(report.to_dict(), allow_nan=False)
        assert all(problem in str(report) for problem in report.problems)


def test_a_structure_that_describes_other_hexes_is_a_problem():
    mesh = swept_block()
    hexes = mesh.hexes.copy()
    hexes[[0, 1]] = hexes[[1, 0]]
    assert any("structure" in p for p in check_mesh(replace(mesh, hexes=hexes)).problems)


@pytest.mark.parametrize("turn", ["flipped quad", "missing loop", "duplicate quad"])
def test_unsound_quads_are_found_by_both_paths(turn):
    plane, quads, loops = grid_quads(3, 3)
    if turn == "flipped quad":
        quads = quads.copy()
        quads[4] = quads[4, ::-1]
    elif turn == "missing loop":
        quads = np.delete(quads, 4, axis=0)
    else:
        quads = np.vstack([quads, quads[:1]])
    points = np.concatenate([np.c_[plane, np.full(len(plane), z)] for z in range(3)])
    mesh = swept_mesh(points, quads, loops, 2)
    for candidate in (mesh, without_structure(mesh)):
        assert not check_mesh(candidate).valid


def grid_structure(**changes):
    """Two layers of 3 x 3 quads, with changes."""
    _, quads, loops = grid_quads(3, 3)
    return SweptStructure(**({"quads": quads, "loops": loops, "n_nodes": 16, "n_layers": 2} | changes))


QUADS, LOOPS = grid_quads(3, 3)[1:]


@pytest.mark.parametrize(
    ("structure", "n_nodes", "words"),
    [
        (grid_structure(), 47, "47 nodes, but 3 layers of 16"),
        (grid_structure(n_layers=0), 16, "too few"),
        (grid_structure(n_layers=2, periodic=True), 32, "too few"),
        (grid_structure(quads=QUADS[:0], loops=()), 48, "no quads"),
        (grid_structure(quads=QUADS + 1), 48, "outside 0 .. 15"),
        (grid_structure(quads=QUADS - 1), 48, "outside 0 .. 15"),
        (grid_structure(quads=np.where(QUADS == 5, 6, QUADS)), 48, "use a node twice"),
        (grid_structure(n_nodes=17), 51, "belong to no quad"),
        (grid_structure(quads=np.vstack([QUADS, QUADS[:1, [1, 2, 3, 0]]])), 48, "occur twice"),
        (grid_structure(quads=np.vstack([QUADS[:4], QUADS[4:5, ::-1], QUADS[5:]])), 48, "twice in one direction"),
        (grid_structure(loops=(np.roll(LOOPS[0], 3)[::-1],)), 48, "not the rim"),
        (grid_structure(loops=(LOOPS[0][:-1],)), 48, "not the rim"),
        (grid_structure(loops=(LOOPS[0], LOOPS[0])), 48, "twice in the loops"),
    ],
)
def test_every_fault_of_a_structure_is_named(structure, n_nodes, words):
    assert structure_problems(grid_structure(), 48) == []
    assert any(words in problem for problem in structure_problems(structure, n_nodes))


def test_two_bricks_that_touch_in_one_node_or_edge_are_no_manifold():
    from .quality_meshes import UNIT_CUBE

    for shift, words in (([1.0, 1, 1], "sheets touch"), ([1.0, 1, 0], "closed 2-manifold")):
        points, hexes = hex_soup(np.stack([UNIT_CUBE, UNIT_CUBE + shift]))
        points, inverse = np.unique(points, axis=0, return_inverse=True)
        report = check_mesh(HexMesh(points=points, hexes=inverse.ravel()[hexes], boundaries={}))
        assert any(words in p for p in report.problems), report.problems


def test_neighbours_that_twist_their_shared_face_do_not_conform():
    mesh = without_structure(swept_block(2, 1, 1))
    hexes = mesh.hexes.copy()
    hexes[1] = hexes[1][[3, 1, 2, 0, 4, 5, 6, 7]]  # the face it shares gets its nodes in another order
    assert any("turn" in p for p in check_mesh(replace(mesh, hexes=hexes)).problems)


def test_interfaces_between_parts_may_be_named():
    mesh = without_structure(swept_block(2, 1, 1))
    middle = mesh.hexes[0:1][:, [1, 2, 6, 5]]
    named = replace(mesh, boundaries=mesh.boundaries | {"interface": middle})
    assert not check_mesh(named).valid
    assert check_mesh(replace(named, parts={"left": np.array([0]), "right": np.array([1])})).valid


def test_without_any_boundary_name_none_is_asked_for():
    assert check_mesh(HexMesh(points=swept_block().points, hexes=swept_block().hexes, boundaries={})).valid


@pytest.mark.parametrize(
    ("points", "hexes"), [((0, 3), (0, 8)), ((4, 2), (0, 8)), ((8, 2), (1, 8)), ((8, 3), (1, 6)), ((8,), (1, 8))]
)
def test_empty_and_misshapen_meshes_are_not_valid(points, hexes):
    mesh = HexMesh(points=np.zeros(points), hexes=np.zeros(hexes, dtype=np.int64), boundaries={})
    report = check_mesh(mesh)
    assert not report.valid
    json.dumps(report.to_dict(), allow_nan=False)
    assert "NOT VALID" in str(report)


@pytest.mark.parametrize("n_nodes", [20, 27])
def test_order_2_meshes(n_nodes):
    coarse = swept_block(3, 2, 2)
    nodes = raised(coarse.points[coarse.hexes], n_nodes)
    points, inverse = np.unique(np.round(nodes.reshape(-1, 3), 9), axis=0, return_inverse=True)
    hexes = inverse.reshape(-1, n_nodes)
    mesh = HexMesh(points=points, hexes=hexes, boundaries={})
    report = check_mesh(mesh)
    assert report.problems == ()
    assert report.volume == pytest.approx(12)
    assert report.order == 2
    torn = hexes.copy()
    torn[0, 9] = len(points)  # the edge's other users keep their middle node
    twice = replace(mesh, hexes=torn, points=np.vstack([points, points[hexes[0, 9]]]))
    assert any("middle nodes" in p for p in check_mesh(twice).problems)
    bulged = points.copy()
    bulged[hexes[0, 8]] += [0.4, 0, 0]
    assert check_mesh(replace(mesh, points=bulged)).n_inverted > 0


def test_corner_valid_hexes_with_a_negative_inside_are_inverted():
    from .quality_meshes import random_hexes

    soup = random_hexes(3000, 0.3, seed=4)
    points, hexes = hex_soup(soup)
    report = check_mesh(HexMesh(points=points, hexes=hexes, boundaries={}))
    assert report.n_inverted == np.count_nonzero(~positive_inside(points, hexes)[0])
    assert (
        report.n_inverted > report.histogram[1][report.histogram[0][1:] <= 0].sum()
    )  # more than those with a bad corner


# --- against the CAD model -------------------------------------------------------------------------


def cylinder(n_around, n_layers, *, radius=1.0):
    """A cylinder of height 2 whose section is a square turned into a disc, n_around / 4 quads a side."""
    n = n_around // 4
    plane, quads, loops = grid_quads(n, n)
    square = 2 * plane / n - 1
    # Concentric squares become concentric circles, their corners kept a little off.
    norm = np.abs(square).max(axis=1)
    angle_in_side = np.where(
        np.abs(square[:, 0]) >= np.abs(square[:, 1]),
        square[:, 1] / np.where(norm > 0, norm, 1),
        square[:, 0] / np.where(norm > 0, norm, 1),
    )
    theta = np.where(
        np.abs(square[:, 0]) >= np.abs(square[:, 1]),
        np.where(square[:, 0] >= 0, 0, np.pi) + np.where(square[:, 0] >= 0, 1, -1) * angle_in_side * np.pi / 4,
        np.where(square[:, 1] >= 0, np.pi / 2, -np.pi / 2)
        - np.where(square[:, 1] >= 0, 1, -1) * angle_in_side * np.pi / 4,
    )
    disc = radius * norm[:, None] * np.c_[np.cos(theta), np.sin(theta)]
    points = np.concatenate([np.c_[disc, np.full(len(disc), 2.0 * k / n_layers)] for k in range(n_layers + 1)])
    return swept_mesh(points, quads, loops, n_layers)


def reference(**changes):
    """The cylinder of radius 1 and height 2."""

    def distance(points, name, close):
        if name == "side":
            return np.abs(np.hypot(points[:, 0], points[:, 1]) - 1)
        return np.abs(points[:, 2] - (0 if name == "source" else 2))

    areas = {"side": 4 * np.pi, "source": np.pi, "target": np.pi}
    return CadReference(**({"volume": 2 * np.pi, "areas": areas, "euler": 2, "distance": distance} | changes))


@pytest.mark.parametrize("n_around", [16, 32, 64])
def test_a_faceted_cylinder_agrees_with_its_cad_model(n_around):
    # Facets explain what they lose, whatever the mesh; a disc of n chords is smaller by (2 pi / n)^2 / 6.
    problems = [p for p in check_mesh(cylinder(n_around, 4), cad=reference()).problems if "inverted" not in p]
    assert problems == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"volume": 2 * np.pi * 1.05}, "volume"),
        ({"areas": {"side": 4 * np.pi * 1.05}}, "area of 'side'"),
        ({"areas": {"source": np.pi * 0.95}}, "area of 'source'"),
        ({"areas": {"lid": 1.0}}, "no boundary 'lid'"),
        ({"euler": 0}, "Euler"),
        ({"volume": float("nan")}, "volume"),
    ],
)
def test_deviations_from_the_cad_model_are_problems(changes, words):
    problems = check_mesh(cylinder(64, 4), cad=reference(**changes)).problems
    assert any(words in p for p in problems), problems


def test_nodes_off_their_face_are_problems():
    mesh = cylinder(32, 4)
    node = int(mesh.boundaries["side"][0, 2])
    off = moved(mesh, node, mesh.points[node] * [1.001, 1.001, 1])
    assert any("off their CAD face" in p and f"node {node} " in p for p in check_mesh(off, cad=reference()).problems)


def test_a_distance_that_is_no_number_is_a_problem():
    problems = check_mesh(
        cylinder(32, 4), cad=reference(distance=lambda points, name, close: np.full(len(points), np.nan))
    ).problems
    assert sum("off their CAD face" in p for p in problems) == 3  # of each boundary


def test_the_cad_volume_in_the_mesh_is_used():
    mesh = swept_block()
    assert check_mesh(replace(mesh, info={"cad_volume": 36.0})).valid
    assert not check_mesh(replace(mesh, info={"cad_volume": 37.0})).valid


def test_a_mesh_that_was_held_against_its_faces_stays_valid_and_a_changed_one_does_not():
    mesh = swept_block()
    # The CAD's volume was 37, and its faces explained the difference when the mesh was made.
    made = replace(mesh, info={"cad_volume": 37.0, "quality": check_mesh(mesh)})
    assert made.quality().valid
    assert not replace(made, points=made.points * 0.99).quality().valid


@pytest.mark.parametrize("name", ["side", "source", "target"])
def test_one_node_among_many_is_found(name):
    mesh = cylinder(128, 400)  # 400 layers of 128 ring nodes
    nodes = np.unique(mesh.boundaries[name])
    outward = [0, 0, 1] if name != "side" else [1, 1, 0]
    for node in nodes[np.random.default_rng(0).integers(len(nodes), size=2)]:
        off = moved(mesh, node, mesh.points[node] + 1e-4 * np.where(outward, np.sign(mesh.points[node]) + 0.5, 0))
        problems = check_mesh(off, cad=reference()).problems
        assert any(p.startswith("1 nodes of") and f"node {node} " in p for p in problems), problems


def test_rims_are_held_against_the_edges_and_vertices_they_meet_in():
    mesh = swept_block()  # 4 x 3 x 3
    asked = {}

    def rim_distance(points, blocks):
        asked[frozenset(name for (name,) in blocks)] = len(points)
        return np.where(points[:, 0] == 4, 0.1, 0.0)  # as if the edges at x = 4 were elsewhere

    left = (mesh.points[mesh.boundaries["side"], 0] == 0).all(axis=1)
    boundaries = mesh.boundaries | {"side": mesh.boundaries["side"][~left], "left": mesh.boundaries["side"][left]}
    report = check_mesh(
        replace(mesh, boundaries=boundaries),
        cad=reference(areas={}, volume=36.0, distance=None, rim_distance=rim_distance),
    )
    # Two upright edges of 2 inner nodes; caps' edges of 3 - 1 inner nodes at x = 0; the other three sides of each cap.
    assert asked == {
        frozenset({"side", "left"}): 2 * 2,
        frozenset({"source", "left"}): 2,
        frozenset({"target", "left"}): 2,
        frozenset({"source", "side"}): 3 + 2 + 3 + 2,
        frozenset({"target", "side"}): 3 + 2 + 3 + 2,
        frozenset({"source", "side", "left"}): 2,
        frozenset({"target", "side", "left"}): 2,
    }
    off = [p for p in report.problems if "off their CAD" in p]
    assert len(off) == 2  # 4 nodes of either cap's rim lie at x = 4
    assert all(p.startswith("4 nodes where") and "'side'" in p for p in off)


@pytest.mark.parametrize("name", ["block", "one layer", "bent", "ring"])
def test_the_limit_is_the_same_layer_by_layer(name):
    mesh = SOUND[name]()
    n = mesh.structure.n_nodes
    rng = np.random.default_rng(0)
    points = mesh.points + rng.normal(size=mesh.points.shape) * 0.1
    whole = boundary_limit(points, mesh.structure)
    assert whole == boundary_limit(lambda k: points[k * n : (k + 1) * n], mesh.structure)
    assert whole.value < 1
    values = scaled_jacobians(points, mesh.hexes)
    assert values.min() <= values[whole.hex] <= whole.value + 1e-12
