"""The assemblies of the gallery: each meshes with no option, as one conformal mesh, and is as good as it says."""

import ast
from pathlib import Path

import pytest

import cadsweep as cs

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

MODELS = sorted(Path(__file__).parents[1].joinpath("models", "assemblies").glob("*.py"))

PARTS = {
    "bolted_flanges": {"lower", "gasket", "upper", "bolt_1", "bolt_2", "bolt_3", "bolt_4"},
    "fuel_pin": {"pellet_1", "pellet_2", "pellet_3", "gap", "clad"},
    "sandwich_panel": {"lower_skin", "core", "upper_skin", "insert"},
}
CONTACTS = {
    # Each plate touches the next and all four bolts.
    "bolted_flanges": 2 + 3 * 4,
    # Pellets touch each other and the gap, the gap the cladding.
    "fuel_pin": 2 + 3 + 1,
    # The core touches both skins, and the insert all three layers.
    "sandwich_panel": 2 + 3,
}


def promise(path):
    """The worst scaled Jacobian that a script states."""
    (value,) = (
        statement.value.value
        for statement in ast.parse(path.read_text()).body
        if isinstance(statement, ast.Assign) and statement.targets[0].id == "MIN_SCALED_JACOBIAN"
    )
    return value


def test_every_assembly_is_told_of():
    assert {path.stem for path in MODELS} == set(PARTS)


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_an_assembly_meshes_with_no_option_and_keeps_its_word(path):
    mesh = cs.sweep_mesh(path)
    report = mesh.info["quality"]
    assert report.valid
    assert report.min_scaled_jacobian >= promise(path)
    assert set(mesh.parts) == PARTS[path.stem]
    assert len(mesh.interfaces) == CONTACTS[path.stem]
    assert abs(report.volume / mesh.info["cad_volume"] - 1) < 0.005


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_gallery_shows_an_assembly_and_what_it_promises(path):
    docs = path.parents[2] / "docs"
    assert f"**`{path.stem}`** ({promise(path)})" in (docs / "gallery.md").read_text(encoding="utf-8")
    assert 1_000 < (docs / "images" / f"{path.stem}.png").stat().st_size < 200_000
