"""Ranks as threads, and when two meshes are the same."""

import threading

import numpy as np

import cadsweep as cs
from cadsweep.pipeline.ranks import mesh_distributed


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


def distributed(part, path, *, n_ranks=2, **options):
    """What every rank gives back, or its error."""
    comm = ThreadComm(n_ranks)
    return comm.run(lambda: mesh_distributed(part, path, comm=comm, **options))


def same(a, b):
    """Whether all arrays of two meshes are equal, bit for bit."""
    return (
        np.array_equal(a.points, b.points)
        and np.array_equal(a.hexes, b.hexes)
        and all(
            getattr(a, kind).keys() == getattr(b, kind).keys()
            and all(np.array_equal(own, getattr(b, kind)[name]) for name, own in getattr(a, kind).items())
            for kind in ("boundaries", "interfaces", "parts")
        )
    )
