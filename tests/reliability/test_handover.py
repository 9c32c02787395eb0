"""What Python holds, and not only files, can be meshed in a worker."""

import pickle

import pytest

import cadsweep
from cadsweep.errors import InputError

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
from cadsweep.cad.read.handover import make_portable  # noqa: E402

pytestmark = pytest.mark.cad


class Wrapper:
    """As build123d's objects are."""

    def __init__(self, wrapped):
        self.wrapped = wrapped


BOX = cq.Workplane().box(3, 2, 1)


def named_box():
    assembly = cq.Assembly(name="plate").add(BOX, name="steel")
    assembly.objects["steel"].addSubshape(BOX.faces("<X").val(), name="clamped")
    return assembly


SOURCES = {
    "workplane": lambda: BOX,
    "shape": BOX.val,
    "assembly": named_box,
    "raw": lambda: BOX.val().wrapped,
    "wrapped": lambda: Wrapper(BOX.val().wrapped),
}


@pytest.mark.parametrize("kind", SOURCES)
def test_a_source_means_the_same_after_the_journey(kind):
    source = SOURCES[kind]()
    there = pickle.loads(pickle.dumps(make_portable(source)))
    here, again = (cadsweep.sweep_mesh(s, layers=2) for s in (source, there))
    assert here.points.tobytes() == again.points.tobytes()
    assert list(here.boundaries) == list(again.boundaries)


def test_an_assembly_keeps_its_names_in_a_worker():
    assert "steel_clamped" in cadsweep.sweep_mesh(named_box(), layers=2, isolated=True).boundaries


def test_a_loaded_part_stays_where_it_is():
    with pytest.raises(InputError, match="give a file"):
        cadsweep.sweep_mesh(cadsweep.load(BOX), isolated=True)
