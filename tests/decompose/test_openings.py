"""A search that goes on with what one cut leaves comes back to the other cuts of the whole in time."""

from dataclasses import dataclass, replace

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.brep import Solid
from cadsweep.decomposition.curved import (
    MANY_FACES_OF_ALL,
    MOST_BEFORE,
    MOST_FACES_OF_ALL,
    TURN,
    CellSearch,
)
from cadsweep.decomposition.tools import Tools
from cadsweep.errors import PlanError

pytestmark = pytest.mark.cad

LEADS = "leads on and on"


@dataclass(frozen=True, kw_only=True)
class Fill:
    solid: Solid


@dataclass(frozen=True, kw_only=True)
class Cutter:
    reason: str
    leads: bool
    kind: str = "planes"
    family: str = ""
    price: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Parted:
    """A part is its name: the cuts that led to it."""

    part: object
    key: str

    def imprinted(self):
        return replace(self.part, name=self.key)


def search_of(cuts_of_the_whole, wanted, most_openings, shape=None, asked=None):
    """A search where the wanted names have a plan, and some cut always leads further."""

    def find_cutters(part, cell, faces):
        if asked is not None:
            asked.append(part.name)
        first = not part.name.startswith("whole:")
        yield from [Cutter(reason=reason, leads=reason == LEADS) for reason in (cuts_of_the_whole if first else ["a"])]
        if part.name.startswith(f"whole: {LEADS}"):
            yield from [Cutter(reason=f"{LEADS} {j}", leads=True) for j in range(3)]

    def split(part, cell, cutter, others):
        name = part.name if part.name.startswith("whole:") else "whole:"
        return Parted(part=part, key=f"{name} {cutter.reason}")

    def make_plan(part, candidates):
        if part.name not in wanted:
            raise PlanError("it has none", faces=((0, 0),))
        return part.name

    part = load(cq.Workplane().box(1, 1, 1) if shape is None else shape)
    tools = Tools(
        recognise=lambda solid: [Fill(solid=solid)], make_plan=make_plan, find_cutters=find_cutters, split=split
    )
    return CellSearch(part, tools, most_openings=most_openings)


def test_another_first_cut_is_looked_at_after_a_while():
    search = search_of([LEADS, "this one"], {"whole: this one"}, 100)
    assert next(search.solutions()).plan == "whole: this one"
    assert search.n_parts <= 1 + MOST_BEFORE + 1
    late = search_of([LEADS, "this one"], {"whole: this one"}, 0)
    assert next(late.solutions(), None) is None


def test_each_gets_a_turn():
    """The second of them has a plan two cuts on; the first has none, and takes its turn."""
    search = search_of([LEADS, "no", "yes"], {"whole: yes a a"}, 100)
    assert next(search.solutions()).plan == "whole: yes a a"
    assert search.n_parts <= 1 + MOST_BEFORE + 2 + 2 * TURN


def test_what_is_found_soon_is_found_as_without_turns():
    wanted = {f"whole: {LEADS} {LEADS} 0 a"}
    counts = []
    for most_openings in (0, 100):
        search = search_of([LEADS, "no"], wanted, most_openings)
        assert next(search.solutions()).plan in wanted
        counts.append(search.n_parts)
    assert counts[0] == counts[1] <= MOST_BEFORE


def test_turns_take_nothing_from_the_search_itself():
    without, with_turns = (search_of([LEADS, "no"], set(), most) for most in (0, 100))
    assert not [*without.solutions(), *with_turns.solutions()]
    assert with_turns.n_parts > without.n_parts
    assert with_turns.n_parts <= without.n_parts + 100


def perforated(n_rows):
    return (
        cq.Workplane()
        .placeSketch(cq.Sketch().rect(80, 80).rarray(6, 6, n_rows, n_rows).circle(1.5, mode="s"))
        .extrude(2)
    )


def test_a_part_of_many_faces_is_given_up_after_few_looks():
    """A look takes as long as there are faces, so of twice as many there is less than half as much to look at."""
    search = search_of([LEADS, "no"], set(), 100, perforated(12))
    n_faces = len(search.best.part.solids[0].faces)
    assert n_faces > 1.1 * MANY_FACES_OF_ALL
    assert next(search.solutions(), None) is None
    assert search.n_faces <= MOST_FACES_OF_ALL * (MANY_FACES_OF_ALL / n_faces) ** 2 + 2 * n_faces


def test_no_cutters_are_made_where_none_may_be_tried():
    asked = []
    search = search_of([LEADS, "no"], set(), 100, perforated(2), asked=asked)
    search.most_faces = search.most_of_all = 0
    assert next(search.solutions(), None) is None
    assert not asked
