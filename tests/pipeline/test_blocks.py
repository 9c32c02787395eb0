"""Meshes of several blocks: the same in memory, slab by slab, as factors and on ranks."""

import runpy
from pathlib import Path

import h5py
import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep.blocks import slabs
from cadsweep.pipeline import expand, write_factors
from cadsweep.pipeline.finished.template_files import save_template

from .pipeline_ranks import distributed, same
from .test_assemblies import assembly, block, pin_in_plate, two_plates

pytestmark = pytest.mark.cad

C_SHAPE = runpy.run_path(str(Path(__file__).parents[2] / "models" / "c_shape.py"), {"show_object": lambda *_, **__: 0})[
    "result"
]
DECOMPOSED = Path(__file__).parents[1] / "parts" / "decomposed"


def two_boxes():
    """Two boxes with a face in common, of one solid's names."""
    return assembly(left=block(2, 2, 1), right=block(1, 2, 1, (2, 0, 0)))


def pin_beside_a_ball():
    """Solids that touch, one of corner blocks, one that touches nothing, and one that is columns."""
    bore = cq.Workplane("XZ").circle(0.3).extrude(-4).translate((2, 0, 0.5))
    columns = block(4, 4, 2).cut(block(2, 2, 1, (1, 1, 1))).cut(bore).translate((20, 0, 0))
    return assembly(low=block(4, 4, 1), ball=cq.Workplane().sphere(1.0).translate((9, 0, 0)), columns=columns)


def octahedron():
    """A solid that is cut in four cells."""
    return str(DECOMPOSED / "octahedron.py")


def far(whole):
    """Far from the origin, where coordinates are shifted on the way in and back on the way out."""
    return cq.Assembly(name="far").add(whole, loc=cq.Location((1e5, 2e5, 0)))


CASES = {
    "two_boxes": (two_boxes, {"size": 0.5}),
    "far_away": (lambda: far(two_plates()), {"size": 2.0}),
    "pin": (pin_in_plate, {"size": 2.0, "allow_coarse": True}),
    "all_kinds": (pin_beside_a_ball, {"size": 0.4, "allow_coarse": True}),
    "separate": (two_plates, {"size": 2.0, "interfaces": "separate"}),
    "decomposed": (octahedron, {"size": 2.0}),
}

SUFFIX = dict.fromkeys(("two_boxes", "pin", "separate"), ".vtkhdf")
SUFFIX |= dict.fromkeys(("far_away", "all_kinds", "decomposed"), ".pvtu")


def read_as_written(mesh, path):
    mesh.write(path)
    return cs.read(path)


def arrays_of(path):
    """All arrays of a VTKHDF file, by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[:]} if isinstance(item, h5py.Dataset) else {}))
    return found


@pytest.mark.parametrize("case", CASES)
def test_blocks_give_the_joined_mesh_bit_for_bit(case, tmp_path, monkeypatch):
    make, options = CASES[case]
    part = cs.load(make())
    mesh = cs.sweep_mesh(part, **options)
    assert len(mesh.info["sweeps"]) > 1
    written = read_as_written(mesh, tmp_path / "memory.vtkhdf")
    monkeypatch.setattr(slabs, "SLAB_NODES", 150)  # several slabs a block
    figures = cs.stream_mesh(part, tmp_path / "stream.vtkhdf", **options)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), written)
    memory, streamed = arrays_of(tmp_path / "memory.vtkhdf"), arrays_of(tmp_path / "stream.vtkhdf")
    assert memory.keys() == streamed.keys()
    assert all(np.array_equal(memory[name], streamed[name]) for name in memory)
    report = mesh.info["quality"]
    ranks = distributed(part, tmp_path / f"ranks{SUFFIX[case]}", n_ranks=3, **options)
    assert same(cs.read(tmp_path / f"ranks{SUFFIX[case]}"), written)
    for told in (figures, *ranks):
        assert told["notes"] == mesh.info["notes"]
        assert told["sweeps"] == mesh.info["sweeps"]
        assert told["parts"] == {name: len(ids) for name, ids in mesh.parts.items()}
        assert told["interfaces"] == {name: len(quads) for name, quads in mesh.interfaces.items()}
        assert told["min_scaled_jacobian"] == report.min_scaled_jacobian
        assert told["volume"] == pytest.approx(report.volume, rel=1e-12)


def test_factors_of_blocks_are_the_mesh_that_is_streamed(tmp_path):
    part = cs.load(two_boxes())
    mesh = write_factors(part, tmp_path / "p.sweep.npz", size=0.5)
    cs.stream_mesh(part, tmp_path / "stream.vtkhdf", size=0.5)
    assert same(expand(tmp_path / "p.sweep.npz"), mesh)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), mesh)


def test_blocks_that_need_smoothing_are_mended_alike(tmp_path):
    # On the C-shape the functional G shears the domed layers until they turn inside out.
    whole = cq.Assembly(name="whole").add(C_SHAPE, name="c")
    whole.add(cq.Workplane(origin=(-3, 0, 0)).circle(1).extrude(1), name="foot")
    part = cs.load(whole)
    options = {
        "layers": 9,
        "size": 0.5,
        "functional": "G",
        "strategy": "source",
        "residual": False,
        "allow_coarse": True,
    }
    with pytest.raises(cs.InvertedHexError) as memory:
        cs.sweep_mesh(part, **options, smoothing=False)
    with pytest.raises(cs.InvertedHexError) as streamed:
        cs.stream_mesh(part, tmp_path / "stream.vtkhdf", **options, smoothing=False)
    assert str(streamed.value) == str(memory.value)
    assert streamed.value.hexes == memory.value.hexes
    assert streamed.value.solids == memory.value.solids == ("c",)
    assert not list(tmp_path.iterdir())
    mesh = cs.sweep_mesh(part, **options)
    assert any("worst scaled Jacobian" in note for note in mesh.info["notes"])
    figures = cs.stream_mesh(part, tmp_path / "stream.vtkhdf", **options)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), mesh)
    assert figures["notes"] == mesh.info["notes"]
    assert figures["min_scaled_jacobian"] == mesh.info["quality"].min_scaled_jacobian
    with (tmp_path / "p.sweep.npz").open("wb") as stream:
        save_template(mesh, stream)
    assert same(expand(tmp_path / "p.sweep.npz"), mesh), "nodes that were moved are kept beside the factors"
