"""Several candidate sweeps: the same mesh, notes and refusal in memory, slab by slab, on ranks and from factors."""

from dataclasses import replace

import pytest

import cadsweep as cs
from cadsweep.options import SweepOptions
from cadsweep.pipeline import candidates, expand, write_factors
from cadsweep.pipeline.routes import _make_cell
from cadsweep.pipeline.run import make_run

from .pipeline_ranks import distributed, same

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

OPTIONS = {"source": 0, "size": 1.0}


@pytest.fixture(scope="module")
def duct():
    """A duct of revolution with a U for its section: the best ranked sweep from its inner end turns inside out."""
    profile = [(1, 0), (2, 0), (2, 6), (13**0.5, 6), (13**0.5, 0), (4, 0), (4, 8), (1, 8)]
    return cs.load(cq.Workplane().polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0)))


@pytest.mark.parametrize("good_enough", [candidates.GOOD_ENOUGH, 0.99], ids=["first_that_does_well", "best_of_all"])
def test_all_ways_give_one_mesh_and_its_notes_where_the_first_candidate_fails(duct, good_enough, tmp_path, monkeypatch):
    monkeypatch.setattr(candidates, "GOOD_ENOUGH", good_enough)
    mesh = cs.sweep_mesh(duct, **OPTIONS)
    assert any("a better ranked sweep was given up: no valid mesh" in note for note in mesh.info["notes"])
    streamed = cs.stream_mesh(duct, tmp_path / "stream.vtkhdf", **OPTIONS)
    ranks = distributed(duct, tmp_path / "ranks.vtkhdf", **OPTIONS)
    factored = write_factors(duct, tmp_path / "p.sweep.npz", **OPTIONS)
    assert same(expand(tmp_path / "p.sweep.npz"), mesh)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), mesh)
    assert same(factored, mesh)
    assert sorted(tmp_path.glob("*")) == sorted(tmp_path / n for n in ("p.sweep.npz", "ranks.vtkhdf", "stream.vtkhdf"))
    report = mesh.info["quality"]
    for figures in (streamed, *ranks):
        assert figures["notes"] == mesh.info["notes"]
        assert figures["sweeps"] == mesh.info["sweeps"]
        assert figures["n_hexes"] == report.n_hexes
        assert figures["min_scaled_jacobian"] == report.min_scaled_jacobian
    assert factored.info["notes"] == mesh.info["notes"]


def test_all_ways_refuse_alike(duct, tmp_path, monkeypatch):
    monkeypatch.setattr(candidates, "MOST_CANDIDATES", 1)
    with pytest.raises(cs.InvertedHexError) as memory:
        cs.sweep_mesh(duct, **OPTIONS)
    with pytest.raises(cs.InvertedHexError) as streamed:
        cs.stream_mesh(duct, tmp_path / "stream.vtkhdf", **OPTIONS)
    ranks = distributed(duct, tmp_path / "ranks.pvtu", **OPTIONS)
    for error in (streamed.value, *ranks):
        assert str(error) == str(memory.value)
        assert error.hexes == memory.value.hexes
    assert not list(tmp_path.iterdir())


def test_wishes_that_cannot_be_had_are_refused_alike(duct, tmp_path):
    wish = {"counts": {"no such edge": 3}}
    with pytest.raises(cs.InputError) as memory:
        cs.sweep_mesh(duct, **OPTIONS, **wish)
    with pytest.raises(cs.InputError) as streamed:
        cs.stream_mesh(duct, tmp_path / "stream.vtkhdf", **OPTIONS, **wish)
    errors = distributed(duct, tmp_path / "ranks.vtkhdf", **OPTIONS, **wish)
    assert {str(error) for error in (streamed.value, *errors)} == {str(memory.value)}


@pytest.mark.parametrize(("wish", "taken"), [({}, 1), ({"layers": 2}, 0)], ids=["the_nearest", "what_was_asked_for"])
def test_a_sweep_that_stays_too_far_off_gives_way_unless_wishes_keep_it(wish, taken):
    part = cs.load(cq.Workplane().box(3, 4, 5))
    sweeps = cs.find_sweeps(part)[:2]
    options = SweepOptions(tolerance=0.1, size=1.0, **wish)

    def make(part, sweep, options, run):
        return replace(_make_cell(part, sweep, options, run), shortfall=0.5 if sweep is sweeps[1] else 2.0)

    best = candidates.first_good(part, sweeps, options, make_run(None, None), make)
    assert best.mesh.info["sweeps"][0]["source"] == list(sweeps[taken].source)
    assert any("passed over" in note for note in best.mesh.info["notes"]) == bool(taken)
