"""Every model: it runs alone, meshes with no option, and is as good as it says."""

import ast
import shutil
from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

MODELS = sorted(
    path for path in Path(__file__).parents[1].joinpath("models").glob("*.py") if "show_object" in path.read_text()
)
DOMED = [path for path in MODELS if "\ndome = " in path.read_text()]


def constants(path):
    """The numbers that a script states at its top level."""
    statements = ast.parse(path.read_text()).body
    return {
        statement.targets[0].id: statement.value.value
        for statement in statements
        if isinstance(statement, ast.Assign)
        and isinstance(statement.targets[0], ast.Name)
        and isinstance(statement.value, ast.Constant)
    }


def source_size(mesh):
    """Middle length of the quads' edges on the source."""
    quads = mesh.structure.quads
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.median(np.linalg.norm(np.subtract(*mesh.points[ends.T]), axis=1))


def volume_error(mesh):
    return abs(mesh.info["quality"].volume / mesh.info["cad_volume"] - 1)


def test_there_are_ten():
    assert len(MODELS) == 10
    assert len(DOMED) == 4


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_model_copied_away_meshes_with_no_option_and_keeps_its_word(path, tmp_path):
    copy = Path(shutil.copy(path, tmp_path))
    mesh = cs.sweep_mesh(copy)
    report = mesh.info["quality"]
    assert report.valid
    assert report.n_inverted == 0
    assert 1e3 <= mesh.n_hexes <= 1e5
    assert report.min_scaled_jacobian >= constants(path)["MIN_SCALED_JACOBIAN"] >= 0.1
    assert volume_error(mesh) < 0.01
    # Facets cut a curved side off by the square of the size: a quarter from one size to its half, were all equal.
    coarse = cs.sweep_mesh(copy, size=2 * source_size(mesh))
    assert volume_error(mesh) < max(0.5 * volume_error(coarse), 1e-6)


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_model_shows_a_sketch_and_takes_parameters(path):
    tree = ast.parse(path.read_text())
    assert "::" in ast.get_docstring(tree)
    assert len(constants(path)) >= 4


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_gallery_shows_a_model_and_what_it_promises(path):
    docs = path.parents[1] / "docs"
    text = (docs / "gallery.md").read_text(encoding="utf-8")
    assert f"**`{path.stem}`** ({constants(path)['MIN_SCALED_JACOBIAN']})" in text
    assert 1_000 < (docs / "images" / f"{path.stem}.png").stat().st_size < 200_000


@pytest.mark.parametrize("path", DOMED, ids=lambda p: p.stem)
def test_a_dome_adds_to_the_volume(path):
    low, high = (cs.load(path, params={"dome": height}).solids[0].volume for height in (0.2, 0.4))
    assert high > low


def test_the_rings_of_the_c_shape_are_its_source_ring_turned():
    mesh = cs.sweep_mesh(MODELS[[p.stem for p in MODELS].index("c_shape")], layers=9)
    n = mesh.structure.n_nodes
    ring = mesh.structure.loops[0]
    layers = mesh.points.reshape(10, n, 3)[:, ring]
    for k in range(10):
        cosine, sine = np.cos(np.pi * k / 9), np.sin(np.pi * k / 9)
        turned = layers[0] @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
        np.testing.assert_allclose(layers[k], turned, atol=1e-12)
