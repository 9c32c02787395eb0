"""A refusal advises what was tried, and says of nothing else that it was."""

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.errors import NotSweepableError
from cadsweep.options import SweepOptions
from cadsweep.pipeline import remedies

pytestmark = pytest.mark.cad


@pytest.mark.parametrize("most_faces", [remedies.MOST_FACES, 3])
def test_what_was_not_tried_is_not_said_to_have_been(most_faces, monkeypatch):
    notched = cs.load(cq.Workplane().box(4, 4, 4).faces(">Z").workplane().rect(1, 1).cutBlind(-2))
    tried = []

    def mesh(part, options, run):
        tried.append(options)
        raise NotSweepableError("nothing fits")

    monkeypatch.setattr(remedies, "MOST_FACES", most_faces)
    refused = NotSweepableError("no sweep", faces=[len(notched.solids[0].faces) - 1])
    said = remedies.proposing(notched, SweepOptions(), refused, mesh)
    assert "leave the feature" in said.try_
    assert ("were tried" in said.try_) == bool(tried) == (most_faces > 3)
