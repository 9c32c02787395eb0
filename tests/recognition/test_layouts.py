"""Bands are laid out once for what divides a cap, however many bosses and pockets do."""

from __future__ import annotations

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.recognition import layout, search_sweeps


def studded(n: int) -> cq.Workplane:
    """A plate with n x n square studs above, as many blind pockets below, and n at a side: no sweep."""
    at = [10.0 * (i - (n - 1) / 2) for i in range(n)]
    places = [(x, y) for x in at for y in at]
    plate = cq.Workplane().box(10 * n, 10 * n, 10)
    plate = plate.faces(">Z").workplane().pushPoints(places).rect(3, 3).extrude(4)
    plate = plate.faces("<Z").workplane().pushPoints(places).rect(2, 4).cutBlind(-3)
    return plate.faces(">X").workplane().pushPoints([(y, 0) for y in at]).rect(3, 2).cutBlind(-2)


def test_as_many_layouts_are_tried_for_a_plate_of_few_studs_as_for_one_of_many(monkeypatch: pytest.MonkeyPatch):
    laid: list[int] = []
    init = layout._Graph.__init__
    monkeypatch.setattr(
        layout._Graph, "__init__", lambda self, solid, bands: laid.append(len(bands)) or init(self, solid, bands)
    )
    counts = []
    for n in (2, 5):
        laid.clear()
        assert not search_sweeps(load(studded(n)).solids[0]).sweeps
        counts.append(len(laid))
    assert counts[1] <= counts[0] + 2
    assert counts[1] < 2 * 5 * 5
