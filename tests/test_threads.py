"""Work shared by threads: in order, all of it, and what goes wrong comes out as if one thing were done at a time."""

import itertools
import threading

import pytest

from cadsweep import threads
from cadsweep.threads import CHUNK, beside, map_chunks


def test_chunks_come_in_order_and_cover_everything():
    n = 3 * CHUNK + 17
    chunks = list(map_chunks(lambda c: (c.start, c.stop), n))
    assert chunks[0][0] == 0
    assert chunks[-1][1] == n
    assert all(a[1] == b[0] for a, b in itertools.pairwise(chunks))
    assert list(map_chunks(lambda c: c, 0)) == []


def failing(message):
    raise ValueError(message)


def test_work_runs_beside_the_block(monkeypatch):
    monkeypatch.setattr(threads, "n_threads", lambda: 2)
    here, met = threading.Event(), []
    with beside(lambda: here.wait(10.0)) as done:
        here.set()  # were the work done first, it would wait in vain
        met.append(done())
    assert met == [True]


@pytest.mark.parametrize("n", [1, 2])
def test_what_the_work_raises_comes_before_what_the_block_raises(monkeypatch, n):
    monkeypatch.setattr(threads, "n_threads", lambda: n)
    with pytest.raises(ValueError, match="work"), beside(lambda: failing("work")):
        failing("block")
    with pytest.raises(ValueError, match="block"), beside(lambda: 1):
        failing("block")
    with pytest.raises(ValueError, match="work"), beside(lambda: failing("work")):
        pass


def test_little_work_is_done_first():
    with beside(threading.current_thread, pays=False) as done:
        assert done() is threading.current_thread()
