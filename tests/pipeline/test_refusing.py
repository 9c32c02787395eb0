"""A mesh that runs into itself is not handed over, and the refusal says whether the model does."""

from __future__ import annotations

import math

import pytest

import cadsweep as cs
from cadsweep import decomposition

pytestmark = pytest.mark.cad


def coil(pitch, turns=1.4, side=1.0):
    """A square bar wound about the z axis."""
    import cadquery as cq

    path = cq.Wire.makeHelix(pitch, turns * pitch, 4)
    return cq.Workplane("XZ").center(4, 0).rect(side, side).sweep(cq.Workplane(path), isFrenet=True)


def test_a_coil_whose_turns_meet_is_refused_as_a_model():
    with pytest.raises(cs.CadError, match="model runs into itself"):
        cs.sweep_mesh(coil(0.8), size=0.4)


def test_streamed_too(tmp_path):
    from cadsweep.pipeline import stream_mesh

    with pytest.raises(cs.CadError, match="model runs into itself"):
        stream_mesh(coil(0.8), tmp_path / "coil.vtkhdf", size=0.4)
    assert not list(tmp_path.iterdir())


def scroll(gap):
    """A strip of thickness 0.5 rolled up to 1.6 turns, with a gap between them."""
    import cadquery as cq

    def spiral(start):
        return lambda t: (
            (start + (0.5 + gap) * t) * math.cos(2 * math.pi * t),
            (start + (0.5 + gap) * t) * math.sin(2 * math.pi * t),
        )

    def edge(start):
        return cq.Workplane().parametricCurve(spiral(start), start=0, stop=1.6, N=100, makeWire=False).val()

    inner, outer = edge(2.0), edge(2.5)
    ends = [cq.Edge.makeLine(getattr(inner, at)(), getattr(outer, at)()) for at in ("startPoint", "endPoint")]
    return cq.Solid.extrudeLinear(cq.Wire.assembleEdges([inner, ends[1], outer, ends[0]]), [], cq.Vector(0, 0, 1))


def test_facets_that_cross_where_the_model_does_not_ask_for_a_smaller_size():
    # Chords of length 1 lie 1 / (8 * 2.5) = 0.05 off an arc of radius 2.5, more than the gap.
    with pytest.raises(cs.InvertedHexError, match=r"(?s)runs into itself.*keep apart.*smaller size"):
        cs.sweep_mesh(scroll(0.01), size=1.0)
    assert cs.sweep_mesh(scroll(0.01), size=0.25, layers=1).quality().valid


def test_cells_divide_the_chords_that_cross_but_not_below_a_size_that_is_named_alone():
    with pytest.raises(cs.InvertedHexError, match="runs into itself") as refused:
        cs.sweep_mesh(scroll(0.03), cuts=["plane z=0.5"], size=1.0)
    assert refused.value.crossing
    mesh = cs.sweep_mesh(scroll(0.03), cuts=["plane z=0.5"], size=1.0, tolerance=0.2)
    assert mesh.quality().valid
    assert any("divided finer where quads of the boundary crossed" in note for note in mesh.info["notes"])


def test_a_solid_that_touches_itself_along_an_edge_is_no_planar_complex(tmp_path):
    import cadquery as cq
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.gp import gp_Pln

    outline = [(0, 0), (10, 0), (10, 10), (10, 25), (10, 10), (0, 10)]
    flag = cq.Wire.makePolygon([cq.Vector(x, y, 0) for x, y in outline], close=True)
    face = cq.Face(BRepBuilderAPI_MakeFace(gp_Pln(), flag.wrapped).Face())
    folded = cq.Solid.extrudeLinear(face, cq.Vector(0, 0, 8))
    path = tmp_path / "folded.step"  # which has two edges where the solid has one
    cq.exporters.export(cq.Workplane(folded), str(path))
    (solid,) = cs.load(path).solids
    assert not decomposition.is_planar(solid)
    assert decomposition.is_planar(cs.load(cq.Workplane().box(1, 2, 3)).solids[0])
    with pytest.raises(cs.CadError, match="runs into itself"):
        cs.sweep_mesh(path)
