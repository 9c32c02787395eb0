"""The user's time ends the search for cuts, and takes nothing away of what was found."""

from dataclasses import replace

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

from cadsweep import NotSweepableError, load, sweep_mesh
from cadsweep.decomposition.search import Search
from cadsweep.options import SweepOptions
from cadsweep.pipeline.routes import mesh_solid
from cadsweep.pipeline.run import SEARCH, SECONDS, make_run
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad


def test_time_counts_in_the_stage_alone():
    run = make_run(None, 1e-9)
    assert not run.is_late()
    with run.stage("cad"):
        assert not run.is_late()
    with run.stage("decomposition"):
        assert run.is_late()
    assert run.is_late()
    assert not make_run(None, None).is_late()


def test_a_run_has_its_time_and_more_where_cuts_are_given_more():
    assert (make_run(None, None).total, make_run(None, None).decompose_time) == (SECONDS, SEARCH)
    assert make_run(None, SEARCH + 100.0).total == SECONDS + 100.0
    over = replace(make_run(None, None), total=-1.0)
    assert over.is_over()
    assert over.is_late()
    assert not replace(over, total=SECONDS).is_over()


def test_a_share_is_of_the_time_that_is_left_and_what_it_takes_is_taken_from_the_rest():
    run = make_run(None, 10.0)
    half = run.for_share(0.5)
    assert half.decompose_time == 5.0
    half._searched.append(4.0)
    assert not half.is_late()
    assert run.for_share(0.5).decompose_time == 4.0 + 0.5 * 6.0
    half._searched.append(2.0)
    assert half.is_late()
    assert not run.is_late()
    half._searched.append(9.0)
    assert run.for_share(0.5).decompose_time == 15.0
    assert run.is_late()


def test_a_run_without_time_takes_the_first_that_it_finds():
    """Of a part that sweeps poorly, nothing but the first sweep is tried; there is a mesh all the same."""
    part = cq.Workplane().box(20, 20, 4)
    options = SweepOptions(size=2.0)
    mesh = mesh_solid(load(part), options, replace(make_run(None, None), total=-1.0))
    assert mesh.n_hexes == 10 * 10 * 2


def block(bored):
    part = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().circle(4).cutBlind(-6)
    part = part.faces(">X").workplane(centerOption="CenterOfMass")
    return part.circle(3).cutBlind(-4) if bored else cq.Workplane().box(20, 20, 20).cut(cq.Workplane().box(8, 8, 8))


def test_a_search_without_time_says_so():
    with pytest.raises(NotSweepableError, match="ended by decompose_time"):
        sweep_mesh(block(True), decompose_time=1e-9, fitted=False)


def test_a_search_for_planes_ends_too():
    search = Search(
        model=load(block(False)).solids[0], recognise=lambda solid: [], make_plan=make_plan, is_late=lambda: True
    )
    assert list(search.solutions()) == []
    assert search.ended_early
    assert search.n_states == 1
