"""Imports are not searched for garbage, and nothing else changes."""

import gc
import weakref

import pytest

from cadsweep.collector import collector_resting


class Ring:
    """An object that holds itself."""

    def __init__(self):
        self.self = self


@pytest.fixture
def looks():
    """The generations that the collector has looked through."""
    found = []

    def note(phase, info):
        if phase == "start":
            found.append(info["generation"])

    gc.callbacks.append(note)
    yield found
    gc.callbacks.remove(note)


def test_what_is_made_in_the_block_is_neither_searched_there_nor_afterwards(looks):
    with collector_resting():
        made = [[] for _ in range(20 * gc.get_threshold()[0])]
    after = [[] for _ in range(gc.get_threshold()[0] // 2)]
    assert not looks
    assert gc.isenabled()
    assert len(made) > len(after)


def test_garbage_of_the_block_goes_with_the_next_full_look():
    with collector_resting():
        ring = weakref.ref(Ring())
    assert ring() is not None
    gc.collect()
    assert ring() is None


def test_objects_set_aside_stay_there_and_a_stopped_collector_stays_stopped():
    gc.freeze()
    try:
        count = gc.get_freeze_count()
        with collector_resting():
            pass
        assert gc.get_freeze_count() == pytest.approx(count, abs=50)
    finally:
        gc.unfreeze()
    gc.disable()
    try:
        with collector_resting():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
