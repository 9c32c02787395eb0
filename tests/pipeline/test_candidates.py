"""Several candidate sweeps: the same mesh, notes and refusal in memory, slab by slab, on ranks and from factors."""

import threading

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline import candidates, expand, write_factors
from cadsweep.pipeline.ranks import mesh_distributed

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

OPTIONS = {"source": 0, "size": 1.0}


class ThreadComm:
    """Ranks as threads, for what ``mesh_distributed`` asks of a communicator."""

    def __init__(self, size):
        self.size, self._own = size, threading.local()
        self._barrier, self._slots, self._mail = threading.Barrier(size, timeout=120), [None] * size, {}
        self._came = threading.Condition()

    @property
    def rank(self):
        return self._own.rank

    def run(self, work):
        """Results, or errors, of all ranks."""
        out = [None] * self.size

        def start(rank):
            self._own.rank = rank
            try:
                out[rank] = work()
            except cs.CadSweepError as error:
                out[rank] = error

        threads = [threading.Thread(target=start, args=(rank,)) for rank in range(self.size)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=300)
        return out

    def barrier(self):
        self._barrier.wait()

    def allgather(self, value):
        self._slots[self.rank] = value
        self._barrier.wait()
        found = list(self._slots)
        self._barrier.wait()
        return found

    def bcast(self, value, root):
        return self.allgather(value)[root]

    def gather(self, value, root):
        return self.allgather(value)

    def send(self, value, dest, tag):
        with self._came:
            self._mail[self.rank, dest, tag] = value
            self._came.notify_all()

    def recv(self, source, tag):
        with self._came:
            self._came.wait_for(lambda: (source, self.rank, tag) in self._mail, timeout=120)
            return self._mail.pop((source, self.rank, tag))


@pytest.fixture(scope="module")
def duct():
    """A duct of revolution with a U for its section: the best ranked sweep from its inner end turns inside out."""
    profile = [(1, 0), (2, 0), (2, 6), (13**0.5, 6), (13**0.5, 0), (4, 0), (4, 8), (1, 8)]
    return cs.load(cq.Workplane().polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0)))


def distributed(part, path, **options):
    comm = ThreadComm(2)
    return comm.run(lambda: mesh_distributed(part, path, comm=comm, **options))


def same(a, b):
    return (
        np.array_equal(a.points, b.points)
        and np.array_equal(a.hexes, b.hexes)
        and a.boundaries.keys() == b.boundaries.keys()
        and all(np.array_equal(a.boundaries[name], b.boundaries[name]) for name in a.boundaries)
    )


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
