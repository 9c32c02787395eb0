"""What is expected of a mesh, told before it is made, is what is made; what is not known is not told as if it were."""

import math

import pytest

import cadsweep as cs
from cadsweep.errors import InputError
from cadsweep.pipeline import expecting
from cadsweep.pipeline.expecting import expect

pytestmark = pytest.mark.cad


@pytest.fixture(autouse=True)
def _all_the_time_there_is(monkeypatch):
    monkeypatch.setattr(expecting, "SECONDS", math.inf)


@pytest.mark.parametrize(
    ("source", "options"),
    [
        ("models/elbow.step", {}),  # a sweep that is divided finer than at first, for the sake of its shape
        ("models/elbow.step", {"wall_layers": {"bore": cs.WallLayers(first=0.2, growth=1.2, n=4)}, "size": 3.0}),
        ("models/flanges.step", {}),  # an assembly, some of whose solids touch
        ("models/bracket.step", {"size": 3.0}),  # cells between cuts
        ("models/block.step", {"size": 8.0}),  # columns
        ("models/elbow.step", {"size": 6.0, "refine": 1, "names": {"one": "face 1"}}),
    ],
)
def test_what_is_expected_is_made(source, options):
    expected = expect(source, **options)
    assert not expected.is_least
    assert expected.estimate.n_hexes == cs.sweep_mesh(source, **options).n_hexes


def test_quads_that_are_too_many_to_be_made_are_told_by_areas(monkeypatch):
    monkeypatch.setattr(expecting, "MOST_QUADS", 100)
    made = cs.sweep_mesh("models/elbow.step", size=1.0).n_hexes
    expected = expect("models/elbow.step", size=1.0)
    assert not expected.is_least
    assert 0.7 < expected.estimate.n_hexes / made < 1.3
    assert expect("models/elbow.step").is_least  # accuracy may ask for more


def test_what_takes_too_long_to_know_is_said_to_be_unknown(monkeypatch):
    monkeypatch.setattr(expecting, "SECONDS", -1.0)
    assert "unknown" in str(expect("models/bracket.step"))
    told = expect("models/bracket.step", size=3.0)
    assert "before the cuts" in str(told)
    assert 0.7 < told.estimate.n_hexes / cs.sweep_mesh("models/bracket.step", size=3.0).n_hexes < 1.5


@pytest.mark.parametrize("options", [{"sizes": {"nowhere": 1.0}}, {"max_hexes": 10}, {"counts": {"face 0": 3}}])
def test_what_cannot_be_had_is_refused(options):
    with pytest.raises(InputError):
        expect("models/elbow.step", **options)
