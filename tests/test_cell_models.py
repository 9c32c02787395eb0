"""The parts of the gallery that are cut into cells: each meshes with no option, and is as good as it says."""

from pathlib import Path

import pytest

import cadsweep as cs

from .gallery import check_shown, promise

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

MODELS = sorted(Path(__file__).parents[1].joinpath("models", "cells").glob("*.py"))


def test_there_are_four():
    assert len(MODELS) == 4


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_part_is_cut_unasked_and_keeps_its_word(path):
    mesh = cs.sweep_mesh(path)
    report = mesh.info["quality"]
    assert report.valid
    assert report.min_scaled_jacobian >= promise(path) >= 0.1
    assert any(note.startswith("cut ") for note in mesh.info["notes"])
    assert len(mesh.info["sweeps"]) > 1
    assert abs(report.volume / mesh.info["cad_volume"] - 1) < 0.01


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_gallery_shows_a_part_and_what_it_promises(path):
    check_shown(path)
