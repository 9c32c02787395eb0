"""Poisson's equation in dolfinx on small meshes; ``scripts/check_dolfinx.py`` does the same for every model."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

from ..io.io_meshes import bent_box, twisted_box  # noqa: E402

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def dolfinx():
    spec = importlib.util.spec_from_file_location("check_dolfinx", ROOT / "scripts" / "check_dolfinx.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if module.find_dolfinx() is None:
        pytest.skip("dolfinx is missing: apt-get install python3-dolfinx")
    return module


@pytest.mark.parametrize("make", [twisted_box, lambda: bent_box(27)], ids=["twisted", "bent, order 2"])
def test_a_linear_field_is_solved_exactly(dolfinx, tmp_path, make):
    mesh = make()
    del mesh.boundaries["walls"]  # a facet has one tag there
    assert dolfinx.check(mesh, tmp_path) == []


def test_the_check_can_fail(dolfinx, tmp_path):
    mesh = twisted_box()
    del mesh.boundaries["walls"]
    mesh.boundaries["side_1"] = mesh.boundaries["side_1"][1:]  # a facet without its flux
    assert any("off by" in complaint for complaint in dolfinx.check(mesh, tmp_path))
