"""Random machined parts with features in several directions: a few of those that benchmarks/parts.py runs whole."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadsweep as cs
from cadsweep.cad import find_touching

pytestmark = pytest.mark.cad

_PATH = Path(__file__).parents[2] / "benchmarks" / "machined.py"
_SPEC = importlib.util.spec_from_file_location("machined", _PATH)
machined = importlib.util.module_from_spec(_SPEC)
sys.modules["machined"] = machined  # its dataclasses look their module up
_SPEC.loader.exec_module(machined)


@pytest.mark.parametrize(
    ("seed", "size"),
    [
        (58, 8.0),  # a block with a slot in one side and a large bore in another
        (91, 7.0),  # a stepped shaft with a blind hole and a chamfer
        (97, 8.0),  # two collars on a shaft with a blind hole
    ],
)
def test_a_random_machined_part_is_meshed_with_all_of_its_faces(seed, size):
    part = machined.machined(seed)
    mesh = cs.sweep_mesh(part, size=size)
    report = mesh.quality()
    assert report.valid, report.problems
    assert report.volume == pytest.approx(part.val().Volume(), rel=0.05)  # holes of few segments are smaller
    # No face is left out, however small, and nothing but faces is in the boundaries.
    assert len(mesh.boundaries) == len(part.faces().vals())
    quads = np.concatenate(list(mesh.boundaries.values()))
    diagonals = mesh.points[quads[:, 2:]] - mesh.points[quads[:, :2]]
    area = np.linalg.norm(np.cross(*diagonals.swapaxes(0, 1)), axis=1).sum() / 2
    assert area == pytest.approx(part.val().Area(), rel=0.05)


def test_faces_whose_distance_cannot_be_found_are_not_said_to_touch():
    """OpenCASCADE gives up on a torus and the flat beside it here; the others are still looked at."""
    assert find_touching(cs.load(machined.machined(27)).solids[0]) is None


def test_an_edge_that_healing_left_out_does_not_stop_what_follows():
    """Three bores that cross leave an edge of no length, and pieces of one cylinder that have to be told apart."""
    drawn = machined.machined(66)
    part = cs.load(drawn)
    assert part.solids[0].volume * part.scale**3 == pytest.approx(drawn.val().Volume())
