"""A fitted grid: valid, on the model, with every edge of it, and said to be one."""

from dataclasses import replace
from math import atan2, pi, sin

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.cells import HEX_FACES
from cadsweep.errors import InputError, NotSweepableError
from cadsweep.fitted.grid import _FILL, _bad_corner, _manifold, narrow_spans
from cadsweep.fitted.sheets import Fitted, _two_sided, lay_sheets
from cadsweep.pipeline import fitted_grids, routes
from cadsweep.pipeline.fitted_grids import _facets

from . import castings


def bored_block():
    """A block with bores from two sides and a slanted one, none of which meet."""
    block = cq.Workplane().box(40, 30, 20)
    block = block.cut(cq.Workplane("XY").center(-10, 5).circle(4).extrude(40, both=True))
    block = block.cut(cq.Workplane("XZ").center(8, 0).circle(3).extrude(40, both=True))
    slanted = cq.Workplane("XY").transformed(rotate=(0, 35, 0)).center(-1, -9).circle(2.5).extrude(60, both=True)
    return block.cut(slanted)


@pytest.fixture(scope="module")
def meshed():
    return cs.sweep_mesh(bored_block(), fitted=True, names={"inlet": "faces:<X"})


def test_it_is_valid_and_has_the_volume_of_the_model(meshed):
    report = meshed.quality()
    assert report.valid
    assert report.min_scaled_jacobian >= 0.1
    volume = bored_block().val().Volume()
    # Chords of bores of five segments or more are off by less than a quarter of the bores, which are under a tenth.
    assert abs(report.volume - volume) < 0.02 * volume


def test_its_boundary_is_closed_and_manifold(meshed):
    every = np.sort(meshed.hexes[:, HEX_FACES].reshape(-1, 4), axis=1)
    _, first, counts = np.unique(every, axis=0, return_index=True, return_counts=True)
    assert counts.max() == 2
    outer = meshed.hexes[:, HEX_FACES].reshape(-1, 4)[first[counts == 1]]
    sides = np.sort(np.stack([outer, np.roll(outer, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert sum(len(quads) for quads in meshed.boundaries.values()) == len(outer)


def test_every_sharp_edge_of_the_model_is_a_chain_of_nodes_on_it(meshed):
    solid = meshed.origin.part.solids[0]
    joined = meshed.origin.joined
    for edge in solid.edges:
        if abs(edge.dihedral - pi) < 1e-3:
            continue
        chain = joined.edge_nodes[int(solid.edge_keys[edge.id])]
        assert edge.curve.distance(joined.points[chain]).max() < 1e-9 * solid.size
        assert np.allclose(joined.points[chain[[0, -1]]], solid.vertices[[edge.start, edge.end]])
        # In order along the edge, and as long as it but for chords.
        assert (np.diff(edge.curve.project(joined.points[chain])) > 0).all()


def test_faces_keep_their_names_and_the_record_says_how_it_was_filled(meshed):
    assert (meshed.points[meshed.boundaries["inlet"]][..., 0] == -20).all()
    assert meshed.record.way == "fitted"
    assert any("fitted grid" in note for note in meshed.record.notes)


def test_a_wall_far_thinner_than_a_cell_has_two_across_and_the_rest_stays_coarse():
    thickness, size = 0.15, 1.0
    part = cq.Workplane().box(12, 6, 3)
    for side in (-1, 1):
        part = part.cut(cq.Workplane().center(side * (2 + thickness / 2), 0).circle(2).extrude(3, both=True))
    mesh = cs.sweep_mesh(part, fitted=True, size=size)
    at_wall = mesh.points[(np.abs(mesh.points[:, :2]) < [thickness, size / 2]).all(axis=1)]
    assert len(np.unique(np.round(at_wall[:, 0], 9))) >= 3
    # Even cells of half of the wall would be 12 * 6 * 3 / 0.075^3, half a million.
    assert mesh.n_hexes < 3000


def test_what_is_narrow_is_found_where_it_is_and_nowhere_else():
    part = cs.load(cq.Workplane().box(20, 20, 10).cut(cq.Workplane().box(1.5, 30, 10).translate((3, 0, 3))))
    (solid,) = part.solids
    facets = _facets(solid)
    size = 1.0 / part.scale
    assert np.allclose(narrow_spans(solid, facets, np.eye(3), 0, size) * part.scale, [[2.25, 3.75]], atol=0.06)
    assert not len(narrow_spans(solid, facets, np.eye(3), 1, size))
    assert not len(narrow_spans(solid, facets, np.eye(3), 2, size))


def test_it_is_taken_where_all_else_is_refused_and_not_where_it_is_forbidden(monkeypatch):
    def refuse(*_):
        raise NotSweepableError("no way")

    for row in routes.WAYS.keys() - {routes.FITTED}:
        monkeypatch.setitem(routes.WAYS, row, refuse)
    mesh = cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0)
    assert mesh.record.way == "fitted"
    assert "because no way" in mesh.record.notes[-1]
    assert mesh.n_hexes == 24  # 4 x 3 x 2 cells of the size asked for
    with pytest.raises(NotSweepableError, match="no way"):
        cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0, fitted=False)
    with pytest.raises(NotSweepableError, match="no way"):
        cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0, layers=2)


def test_a_cube_with_a_dimple_in_three_sides_which_nothing_else_fills_is_filled():
    shape = cq.Workplane().box(20, 20, 20)
    for place in ((10, 3, 2), (2, 10, 3), (3, 2, 10)):
        shape = shape.cut(cq.Workplane().sphere(4).translate(place))
    mesh = cs.sweep_mesh(shape, decompose_time=0.2)
    assert mesh.record.way == "fitted"
    assert mesh.record.quality.valid
    assert mesh.record.quality.min_scaled_jacobian >= 0.1


def test_it_is_taken_where_it_is_far_better_than_a_poor_mesh_and_never_a_worse_one(monkeypatch):
    block = cq.Workplane().box(4, 3, 2)
    sweep = routes.WAYS[routes.SWEEP]

    def poor(worst):
        def make(*args):
            mesh = sweep(*args)
            quality = replace(mesh.info["quality"], min_scaled_jacobian=worst)
            return replace(mesh, info={**mesh.info, "quality": quality})

        return make

    for worst, way in ((0.05, "fitted"), (0.19, "fitted"), (0.21, "sweep")):
        monkeypatch.setitem(routes.WAYS, routes.SWEEP, poor(worst))
        mesh = cs.sweep_mesh(block, size=1.0, decompose_time=0.1)
        assert mesh.record.way == way
        assert ("way: fitted" in mesh.record.rows) == (way == "fitted") != ("way: sweep" in mesh.record.rows)
        assert cs.sweep_mesh(block, size=1.0, fitted=False, decompose_time=0.1).record.way == "sweep"
        without = cs.sweep_mesh(block, size=1.0, decompose_time=0.1, without=[routes.INSTEAD])
        assert without.record.way == "sweep"
        assert cs.sweep_mesh(block, size=1.0, layers=2, decompose_time=0.1).record.way == "sweep"
        assert cs.sweep_mesh(block, size=1.0, smoothing=False, decompose_time=0.1).record.way == "sweep"
    monkeypatch.setitem(routes.WAYS, routes.SWEEP, poor(0.05))
    assert "because the worst scaled Jacobian by sweep is 0.05" in cs.sweep_mesh(block, size=1.0).record.notes[-1]


def test_it_is_tried_too_where_a_poor_mesh_took_all_the_time_of_a_run(monkeypatch):
    sweep = routes.WAYS[routes.SWEEP]

    def late(part, options, run, before):
        mesh = sweep(part, options, run, before)
        monkeypatch.setattr(type(run), "is_over", lambda self: True)
        return replace(mesh, info={**mesh.info, "quality": replace(mesh.info["quality"], min_scaled_jacobian=0.05)})

    monkeypatch.setitem(routes.WAYS, routes.SWEEP, late)
    mesh = cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0)
    assert mesh.record.way == "fitted"
    assert "way: cells" not in mesh.record.rows


@pytest.mark.parametrize(
    ("worsts", "taken"), [((0.15, 0.3, 0.9), 1), ((0.15, 0.12, 0.11, 0.13, 0.14), 0), ((0.3, 0.9), 0)]
)
def test_the_best_grid_is_taken_where_the_first_is_below_the_goal(monkeypatch, worsts, taken):
    sizes = []
    finish = fitted_grids.finish

    def judged(*args, **options):
        mesh = finish(*args, **options)
        quality = replace(mesh.info["quality"], min_scaled_jacobian=worsts[len(sizes)])
        sizes.append(mesh.n_hexes)
        return replace(mesh, info={**mesh.info, "quality": quality})

    monkeypatch.setattr(fitted_grids, "finish", judged)
    # Five sizes are tried, none of them twice: a block has nothing narrow.
    assert cs.sweep_mesh(cq.Workplane().box(4, 3, 2), fitted=True).n_hexes == sizes[taken]
    assert len(sizes) == (taken + 1 if worsts[taken] >= 0.25 else len(worsts))


def test_no_finer_grid_is_tried_where_a_sharp_corner_of_the_part_limits_them_all(monkeypatch):
    made = []
    finish = fitted_grids.finish
    monkeypatch.setattr(fitted_grids, "finish", lambda *args, **options: made.append(1) or finish(*args, **options))
    slot = cq.Workplane("XZ").polyline([(-10, 5), (-10, 0), (8, 5)]).close().extrude(8).translate((0, 4, 0))
    mesh = cs.sweep_mesh(cq.Workplane().box(20, 20, 10).cut(slot), fitted=True)
    # Two quads share the corner of 15.5 degrees at the end of the slot.
    assert 0.9 * sin(atan2(5, 18) / 2) < mesh.record.quality.min_scaled_jacobian < 0.25
    assert len(made) == 1


def test_no_grid_is_tried_where_a_sharp_corner_of_the_part_is_to_blame(monkeypatch):
    def make(*_args, **_options):
        pytest.fail("a grid that can be no better")

    monkeypatch.setitem(routes.WAYS, routes.FITTED, make)
    wedge = cq.Workplane("XZ").polyline([(0, 0), (20, 0), (20, 2)]).close().extrude(5)
    assert 0 < cs.sweep_mesh(wedge).record.quality.min_scaled_jacobian < 0.2


def test_what_is_swept_stays_so_and_says_it():
    assert cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0).record.way == "sweep"


@pytest.mark.parametrize("asked", [{"layers": 3}, {"counts": {"edges:>Z": 2}}, {"cuts": ["plane z=0"]}])
def test_what_a_fitted_grid_has_not_is_refused_by_name(asked):
    with pytest.raises(InputError, match=next(iter(asked))):
        cs.sweep_mesh(cq.Workplane().box(4, 3, 2), fitted=True, **asked)


@pytest.mark.parametrize(
    ("asked", "place"),
    [
        ({"sizes": {">Z": 1.5}}, (0, 0, 10)),
        ({"sizes": {"edges:|Y and >X and >Z": 1.0}}, (20, 0, 10)),
        ({"local_sizes": [{"at": (20, -15, 10), "radius": 3, "size": 1.0}]}, (20, -15, 10)),
        ({"local_sizes": lambda points: 1.0 + 0.2 * abs(points[:, 0])}, (0, 0, 10)),
    ],
    ids=["face", "edge", "place", "function"],
)
def test_planes_of_a_grid_are_closer_where_sizes_are_asked_for(asked, place):
    block = cq.Workplane().box(40, 30, 20).faces("<Y").workplane().hole(8)

    def lengths(mesh):
        """Of the quads' sides near the place."""
        quads = np.concatenate(list(mesh.boundaries.values()))
        ends = mesh.points[np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)]
        near = np.linalg.norm(ends.mean(axis=1) - place, axis=1) < 4
        return np.linalg.norm(ends[near, 1] - ends[near, 0], axis=1)

    even, finer = (cs.sweep_mesh(block, fitted=True, size=4.0, **own) for own in ({}, asked))
    assert finer.quality().valid
    assert np.median(lengths(finer)) < 2.0 < np.median(lengths(even))


def test_round_inner_edges_and_wide_corners_are_meshed():
    boss = cq.Workplane().box(10, 8, 4).faces(">Z").workplane().circle(2.5).extrude(3)
    mesh = cs.sweep_mesh(boss.cut(cq.Workplane().box(4, 4, 2).translate((5, 4, 2))), fitted=True)
    assert mesh.record.quality.valid
    assert mesh.record.quality.min_scaled_jacobian >= 0.2


@pytest.mark.parametrize(("name", "least"), [("knob", 0.2), ("bracket", 0.3)])
def test_castings_are_filled(name, least):
    shape = getattr(castings, name)()
    mesh = cs.sweep_mesh(shape, fitted=True)
    report = mesh.quality()
    assert report.valid
    assert report.min_scaled_jacobian >= least
    assert abs(report.volume / shape.val().Volume() - 1.0) < 0.01


def test_smooth_faces_keep_their_names_in_a_united_one():
    block = cq.Workplane().box(20, 16, 10).edges("|Z").fillet(4)
    mesh = cs.sweep_mesh(block, fitted=True, names={"front": "faces:<Y", "round": "faces:(%CYLINDER)"})
    assert mesh.record.quality.valid
    assert len(mesh.boundaries["front"]) > 0
    # The border between the two is none of the mesh: of either there is what has its middle in it.
    middles = mesh.points[mesh.boundaries["front"]].mean(axis=1)
    assert np.allclose(middles[:, 1], -8, atol=0.1)
    assert (np.abs(middles[:, 0]) < 6).all()


def test_narrow_rings_are_laid_in():
    # A chamfer of a fifth of a cell around a bore, and a step of half of one: rows of quads of their own.
    block = cq.Workplane().box(30, 30, 12).cut(cq.Workplane().circle(6).extrude(20, both=True))
    block = block.edges("%CIRCLE").chamfer(0.3).cut(cq.Workplane(origin=(0, 0, 5)).circle(7).extrude(5))
    mesh = cs.sweep_mesh(block, fitted=True, size=2.0)
    assert mesh.record.quality.valid
    solid = mesh.origin.part.solids[0]
    narrow = [face for face in solid.faces if len(face.loops) == 2 and face.area < 45]
    assert len(narrow) >= 2
    assert not any("narrower" in note for note in mesh.record.notes)


def test_a_strip_narrower_than_a_cell_between_two_loops_is_a_row_of_quads():
    # The wall of the boss is 0.3 from the side of the block: on a grid of size 2 they meet.
    block = cq.Workplane().box(20, 16, 8).union(cq.Workplane(origin=(4.7, 0, 4)).circle(5).extrude(4))
    mesh = cs.sweep_mesh(block, fitted=True, size=2.0, names={"side": "faces:>X"})
    assert mesh.record.quality.valid
    assert mesh.record.quality.min_scaled_jacobian >= 0.2
    quads = np.concatenate(list(mesh.boundaries.values()))
    around = (np.abs(np.linalg.norm(mesh.points[quads][..., :2] - [4.7, 0], axis=2) - 5) < 1e-9).all(axis=1)
    assert around.sum() >= 16  # at least one round of an eighth of a turn each, two high
    assert not np.intersect1d(mesh.boundaries["side"], quads[around]).size


def block_over_bar():
    block = cq.Workplane().box(20, 16, 8, centered=(True, True, False))
    block = block.union(cq.Workplane(origin=(0, 0, -3)).box(30, 5, 3, centered=(True, True, False)))
    return block.edges(">Z").fillet(2)


def rounded_block_beside_bar():
    """The side that the bar lies on runs smoothly into the others, with which it is one face."""
    block = cq.Workplane().box(20, 16, 8, centered=(True, True, False)).edges("|Z").fillet(3)
    return block.union(cq.Workplane(origin=(10, 0, -4)).box(3, 5, 16, centered=(False, True, False)))


@pytest.mark.parametrize("make", [block_over_bar, rounded_block_beside_bar])
def test_a_bar_flush_with_a_side_of_a_block_has_sheets_on_both_sides(make):
    """In each of four vertices two faces of one plane look opposite ways: no node of one sheet is inward of both."""
    mesh = cs.sweep_mesh(make(), fitted=True)
    assert mesh.record.quality.valid
    assert mesh.record.quality.min_scaled_jacobian >= 0.25


def test_a_slit_that_runs_out_to_nothing_parts_no_sheet():
    """Its sides look opposite ways in the ends of the edge in which they meet; a plane through all else is no help."""
    arc_end = 20 - np.sqrt(20**2 - 8**2)
    slit = cq.Workplane().lineTo(8, 0).lineTo(8, arc_end).radiusArc((0, 0), 20).close().extrude(10, both=True)
    part = cs.load(cq.Workplane().box(30, 20, 6).cut(slit))
    assert any(edge.dihedral > 2 * pi - 1e-3 for edge in part.solids[0].edges)
    assert not _two_sided(part.solids[0])
    assert len(_two_sided(cs.load(block_over_bar()).solids[0])) == 1


def test_what_is_far_narrower_than_a_cell_is_bridged_and_named():
    block = cq.Workplane().box(20, 16, 10).cut(cq.Workplane().box(10, 0.1, 0.1).translate((5, 8, 5)))
    mesh = cs.sweep_mesh(block, fitted=True, size=2.0)
    assert mesh.record.quality.valid
    assert any("far narrower than a cell" in note for note in mesh.record.notes)


def test_a_rim_has_two_quads_at_every_node_of_a_border():
    disc = cq.Workplane().circle(5).extrude(4)
    mesh = cs.sweep_mesh(disc, fitted=True, size=1.0)
    solid, joined = mesh.origin.part.solids[0], mesh.origin.joined
    flat = next(face.id for face in solid.faces if face.kind == "plane")
    quads = joined.quads[joined.quad_faces == flat]
    rim = np.unique(np.concatenate([joined.edge_nodes[int(solid.edge_keys[e])] for e in solid.faces[flat].edges]))
    assert (np.bincount(quads.ravel(), minlength=len(joined.points))[rim] == 2).all()


def test_cells_that_touch_along_an_edge_or_at_a_corner_alone_are_joined():
    # Of the 256 ways to have cells around a corner, filling on always ends: all eight are manifold.
    for first in range(256):
        code = first
        for _ in range(8):
            if _FILL[code] < 0:
                break
            assert not code >> _FILL[code] & 1
            code |= 1 << int(_FILL[code])
        assert _FILL[code] < 0
    kept = np.zeros((6, 6, 6), dtype=bool)
    kept[1:3, 1:3, 1:3] = True
    kept[3, 3, 2] = kept[3, 4, 2] = True  # along an edge
    kept[2, 3, 1] = True
    assert _bad_corner(_manifold(kept)) is None


def test_a_body_without_an_edge_gets_a_sheet():
    """One hexahedron whose six quads are one face, as of an egg: with a sheet each has a hexahedron of its own."""
    (ball,) = cs.load(cq.Workplane().sphere(1)).solids
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    egg = Fitted(
        points=corners, hexes=np.arange(8)[None], quads=HEX_FACES, labels=np.zeros(6, dtype=np.int64), chains={}
    )
    assert len(lay_sheets(ball, {}, (), egg, 1.0).hexes) == 1 + 6
