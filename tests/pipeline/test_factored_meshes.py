"""The same mesh by other ways: from its factors, slab by slab, over several MPI ranks."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.blocks import slabs
from cadsweep.blocks.finish import to_block_mesh
from cadsweep.blocks.pieces import share_out
from cadsweep.blocks.stream import check_blocks, measure
from cadsweep.pipeline import expand, write_factors

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

MODELS = Path(__file__).parents[2] / "models"
ELBOW, C_SHAPE = str(MODELS / "elbow.py"), str(MODELS / "c_shape.py")


def same(a: cs.HexMesh, b: cs.HexMesh) -> bool:
    return (
        np.array_equal(a.points, b.points)
        and np.array_equal(a.hexes, b.hexes)
        and a.boundaries.keys() == b.boundaries.keys()
        and all(np.array_equal(a.boundaries[name], b.boundaries[name]) for name in a.boundaries)
    )


def test_a_mesh_in_blocks_is_limited_by_its_boundary_as_the_same_in_memory():
    wedge = cq.Workplane().polyline([(0, 0), (10, 0), (10, 1)]).close().extrude(4)
    mesh = cs.sweep_mesh(wedge, size=1.0)
    origin = mesh.origin
    blocks = to_block_mesh(origin.part, origin.cells, origin.names, {"cad_volume": 20.0})
    report = check_blocks(blocks, None, measure(blocks, share_out(blocks, 0, 1)))
    known = mesh.info["quality"].limit
    assert known.value < 0.3
    assert (report.limit.value, report.limit.node, report.limit.hex) == (known.value, known.node, known.hex)
    assert [one.layer for one in report.worst] == [one.layer for one in mesh.info["quality"].worst]


def test_a_streamed_mesh_has_the_names_of_imprints_that_no_sweep_follows(padded, tmp_path):
    mesh = cs.sweep_mesh(padded, size=2.0)
    figures = cs.stream_mesh(padded, tmp_path / "p.vtkhdf", size=2.0)
    assert len(mesh.boundaries["pad"])
    assert same(cs.read(tmp_path / "p.vtkhdf"), mesh)
    assert figures["notes"] == mesh.info["notes"]


@pytest.mark.parametrize("part", ["elbow", "plate", "ring"])
def test_factors_give_the_mesh_back_bit_for_bit(part, request, tmp_path):
    mesh = write_factors(request.getfixturevalue(part), tmp_path / "p.sweep.npz", size=1.5)
    assert same(expand(tmp_path / "p.sweep.npz"), mesh)


def stack():
    """A round boss on a plate."""
    return cq.Workplane().box(4, 2, 1).faces(">Z").workplane().circle(0.6).extrude(1)


def cells():
    """Blocks that stick out in two directions: no sweep and no stack."""
    bar = cq.Workplane().box(6, 2, 1.5)
    return bar.union(cq.Workplane().box(1.5, 2, 2).translate((0, 0, 1.75))).union(
        cq.Workplane().box(1.5, 3, 1).translate((0, 2.5, 0))
    )


@pytest.mark.parametrize("make", [stack, cells])
def test_a_file_gives_columns_and_cells_back_bit_for_bit(make, tmp_path):
    # Turned out of the axes, so that no coordinate is a short number.
    shape = make().rotate((0, 0, 0), (1, 2, 3), 17).translate((0.1, 0.2, 0.3))
    path = tmp_path / "p.sweep.npz"
    mesh = write_factors(shape, path, size=0.5)
    assert mesh.structure is None, "it is no plain sweep"
    back = expand(path)
    for kind in ("boundaries", "interfaces", "parts"):
        assert list(getattr(back, kind)) == list(getattr(mesh, kind))
    for here, there in zip(arrays_of(mesh), arrays_of(back), strict=True):
        assert (here.dtype, here.shape) == (there.dtype, there.shape)
        assert here.tobytes() == there.tobytes()


def arrays_of(mesh):
    return [mesh.points, mesh.hexes, *mesh.boundaries.values(), *mesh.interfaces.values(), *mesh.parts.values()]


@pytest.fixture
def pocket():
    """A plate of columns."""
    return cq.Workplane().box(20, 20, 6).faces(">Z").workplane().rect(6, 6).cutBlind(-3)


@pytest.mark.parametrize("part", ["plate", "pocket"])
def test_a_file_keeps_the_pairs_of_periodic_faces(part, request, tmp_path):
    shape = request.getfixturevalue(part)
    path = tmp_path / "p.sweep.npz"
    mesh = write_factors(shape, path, size=3.0, periodic={"<X": ">X"})
    (name,) = mesh.periodic
    back = expand(path)
    assert list(back.periodic) == [name]
    assert np.array_equal(back.periodic[name], mesh.periodic[name])
    here, there = back.points[back.periodic[name].T]
    assert np.allclose(there - here, [20, 0, 0], atol=1e-12)


def test_factors_stay_small_however_many_layers(plate, tmp_path):
    path = tmp_path / "p.sweep.npz"
    mesh = write_factors(plate, path, size=1.5, layers=200)
    assert path.stat().st_size < 0.1 * (mesh.points.nbytes + mesh.hexes.nbytes)


def test_factors_of_columns_stay_small_however_many_layers(pocket, tmp_path):
    path = tmp_path / "p.sweep.npz"
    mesh = write_factors(pocket, path, size=1.0, layers=100)
    assert path.stat().st_size < 0.1 * (mesh.points.nbytes + mesh.hexes.nbytes)
    back = expand(path)
    assert same(back, mesh)
    assert back.info["quality"].valid


def test_damaged_factors_are_an_error(plate, tmp_path):
    path = tmp_path / "p.sweep.npz"
    write_factors(plate, path, size=3.0)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(cs.InputError, match="damaged"):
        expand(path)
    path.write_text("a mesh")
    with pytest.raises(cs.InputError, match="not a file of sweep factors") as refusal:
        expand(path)
    assert "pickle" not in str(refusal.value)


@pytest.mark.parametrize("part", ["elbow", "plate", "ring"])
def test_a_streamed_mesh_is_the_mesh_in_memory(part, request, tmp_path, monkeypatch):
    shape = request.getfixturevalue(part)
    mesh = cs.sweep_mesh(shape, size=1.5, layers=None if part == "ring" else 7)
    monkeypatch.setattr(slabs, "SLAB_NODES", 3 * mesh.structure.n_nodes)  # slabs that do not divide the layers
    figures = cs.stream_mesh(shape, tmp_path / "p.vtkhdf", size=1.5, layers=None if part == "ring" else 7)
    assert same(cs.read(tmp_path / "p.vtkhdf"), mesh)
    assert figures["min_scaled_jacobian"] == mesh.info["quality"].min_scaled_jacobian
    assert figures["volume"] == pytest.approx(mesh.info["quality"].volume, rel=1e-12)


def test_an_invalid_mesh_is_not_streamed(tmp_path):
    # On the C-shape the functional G shears the domed layers until they turn inside out; nothing is mended here.
    path = tmp_path / "p.vtkhdf"
    options = {"layers": 9, "functional": "G", "strategy": "source", "residual": False, "smoothing": False}
    with pytest.raises(cs.InvertedHexError):
        cs.stream_mesh(C_SHAPE, path, **options)
    assert not path.exists()


mpiexec = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or shutil.which("mpiexec")
needs_mpi = pytest.mark.skipif(
    mpiexec is None or importlib.util.find_spec("mpi4py") is None, reason="mpi4py and an MPI are not installed"
)


@needs_mpi
@pytest.mark.parametrize(("n_ranks", "suffix"), [(3, ".pvtu"), (2, ".vtkhdf")])
def test_ranks_together_write_the_serial_mesh(n_ranks, suffix, tmp_path):
    path = tmp_path / f"big{suffix}"
    command = [mpiexec, "-n", str(n_ranks), sys.executable, "-m", "mpi4py", "-m", "cadsweep", "mesh", ELBOW]
    done = subprocess.run(
        [*command, "-o", str(path), "--size", "4", "--layers", "9", "--json"],
        capture_output=True,
        text=True,
        check=False,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr
    serial = cs.sweep_mesh(ELBOW, size=4.0, layers=9)
    assert same(cs.read(path), serial)
    # An MPI may have its own word before, on a machine without a network.
    assert json.loads(done.stdout.splitlines()[-1])["n_hexes"] == serial.n_hexes


@needs_mpi
def test_a_rank_that_fails_ends_the_job_with_a_message(tmp_path):
    command = [mpiexec, "-n", "2", sys.executable, "-m", "mpi4py", "-m", "cadsweep", "mesh", str(tmp_path / "no.step")]
    done = subprocess.run(
        [*command, "-o", str(tmp_path / "big.pvtu")], capture_output=True, text=True, check=False, timeout=200
    )
    assert done.returncode != 0
    assert "no.step" in done.stderr
    assert not list(tmp_path.iterdir())
