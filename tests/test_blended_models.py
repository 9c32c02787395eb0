"""The blended parts of the gallery: each meshes with no option by its design, and is as good as it says."""

from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs

from .gallery import check_shown, promise

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

MODELS = sorted(Path(__file__).parents[1].joinpath("models", "blended").glob("*.py"))


def test_there_are_two():
    assert len(MODELS) == 2


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_step_file_is_meshed_by_its_design_unasked_and_keeps_its_word(path):
    mesh = cs.sweep_mesh(path.with_suffix(".step"))
    report = mesh.info["quality"]
    assert report.valid
    assert report.min_scaled_jacobian >= promise(path) >= 0.1
    assert "way: design" in mesh.info["rows"]
    assert abs(report.volume / mesh.info["cad_volume"] - 1) < 0.01
    # Every face of the file has quads under a name of its own, a hole's two halves one; the skin is covered once.
    keys = {face.key for face in cs.load(path.with_suffix(".step")).solids[0].faces}
    assert len(mesh.boundaries) == len(keys)
    quads = np.sort(np.concatenate(list(mesh.boundaries.values())), axis=1)
    assert len(np.unique(quads, axis=0)) == len(quads)


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_script_makes_what_the_file_has(path):
    script, file = cs.load(path), cs.load(path.with_suffix(".step"))
    volumes = [part.solids[0].volume * part.scale**3 for part in (script, file)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-9)
    assert len(script.solids[0].faces) == len(file.solids[0].faces)


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_gallery_shows_a_part_and_what_it_promises(path):
    check_shown(path)
