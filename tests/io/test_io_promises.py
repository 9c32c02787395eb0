"""A file appears whole or not at all, and what is no mesh is refused in one clear line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from cadsweep import io
from cadsweep.errors import CadSweepError, InputError
from cadsweep.io import atomic
from cadsweep.mesh import HexMesh

from .io_meshes import TOLERANCES, box, twisted_box, two_parts

SUFFIXES = [s for s in io.FORMATS if s not in {".exo", ".pvtu"}]
FILE_SUFFIXES = [s for s in SUFFIXES if s != ".polymesh"]
HDF5_SUFFIXES = (".vtkhdf", ".med", ".cgns", ".e", ".exo")
HDF5_VERSION = h5py.version.hdf5_version_tuple


def left(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def files_of(path: Path) -> list[str]:
    """A mesh file, and the one beside it that some formats have."""
    return sorted([path.name, *([path.with_suffix(".nmf").name] if path.suffix == ".xyz" else [])])


def test_an_unknown_suffix_lists_the_known_ones(tmp_path):
    for name in ("part.stl", "part", "part.msh.gz", "part."):
        with pytest.raises(InputError, match=r"\.vtu .*\.msh .*\.inp"):
            io.check_destination(tmp_path / name)
        with pytest.raises(InputError, match=r"\.vtu"):
            io.read(tmp_path / name)


def test_suffixes_in_capitals_are_known(tmp_path):
    io.write(box(), tmp_path / "PART.MSH")
    assert io.read(tmp_path / "PART.MSH").n_hexes == 24


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_missing_folder_is_named(tmp_path, suffix):
    with pytest.raises(InputError, match="nowhere"):
        io.check_destination(tmp_path / "nowhere" / f"part{suffix}")
    with pytest.raises(InputError, match="nowhere"):
        io.write(box(), tmp_path / "nowhere" / f"part{suffix}")
    assert left(tmp_path) == []


def test_a_place_that_is_no_file_is_refused(tmp_path):
    (tmp_path / "folder.vtu").mkdir()
    for place in (tmp_path / "folder.vtu", tmp_path / "folder.vtu" / "x" / "y.vtu", tmp_path / ("n" * 300 + ".vtu")):
        with pytest.raises(InputError):
            io.write(box(), place)
    os.mkfifo(tmp_path / "pipe.vtu")
    with pytest.raises(InputError, match="regular"):
        io.write(box(), tmp_path / "pipe.vtu")
    (tmp_path / "loop.vtu").symlink_to(tmp_path / "loop.vtu")
    with pytest.raises(CadSweepError):
        io.write(box(), tmp_path / "loop.vtu")


def test_a_folder_with_other_files_is_not_replaced(tmp_path):
    place = tmp_path / "polyMesh"
    place.mkdir()
    (place / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        io.write(box(), place)
    assert left(place) == ["thesis.tex"]
    assert left(tmp_path) == ["polyMesh"]


def test_options_are_checked(tmp_path):
    with pytest.raises(InputError, match="binary, version"):
        io.write(box(), tmp_path / "part.msh", colour="red")
    with pytest.raises(InputError, match="no option 'version'; they have: scale"):
        io.write(box(), tmp_path / "part.vtu", version="2.2")
    with pytest.raises(InputError, match=r"4\.1, 2\.2"):
        io.write(box(), tmp_path / "part.msh", version="3")
    with pytest.raises(InputError, match="text"):
        io.write(box(), tmp_path / "part.msh", version="2.2", binary=True)
    assert left(tmp_path) == []


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_fault_leaves_the_old_file(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"part{suffix}"
    io.write(box(), path)
    before = {p.name: p.read_bytes() for p in (path if path.is_dir() else tmp_path).iterdir()}

    def fail(*_args: object, **_options: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(CadSweepError, match="No space left"):
        io.write(box(5, 4, 3), path)
    monkeypatch.undo()
    assert left(tmp_path) == files_of(path)
    assert before == {p.name: p.read_bytes() for p in (path if path.is_dir() else tmp_path).iterdir()}
    io.write(box(5, 4, 3), path)
    assert io.read(path).n_hexes == 60
    assert left(tmp_path) == files_of(path)


@pytest.mark.parametrize("suffix", FILE_SUFFIXES)
def test_bytes_that_change_on_the_way_are_noticed(tmp_path, suffix, monkeypatch):
    """A writer that puts down something else than the mesh: the old file stands."""
    path = tmp_path / f"part{suffix}"
    path.write_text("old")
    module = io._module(path)
    real = module.write

    def other(stream, mesh, **options):
        wrong = HexMesh(points=mesh.points + 1e-9, hexes=mesh.hexes, boundaries=mesh.mesh().boundaries)
        real(stream, io.labels.label_mesh(wrong), **options)

    monkeypatch.setattr(module, "write", other)
    with pytest.raises(CadSweepError, match="reading it back"):
        io.write(box(), path)
    assert path.read_text() == "old"
    assert left(tmp_path) == [path.name]


@pytest.mark.parametrize("early", [True, False])
def test_what_is_written_in_many_ways_stands_in_the_file(tmp_path, early, monkeypatch):
    """Bytes, arrays of several pieces and places written twice: with and without the disk taking them early."""
    if not early:
        monkeypatch.setattr(atomic, "_sync_file_range", None)
    values = np.random.default_rng(0).random((400_000, 3))  # 9.6 MB
    with atomic.replaced_file(tmp_path / "some.bin") as stream:
        assert stream.write(b"head") == 4
        assert stream.write(values.data) == values.nbytes
        stream.seek(1)
        assert stream.write(memoryview(b"EA")) == 2
        stream.seek(0, os.SEEK_END)
        assert stream.write(b"") == 0
        assert stream.write(b"end") == 3
        stream.seek(2)
        assert stream.read(2) == b"Ad"
    assert (tmp_path / "some.bin").read_bytes() == b"hEAd" + values.tobytes() + b"end"


def test_a_link_stays_a_link_and_permissions_stay(tmp_path):
    (tmp_path / "real").mkdir()
    target = tmp_path / "real" / "part.vtu"
    io.write(box(), target)
    target.chmod(0o640)
    link = tmp_path / "link.vtu"
    link.symlink_to(target)
    io.write(box(5, 4, 3), link)
    assert link.is_symlink()
    assert target.stat().st_mode & 0o777 == 0o640
    assert io.read(target).n_hexes == 60


def test_many_writers_of_one_file_leave_one_whole_mesh(tmp_path):
    path = tmp_path / "part.vtkhdf"
    meshes = [box(2, 2, n) for n in range(1, 9)]
    errors = []

    def work(mesh):
        try:
            for _ in range(5):
                io.write(mesh, path)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=work, args=(mesh,)) for mesh in meshes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert io.read(path).n_hexes in {mesh.n_hexes for mesh in meshes}
    assert left(tmp_path) == ["part.vtkhdf"]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_writer_leaves_the_old_file_alone(tmp_path, number):
    """The process is stopped while its file is written but not yet in place."""
    path = tmp_path / "part.msh"
    io.write(box(), path)
    before = path.read_bytes()
    script = textwrap.dedent(
        f"""
        import os, signal, sys
        sys.path.insert(0, {str(Path(__file__).parent)!r})
        from .io_meshes import box
        from cadsweep import io
        from cadsweep.io import msh
        real = msh.verify
        def verify(*args, **options):
            os.kill(os.getpid(), {int(number)})
            return real(*args, **options)
        msh.verify = verify
        io.write(box(9, 9, 9), {str(path)!r})
        """
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60, check=False)
    assert run.returncode != 0
    assert path.read_bytes() == before
    assert left(tmp_path) == ["part.msh"]


@pytest.mark.skipif(os.geteuid() != 0, reason="mounting a small tmpfs needs root")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_is_said_and_leaves_the_old_file(tmp_path, suffix):
    small = tmp_path / "small"
    small.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=192k", "tmpfs", str(small)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("tmpfs cannot be mounted here")
    try:
        path = small / f"part{suffix}"
        io.write(box(1, 1, 1), path)
        old = io.read(path).n_hexes
        with pytest.raises(CadSweepError, match="No space left"):
            io.write(box(20, 20, 20), path)
        assert io.read(path).n_hexes == old
        assert left(small) == files_of(path)
    finally:
        subprocess.run(["umount", str(small)], check=True)


# Bad input


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_that_are_no_mesh_are_refused_in_few_lines(tmp_path, suffix):
    path = tmp_path / f"bad{suffix}"
    with pytest.raises(InputError, match="there is no such file"):
        io.read(path)
    if suffix == ".polymesh":
        path.mkdir()
        with pytest.raises(InputError):
            io.read(path)
        return
    for content in (b"", b"hello", b"\x00" * 1000, bytes(range(256)) * 20, "Grüße\n".encode() * 50):
        path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            io.read(path)
        assert len(str(caught.value).splitlines()) <= 3
        assert path.name in str(caught.value)


@pytest.mark.parametrize("suffix", FILE_SUFFIXES)
def test_a_file_cut_short_anywhere_is_refused(tmp_path, suffix):
    """Or, where only the very end is missing, read as the whole mesh."""
    path = tmp_path / f"part{suffix}"
    mesh = two_parts()
    io.write(mesh, path)
    whole = path.read_bytes()
    for share in np.linspace(0.02, 0.98, 25):
        path.write_bytes(whole[: int(len(whole) * share)])
        try:
            back = io.read(path)
        except InputError:
            continue
        np.testing.assert_array_equal(back.hexes, mesh.hexes)
        np.testing.assert_allclose(back.points, mesh.points, rtol=TOLERANCES.get(suffix, 1e-12))


@pytest.mark.parametrize("suffix", FILE_SUFFIXES)
def test_flipped_bytes_end_as_a_mesh_or_a_named_error(tmp_path, suffix):
    if suffix in HDF5_SUFFIXES and HDF5_VERSION < (2,):
        pytest.skip("HDF5 1.14 ends the process where links of a file are damaged")
    path = tmp_path / f"part{suffix}"
    io.write(two_parts(), path)
    whole = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    rng = np.random.default_rng(7)
    for _ in range(40):
        damaged = whole.copy()
        damaged[rng.integers(0, len(whole), size=4)] = rng.integers(0, 256, size=4)
        path.write_bytes(damaged.tobytes())
        try:
            back = io.read(path)
        except InputError:
            continue
        assert back.hexes.min() >= 0
        assert back.hexes.max() < len(back.points)
        assert all(quads.max() < len(back.points) for quads in back.boundaries.values() if len(quads))
        assert all(ids.max() < back.n_hexes for ids in back.parts.values() if len(ids))


def test_meshes_without_hexes_or_with_mixed_cells_are_refused(tmp_path):
    tetrahedron = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n" + "".join(
        f"{j} {j} {j * j} {j**3}\n" for j in range(1, 10)
    )
    only = tetrahedron + "$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n"
    both = tetrahedron + "$EndNodes\n$Elements\n2\n1 4 0 1 2 3 4\n2 5 0 1 2 3 4 5 6 7 8\n$EndElements\n"
    lines = tetrahedron + "$EndNodes\n$Elements\n1\n1 1 0 1 2\n$EndElements\n"
    for text, word in ((only, "types 4"), (both, "types 4, 5"), (lines, "no hexahedra")):
        (tmp_path / "part.msh").write_text(text)
        with pytest.raises(InputError, match=word):
            io.read(tmp_path / "part.msh")
    (tmp_path / "part.inp").write_text("*NODE\n1,0,0,0\n*ELEMENT, TYPE=C3D4\n1,1,1,1,1\n")
    with pytest.raises(InputError, match="C3D4"):
        io.read(tmp_path / "part.inp")


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"points": np.full((60, 3), np.nan)}, "finite"),
        ({"points": np.array([[0.0, 0.0, 0.0]] * 59 + [[0.0, -np.inf, 0.0]])}, "finite"),
        ({"points": np.zeros((60, 2))}, "shape"),
        ({"hexes": np.full((2, 8), 1000)}, "between 0 and"),
        ({"hexes": np.zeros((2, 6), dtype=int)}, "shape"),
        ({"hexes": np.zeros((0, 8), dtype=int)}, "no hexes"),
        ({"boundaries": {"a": np.zeros((1, 9), dtype=int)}}, "shape"),
        ({"boundaries": {"a": np.full((1, 4), -1)}}, "between 0 and"),
        ({"parts": {"a": np.array([99])}}, "between 0 and"),
    ],
)
def test_arrays_that_are_no_mesh_are_not_written(tmp_path, changes, word):
    mesh = box()
    arrays = {"points": mesh.points, "hexes": mesh.hexes, "boundaries": mesh.boundaries, "parts": mesh.parts} | changes
    with pytest.raises(InputError, match=word):
        io.write(HexMesh(**arrays), tmp_path / "part.vtu")
    assert left(tmp_path) == []


# Names


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_names_become_portable_and_stay_apart(tmp_path, suffix, caplog):
    mesh = box()
    quads = {name: mesh.boundaries[name] for name in ("source", "target", "side_1", "side_2")}
    names = ["Zufluß oben", "inlet", "INLET", "*NODE, x\n1"]
    renamed = dict(zip(names, quads.values(), strict=True))
    long = "n" * 200
    written = HexMesh(points=mesh.points, hexes=mesh.hexes, boundaries=renamed, parts={long: np.arange(mesh.n_hexes)})
    io.write(written, tmp_path / f"part{suffix}")
    back = io.read(tmp_path / f"part{suffix}")
    found = [name for name in back.boundaries if name != "defaultFaces"]
    assert len(found) == 4
    assert len({name.lower() for name in found}) == 4
    assert "inlet" in found
    for name in [*found, *back.parts]:
        assert name.isascii()
        assert name.replace("_", "a").isalnum()
    assert len(back.boundaries["inlet"]) == len(renamed["inlet"])
    assert "is written as" in caplog.text


def test_the_rule_for_one_group_a_cell():
    """A name that no other block shares; else the names joined; alone beside shared ones: ``_only``."""
    from cadsweep.io.labels import make_blocks

    def ids(*values: int) -> np.ndarray:
        return np.array(values)

    nested = make_blocks({"all": ids(0, 1, 2, 3), "a": ids(0, 1), "b": ids(2, 3)}, 5)
    assert nested.exclusive_names() == ("a", "b", "unnamed")
    crossed = make_blocks({"a": ids(0, 1), "b": ids(1, 2)}, 3)
    assert crossed.exclusive_names() == ("a_only", "a_and_b", "b_only")
    for blocks in (nested, crossed):
        for name in blocks.names:
            assert len(blocks.named(name)) in {2, 4}


def test_arrays_larger_than_their_file_are_refused_at_once(tmp_path):
    """A damaged size must not make the reader fill memory with nothing."""
    from cadsweep.io.hdf5 import load

    with h5py.File(tmp_path / "huge.h5", "w") as file:
        file.create_dataset("huge", (1 << 40,), dtype="f8")  # never written: the file stays small
        with pytest.raises(InputError, match="claims 1099511627776"):
            load(file["huge"])


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_while_a_file_is_written_it_says_how_much_of_it_is_and_can_be_stopped(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(atomic, "_PIECE", 1 << 12)
    path = tmp_path / ("polyMesh" if suffix == ".polymesh" else f"mesh{suffix}")
    mesh = twisted_box(nx=12, ny=12, nz=12)
    said: list[tuple[str, float | None]] = []
    io.write(mesh, path, on_progress=lambda *one: said.append(one))
    assert said[-2:] == [("read back", None), ("write", 1.0)]
    shares = [share for stage, share in said[:-2] if stage == "write"]
    assert len(shares) == len(said) - 2
    assert len(shares) >= 3
    assert shares == sorted(shares)
    assert shares[0] < 0.5 <= shares[-1] < 1.0

    def stop(stage: str, share: float | None) -> None:
        raise KeyboardInterrupt

    kept = left(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        io.write(mesh, path.with_name(f"other{suffix}") if suffix != ".polymesh" else path, on_progress=stop)
    assert left(tmp_path) == kept
