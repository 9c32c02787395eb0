"""Patches of faces as one surface, and runs of edges as one curve."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.blends import find_blends
from cadsweep.blends.patches import PatchSurface, find_patches
from cadsweep.blends.runs import find_runs

pytestmark = pytest.mark.cad


def rounded_bar():
    """A bar with one rounded edge along it, radius 2, and its patches."""
    solid = cs.load(cq.Workplane().box(12, 8, 6).edges(">X and >Y").fillet(2)).solids[0]
    blends = find_blends(solid)
    return solid, find_patches(solid, blends, {f for blend in blends for f in blend.faces})


def test_a_blend_and_what_it_lies_between_are_one_patch_and_all_others_by_themselves():
    solid, patch_of = rounded_bar()
    sizes = sorted(np.unique(patch_of, return_counts=True)[1].tolist())
    assert sizes == [1, 1, 1, 1, 3]
    assert len(set(find_patches(solid, find_blends(solid), set()).tolist())) == len(solid.faces)


def test_points_of_a_patch_are_their_own_nearest_ones_and_outside_the_border_is():
    solid, patch_of = rounded_bar()
    members = np.flatnonzero(np.bincount(patch_of, minlength=7)[patch_of] == 3)
    surface = PatchSurface(solid, members.tolist())
    rng = np.random.default_rng(1)
    scale = solid.units.scale
    # Around the rounding, by angle and height; then the two planes beside it.
    angle, z = 0.5 * np.pi * rng.random(50), rng.uniform(-3, 3, 50)
    points = np.concatenate([
        np.column_stack([4 + 2 * np.cos(angle), 2 + 2 * np.sin(angle), z]),
        np.column_stack([rng.uniform(-6, 4, 50), np.full(50, 4.0), z]),
        np.column_stack([np.full(50, 6.0), rng.uniform(-4, 2, 50), z]),
    ]) / scale  # fmt: skip
    uv = surface.project(points)
    np.testing.assert_allclose(surface.evaluate(uv), points, atol=1e-9)
    assert surface.distance(points).max() < 1e-9
    assert [len(set(uv[own, 2])) for own in (slice(0, 50), slice(50, 100), slice(100, 150))] == [1, 1, 1]
    # The sharp corner of the design goes to the middle of the rounding.
    corner = np.array([[6.0, 4.0, 0.0]]) / scale
    middle = np.array([[4 + np.sqrt(2), 2 + np.sqrt(2), 0.0]]) / scale
    np.testing.assert_allclose(surface.evaluate(surface.project(corner)), middle, atol=1e-9)
    np.testing.assert_allclose(surface.distance(corner) * scale, [2 * (np.sqrt(2) - 1)])
    # Above the bar the border is nearest, and not the planes that the faces are pieces of.
    above = np.array([[0.0, 4.0, 5.0]]) / scale
    np.testing.assert_allclose(surface.evaluate(surface.project(above)) * scale, [[0.0, 4.0, 3.0]], atol=1e-9)
    np.testing.assert_allclose(surface.distance(above) * scale, [2.0])


def test_a_place_on_a_patch_is_found_again_also_at_the_bent_border_of_two_blends():
    shape = cq.Workplane().polyline([(8, 8), (38, 8), (8, 38)]).close().extrude(4, both=True)
    shape = shape.union(cq.Workplane().box(8, 100, 50, centered=(False, True, True)))
    inner = [
        e for e in shape.edges().vals() if abs(e.Center().x - 8) < 1e-6 and abs(e.Center().z) < 5 and e.Length() < 40
    ]
    solid = cs.load(cq.Workplane(shape.val().fillet(3, inner))).solids[0]
    blends = find_blends(solid)
    patch_of = find_patches(solid, blends, {f for blend in blends for f in blend.faces})
    members = np.flatnonzero(patch_of == np.argmax(np.bincount(patch_of)))
    surface = PatchSurface(solid, members.tolist())
    at = np.linspace(0.0, 1.0, 101)
    rng = np.random.default_rng(0)
    for e in {e for f in members for e in solid.faces[f].edges if set(solid.edges[e].faces) <= set(members)}:
        near = solid.edges[e].curve.evaluate(at) + 1e-3 * solid.size * rng.normal(size=(101, 3))
        placed = surface.evaluate(surface.project(near))
        assert surface.distance(placed).max() < 1e-9 * solid.size


def test_a_run_goes_on_where_a_blend_ends_and_its_fractions_are_of_its_length():
    solid, patch_of = rounded_bar()
    top = next(face.id for face in solid.faces if face.normal[2] > 0.9)
    runs = [run for run in find_runs(solid, patch_of, range(len(solid.vertices))) if patch_of[top] in run.pair]
    assert sorted(len(run.edges) for run in runs) == [1, 1, 3]
    (run,) = [run for run in runs if len(run.edges) == 3]
    assert run.length * solid.units.scale == pytest.approx(10 + np.pi + 6)
    at = np.linspace(0.0, 1.0, 23)
    points = run.evaluate(at)
    np.testing.assert_allclose(run.project(points), at, atol=1e-9)
    assert run.distance(points).max() < 1e-9
    steps = np.linalg.norm(np.diff(run.evaluate(np.linspace(0.0, 1.0, 2001)), axis=0), axis=1)
    np.testing.assert_allclose(steps.sum(), run.length, rtol=1e-6)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-3)


def test_a_kink_is_a_corner_of_a_run_only_where_the_design_has_one():
    solid, patch_of = rounded_bar()
    top = next(face.id for face in solid.faces if face.normal[2] > 0.9)
    every = range(len(solid.vertices))
    (long,) = [run for run in find_runs(solid, patch_of, every) if patch_of[top] in run.pair and len(run.edges) == 3]
    first, second = long.edges[:2]
    (joint,) = {first.start, first.end} & {second.start, second.end}
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    edges = list(solid.edges)
    edges[first.id] = replace(first, tangents=first.tangents @ turned)
    kinked = replace(solid, edges=tuple(edges))

    def lengths(corners):
        return sorted(len(run.edges) for run in find_runs(kinked, patch_of, corners) if run.pair == long.pair)

    assert lengths(set(every) - {joint}) == [3]
    assert lengths({joint}) == [1, 2]
