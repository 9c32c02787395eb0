"""What the paper says of its four examples, as equations where geometry gives them, else as inequalities."""

import importlib.util
import json
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cadsweep.projection import fit_affine, project_layers, pseudo_normal

from .pictures import skip_where_nothing_draws

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

MODELS = Path(__file__).parents[1] / "models"
EXACT = 1e-9


def load_script(name):
    spec = importlib.util.spec_from_file_location(name, MODELS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


paper = load_script("paper")


@pytest.fixture(scope="module")
def sides():
    """Source and linking sides of all four, coarse: what is asserted holds for every mesh."""
    return {name: paper.mesh_sides(paper.find_sweep(name)[1], size=0.3) for name in paper.EXAMPLES}


@pytest.fixture(scope="module")
def layers(sides):
    """Figures of layers 1 to 9 for every example and functional."""
    return {(name, f): paper.measure_layers(sides[name], f) for name in sides for f in paper.FUNCTIONALS}


def column(figures, name):
    return np.array([getattr(layer, name) for layer in figures], dtype=float)


def place(sides, **options):
    """Place the layers of an example with H; without residual unless it is asked for."""
    options = {"residual": False} | options
    return project_layers(sides.source.points, sides.source.quads, sides.rings, loops=sides.source.loops, **options)


def turned(points, angle):
    """Points turned the way the C is swept: from the x axis towards -z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return points @ np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])


def angles():
    """Angle of each node layer of the C-shape."""
    return np.pi * np.arange(paper.N_LAYERS + 1) / paper.N_LAYERS


@pytest.mark.parametrize("name", paper.EXAMPLES)
class TestEveryExample:
    def test_the_source_has_a_plane_boundary_and_a_domed_inside(self, sides, name):
        source, ring = sides[name].source, sides[name].rings[0]
        center = ring.mean(axis=0)
        normal = np.linalg.svd(ring - center)[2][2]
        assert np.abs((ring - center) @ normal).max() < EXACT
        assert np.abs((source.points - center) @ normal).max() > 0.3  # of the dome's 0.4; no node need sit on top

    def test_the_normals_of_source_and_rings_look_along_the_sweep(self, sides, name):
        rings = sides[name].rings
        loops = [np.arange(rings.shape[1])]
        for ring, following in pairwise(rings):
            assert pseudo_normal(ring, loops) @ (following - ring).mean(axis=0) > 0

    def test_h_keeps_the_dome_upright(self, layers, name):
        figures = layers[name, "H"]
        np.testing.assert_allclose(column(figures, "flatness"), 1.0, atol=EXACT)
        np.testing.assert_allclose(column(figures, "skewness"), 0.0, atol=EXACT)
        assert (column(figures, "rank") == 3).all()

    def test_f_flattens_it(self, layers, name):
        figures = layers[name, "F"]
        for figure in ("flatness", "skewness"):
            np.testing.assert_allclose(column(figures, figure), 0.0, atol=EXACT)
        assert column(figures, "mesh_flatness").max() < 1e-4  # the rings themselves may leave their mean plane
        assert (column(figures, "rank") == 2).all()

    def test_g_skews_it_wherever_its_system_can_be_solved(self, layers, name):
        figures = layers[name, "G"]
        solvable = column(figures, "rank") == 3
        assert solvable[:-1].all()
        assert (column(figures, "skewness")[solvable] > 0.01).all()

    def test_the_mesh_shows_what_the_matrices_say(self, layers, name):
        # Sideways the identity v = A n is the top's own displacement, with every functional.
        for functional in paper.FUNCTIONALS:
            figures = [layer for layer in layers[name, functional] if layer.rank == 3 or functional == "F"]
            shown, said = column(figures, "mesh_skewness"), column(figures, "skewness")
            np.testing.assert_allclose(shown, said, atol=1e-6)


class TestCShape:
    def test_h_is_the_turned_source(self, sides):
        placed = paper.place_layers(sides["c_shape"], "H")
        for k, angle in enumerate(angles()):
            expected = turned(sides["c_shape"].source.points, angle)
            np.testing.assert_allclose(placed.layer(k), expected, atol=EXACT)  # the radius is 1

    @pytest.mark.parametrize("strategy", ["advancing", "both"])
    def test_every_strategy_turns_the_source(self, sides, strategy):
        source = sides["c_shape"].source
        target = turned(source.points, np.pi)
        target[np.concatenate(source.loops)] = sides["c_shape"].rings[-1]
        placed = place(sides["c_shape"], strategy=strategy, target_points=target)
        for k, angle in enumerate(angles()):
            np.testing.assert_allclose(placed.layer(k), turned(source.points, angle), atol=EXACT)

    def test_h_turns_a_section_with_a_bore_as_well(self):
        # The same C with an eccentric bore: loops of unequal length, and of a centre of their own.
        outer, inner = (2 * np.pi * np.arange(m) / m for m in (24, 9))
        loops = [np.arange(24), 24 + np.arange(9)]
        ring = np.concatenate(
            [
                np.column_stack([3 + np.cos(outer), -np.sin(outer), 0 * outer]),  # counter-clockwise about -z
                np.column_stack([3.3 + 0.4 * np.cos(inner), 0.2 + 0.4 * np.sin(inner), 0 * inner]),
            ]
        )
        points = np.random.default_rng(1).uniform([2, -1, 0], [4, 1, 0.4], size=(50, 3))
        np.testing.assert_allclose(pseudo_normal(ring, loops), [0, 0, -1], atol=EXACT)
        for angle in angles():
            fit = fit_affine(ring, turned(ring, angle), "H", loops=loops)
            np.testing.assert_allclose(fit(points), turned(points, angle), atol=EXACT)
            np.testing.assert_allclose(fit(ring), turned(ring, angle), atol=EXACT)

    def test_g_is_off_by_twice_the_height_times_tan_half_the_angle(self, sides, layers):
        tangents = 2 * np.tan(angles() / 2)[1:-1]
        figures = layers["c_shape", "G"][:-1]
        np.testing.assert_allclose(column(figures, "flatness"), 1.0, atol=EXACT)
        np.testing.assert_allclose(column(figures, "skewness"), tangents, rtol=EXACT)
        points = sides["c_shape"].source.points
        heights = np.abs(points[:, 2])  # the plane of the source ring is z = 0
        inside = np.setdiff1d(np.arange(len(points)), np.concatenate(sides["c_shape"].source.loops))
        placed = paper.place_layers(sides["c_shape"], "G")
        for k, tangent in enumerate(tangents, start=1):
            errors = np.linalg.norm(placed.layer(k) - turned(points, angles()[k]), axis=1)
            np.testing.assert_allclose(errors[inside], heights[inside] * tangent, atol=1e-8)

    def test_g_breaks_down_on_the_last_layer(self, layers):
        last = layers["c_shape", "G"][-1]
        assert last.rank == 2
        assert last.condition is None

    def test_the_worst_hexahedron_of_h_beats_that_of_g(self, layers):
        worst = {f: column(layers["c_shape", f], "worst").min() for f in "GH"}
        assert worst["H"] > 0.3
        assert worst["G"] < 0


def test_the_skewness_of_g_grows_towards_the_target_of_the_ellipses(layers):
    assert (np.diff(column(layers["skewed_ellipses", "G"], "skewness")) > 0).all()


def test_the_leading_mode_of_the_bent_square_is_the_saddle_inside_as_well(sides):
    # The rings are bent by x^2 - y^2, which is harmonic: what is carried inwards must be the same saddle, up to the
    # curvature of the dome on which it is carried.
    points = sides["square_semicircle"].source.points
    placed = place(sides["square_semicircle"], strategy="source", residual=True)
    mode = placed.basis[:, placed.basis.shape[1] - placed.n_modes]
    saddle = (points[:, 0] - 3) ** 2 - points[:, 1] ** 2
    most = np.abs(saddle).argmax()
    np.testing.assert_allclose(mode / mode[most], saddle / saddle[most], atol=0.1)


@pytest.mark.parametrize("name", ["square_semicircle", "square_to_arcs"])
class TestNotAffine:
    def test_what_no_affine_map_can_do_grows_towards_the_target(self, layers, name):
        residuals = column(layers[name, "H"], "residual")
        assert residuals[0] > 0
        assert (np.diff(residuals) > 0).all()

    @pytest.mark.parametrize("strategy", ["source", "both"])
    def test_the_residual_brings_the_layers_to_their_rings(self, sides, name, strategy):
        target = paper.place_layers(sides[name], "H").layer(-1)
        placed = place(sides[name], strategy=strategy, target_points=target, residual=True)
        product = placed.basis[placed.ring_nodes] @ placed.coefficients
        shortest = np.linalg.norm(np.diff(placed.rings, axis=1), axis=-1).min()
        np.testing.assert_allclose(product, placed.rings, atol=0.01 * shortest)
        # What is carried inwards fades: nowhere does a mode exceed what it is on the rings.
        modes = np.abs(placed.basis[:, -placed.n_modes :])
        assert placed.n_modes > 0
        assert (modes.max(axis=0) <= 1.01 * modes[placed.ring_nodes].max(axis=0)).all()

    def test_residual_and_smoothing_mend_the_slope(self, name):
        figures = paper.summarise(paper.mesh_with_defaults(*paper.find_sweep(name), size=0.3))
        assert figures["n_inverted"] == 0
        assert figures["worst"] >= 0.2


def test_the_command_prints_every_figure_and_draws(tmp_path, monkeypatch, capsys):
    skip_where_nothing_draws()
    from PIL import Image

    monkeypatch.setattr(paper, "EXAMPLES", {"c_shape": 8})
    monkeypatch.setattr(sys, "argv", ["paper.py", "--json", "--figures", str(tmp_path)])
    paper.main()
    result = json.loads(capsys.readouterr().out)["examples"]["c_shape"]
    assert len(result["layers"]["H"]) == paper.N_LAYERS
    assert result["defaults"]["n_inverted"] == 0
    for picture in ("paper_c_shape.png", "paper_shapes.png"):
        grey = np.asarray(Image.open(tmp_path / picture).convert("L"))
        assert (grey < 200).mean() > 0.02  # something is drawn on the white ground
