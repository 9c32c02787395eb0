"""The tight box about a part: as OpenCASCADE finds it, asked of the faces that reach outermost alone."""

import numpy as np
import pytest

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from OCP.Bnd import Bnd_Box  # noqa: E402
from OCP.BRepBndLib import BRepBndLib  # noqa: E402

from cadsweep.cad.extract import extent  # noqa: E402
from cadsweep.cad.extract.extent import tight_bounds  # noqa: E402
from cadsweep.cad.shapes import FACE, subshapes  # noqa: E402

from .cad_zoo import zoo  # noqa: E402

ZOO = zoo()


def of_whole(shape):
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    return np.array(box.Get()).reshape(2, 3)


@pytest.mark.parametrize("name", ["box", "fillets", "half_torus", "dome", "bent_pipe", "twist", "wedge", "oval_ring"])
def test_the_box_is_that_of_all_faces_together(name):
    shape = ZOO[name].rotate((0, 0, 0), (1, 2, 3), 40).val().wrapped
    # OpenCASCADE adds its tolerance of 1e-7 to what it searches for.
    assert tight_bounds(shape) == pytest.approx(of_whole(shape), abs=5e-7)


def test_a_turned_ring_reaches_as_far_as_its_formula_says():
    ring = cq.Workplane(cq.Solid.makeTorus(3, 1, dir=cq.Vector(1, 2, 2))).val().wrapped
    reach = 3 * np.sqrt(1 - np.array([1, 2, 2]) ** 2 / 9) + 1
    assert tight_bounds(ring) == pytest.approx(np.array([-reach, reach]), abs=5e-7)


def test_faces_within_the_others_are_not_searched(monkeypatch):
    asked = []
    monkeypatch.setattr(extent, "_optimal", lambda shape: asked.append(shape) or of_whole(shape))
    rounded = cq.Workplane().box(4, 4, 2).edges("|Z").fillet(0.5).faces(">Z").edges().fillet(0.2).val().wrapped
    assert tight_bounds(rounded) == pytest.approx(np.array([[-2, -2, -1], [2, 2, 1]]), abs=5e-7)
    assert len(asked) == 1  # all planes and cylinders at once; none of the four rings at the corners


def test_edges_where_cylinders_meet_are_not_searched_inside_of_a_block(monkeypatch):
    block = cq.Workplane().box(6, 6, 6)
    for plane in ("XY", "YZ"):
        block = block.cut(cq.Workplane(plane).circle(1 if plane == "XY" else 1.5).extrude(9, both=True))
    shape = block.rotate((0, 0, 0), (1, 2, 3), 40).val().wrapped
    asked = []
    monkeypatch.setattr(extent, "_optimal", lambda shape: asked.append(shape) or of_whole(shape))
    assert tight_bounds(shape) == pytest.approx(of_whole(shape), abs=5e-7)
    assert len(asked) == 1


def test_faces_of_a_rounded_end_are_not_searched(monkeypatch):
    asked = []
    monkeypatch.setattr(extent, "_optimal", lambda shape: asked.append(shape) or of_whole(shape))
    drum = cq.Workplane().circle(3).extrude(5).edges().fillet(1).rotate((0, 0, 0), (1, 0, 0), 30)
    assert tight_bounds(drum.val().wrapped) == pytest.approx(of_whole(drum.val().wrapped), abs=5e-7)
    assert not any(subshapes(shape, FACE) for shape in asked)  # edges alone


def test_a_ring_with_a_hole_in_it_is_searched():
    """The hole takes its outermost place."""
    ring = cq.Workplane().circle(1).revolve(360, (-3, 0), (-3, 1)).translate((3, 0, 0))
    cut = ring.cut(cq.Workplane("YZ").circle(0.5).extrude(9))
    assert tight_bounds(cut.val().wrapped) == pytest.approx(of_whole(cut.val().wrapped), abs=5e-7)
    assert tight_bounds(cut.val().wrapped)[1, 0] < 4 - 1e-3
