"""Sizes larger than a part's features: narrow places are divided finer, and nothing else is."""

import pytest

import cadsweep as cs

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

pytestmark = pytest.mark.cad

WIDE, TALL, FLANGE, WEB = 20.0, 20.0, 4.0, 6.0


@pytest.fixture(scope="module")
def beam():
    """An H section, its web and flanges narrower than half of its width."""
    return cs.load(
        cq.Workplane()
        .rect(WIDE, TALL)
        .extrude(30)
        .cut(cq.Workplane().pushPoints([(-WIDE / 2, 0), (WIDE / 2, 0)]).rect(WIDE - WEB, TALL - 2 * FLANGE).extrude(30))
    )


def finer(mesh):
    """What the notes say of narrow places."""
    return [note for note in mesh.info["notes"] if "narrow" in note]


@pytest.mark.parametrize("size", [8.0, WIDE, 30.0])
def test_a_size_larger_than_the_features_meshes(beam, size):
    mesh = cs.sweep_mesh(beam, size=size)
    report = mesh.info["quality"]
    assert report.valid
    assert report.volume == pytest.approx(mesh.info["cad_volume"], rel=1e-9)


def test_what_was_divided_finer_is_said(beam):
    assert finer(cs.sweep_mesh(beam, size=WIDE))
    assert not finer(cs.sweep_mesh(beam, size=2.0))


def test_the_layers_stay_as_asked(beam):
    assert cs.sweep_mesh(beam, size=WIDE, layers=2).info["sweeps"][0]["layers"] == 2
