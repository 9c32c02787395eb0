"""Full disks, locked folders, signals, limits, runs at once: the old file stands, and nothing partial stays.

``CADSWEEP_LONG=1`` runs every stage and the full numbers of threads and processes.
"""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import uuid

import psutil
import pytest

import cadsweep

from .damaged import make_part

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [
    pytest.mark.cad,
    pytest.mark.timeout(900),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="signals, sessions and tmpfs of Linux"),
]

LONG = "CADSWEEP_LONG" in os.environ
STAGES = ("cad", "recognition", "intervals", "surface", "projection", "assembly", "quality", "write")
TRIED = STAGES if LONG else ("cad", "surface", "write")

DRIVER = """
import os
from cadsweep.cli import main, progress

def call(bar, stage, fraction=None):
    if stage == {stage!r}:
        os.kill(os.getpid(), {number})

progress.ProgressBar.__call__ = call
main({args!r})
"""


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """A plate with a hole as a STEP file."""
    import cadquery as cq

    path = tmp_path_factory.mktemp("parts") / "plate.step"
    cq.exporters.export(make_part("plate"), str(path))
    return path


def run(*args, code=None, env=None, **options):
    """Run the command, or Python code, and return how it ended; a tag in the environment finds its processes."""
    tag = uuid.uuid4().hex
    command = [sys.executable, "-m", "cadsweep", *map(str, args)] if code is None else [sys.executable, "-c", code]
    environment = {**os.environ, **(env or {}), "CADSWEEP_TEST": tag}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=800, check=False, **options)
    return done, tag


def processes(tag):
    """Processes that carry the tag and have not ended."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.environ().get("CADSWEEP_TEST") == tag and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
        except (psutil.NoSuchProcess, psutil.AccessDenied, OSError):
            continue
    return found


def wait_until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def listing(folder):
    """Every name in a folder and what it holds."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def few_lines(done):
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) <= 3, done.stderr
    assert len(done.stderr) <= 450
    return done.stderr


@pytest.mark.parametrize("stage", TRIED)
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)][:: 1 if LONG else 2]
)
def test_a_signal_at_any_stage_leaves_the_old_file_and_nothing_else(plate, tmp_path, stage, number, code):
    place = tmp_path / "out"
    place.mkdir()
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    (place / "plate.vtu").write_text("the old mesh")
    args = ["mesh", str(plate), "-o", str(place / "plate.vtu"), "--size", "0.15"]
    driver = DRIVER.format(stage=stage, number=int(number), args=args)
    done, tag = run(code=driver, env={"TMPDIR": str(temporary)})
    assert done.returncode == code
    assert done.stdout == ""
    wait_until(lambda: not processes(tag))
    if number != signal.SIGKILL:
        # at once, not some time later
        assert listing(place) == {"plate.vtu": b"the old mesh"}
    wait_until(lambda: not listing(temporary))
    wait_until(lambda: listing(place) == {"plate.vtu": b"the old mesh"})


def test_an_interrupt_from_the_terminal_ends_all_at_once(plate, tmp_path):
    """Ctrl-C goes to the whole foreground group."""
    tag = uuid.uuid4().hex
    caller = subprocess.Popen(
        [sys.executable, "-m", "cadsweep", "mesh", str(plate), "-o", str(tmp_path / "plate.vtu"), "--size", "0.05"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        env={**os.environ, "CADSWEEP_TEST": tag},
    )  # fmt: skip
    wait_until(lambda: len(processes(tag)) >= 3)
    time.sleep(1.0)
    os.killpg(caller.pid, signal.SIGINT)
    out, err = caller.communicate(timeout=30)
    assert caller.returncode == 130
    assert (out, err.decode().strip()) == (b"", "cadsweep: interrupted")
    wait_until(lambda: not processes(tag))
    assert not list(tmp_path.iterdir())


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 256 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = shutil.which("mount")
    if (
        not mount
        or subprocess.run(
            [mount, "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)], capture_output=True, check=False
        ).returncode
    ):
        pytest.skip("a small file system cannot be mounted here: it takes root")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.parametrize("suffix", ["vtu", "msh", "inp", "vtkhdf", "exo", "med"] if LONG else ["vtu"])
def test_a_full_disk_leaves_the_old_file(plate, small_disk, suffix):
    old = small_disk / f"plate.{suffix}"
    old.write_bytes(b"the old mesh")
    done, _ = run("mesh", plate, "-o", old, "--size", "0.15")
    assert done.returncode == 1
    assert "space" in few_lines(done)
    assert listing(small_disk) == {old.name: b"the old mesh"}


def test_a_full_temporary_folder_is_named_or_not_needed(plate, small_disk, tmp_path):
    _fill(small_disk)
    done, _ = run("mesh", plate, "-o", tmp_path / "plate.vtu", env={"TMPDIR": str(small_disk)})
    if done.returncode:
        assert done.returncode == 1
        few_lines(done)
        assert not (tmp_path / "plate.vtu").exists()
    else:
        assert cadsweep.read(tmp_path / "plate.vtu").quality().valid


def _fill(folder):
    with open(folder / "full", "wb", buffering=0) as file:
        try:
            while True:
                file.write(b"x" * 4096)
        except OSError:
            return


def test_a_missing_folder_is_named_before_any_work(plate, tmp_path):
    done, _ = run("mesh", plate, "-o", tmp_path / "absent" / "plate.vtu")
    assert done.returncode == 1
    assert "absent" in few_lines(done)
    assert not list(tmp_path.iterdir())


def test_a_read_only_folder_is_named_before_any_work(plate, tmp_path):
    place = tmp_path / "locked"
    place.mkdir()
    (place / "plate.vtu").write_bytes(b"the old mesh")
    place.chmod(0o555)
    command = ["mesh", plate, "-o", place / "plate.vtu"]
    try:
        if os.geteuid() == 0:
            # root writes anywhere: only a read-only mount stops it
            if subprocess.run(["mount", "--bind", place, place], capture_output=True, check=False).returncode:
                pytest.skip("root writes anywhere, and nothing can be mounted here")
            subprocess.run(["mount", "-o", "remount,ro,bind", place], check=True)
        done, _ = run(*command)
    finally:
        if os.geteuid() == 0:
            subprocess.run(["umount", place], capture_output=True, check=False)
        place.chmod(0o755)
    assert done.returncode == 1
    assert "locked" in few_lines(done)
    assert listing(place) == {"plate.vtu": b"the old mesh"}


@pytest.mark.parametrize("kind", ["folder", "fifo"])
def test_what_is_no_file_is_not_replaced(plate, tmp_path, kind):
    place = tmp_path / "plate.vtu"
    place.mkdir() if kind == "folder" else os.mkfifo(place)
    done, _ = run("mesh", plate, "-o", place)
    assert done.returncode == 1
    few_lines(done)
    assert place.is_dir() if kind == "folder" else place.is_fifo()


def test_a_memory_limit_ends_the_run_with_its_stage(plate, tmp_path):
    done, _ = run("mesh", plate, "-o", tmp_path / "plate.vtu", "--max-memory", "0.1")
    assert done.returncode == 1
    assert "memory" in few_lines(done)
    assert not list(tmp_path.iterdir())


def test_a_time_out_ends_the_run_with_its_stage(plate, tmp_path):
    start = time.monotonic()
    done, tag = run("mesh", plate, "-o", tmp_path / "plate.vtu", "--timeout", "0.5")
    assert done.returncode == 1
    assert "time-out in stage" in few_lines(done)
    assert time.monotonic() - start < 15.0
    assert not processes(tag)
    assert not list(tmp_path.iterdir())


def test_two_runs_into_one_file_leave_one_whole_file(plate, tmp_path):
    place = tmp_path / "plate.vtu"
    ends = []
    threads = [
        threading.Thread(
            target=lambda size=size: ends.append(run("mesh", plate, "-o", place, "--size", size, "--json"))
        )
        for size in ("0.2", "0.4")
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [done.returncode for done, _ in ends] == [0, 0]
    counts = {json.loads(done.stdout)["n_hexes"] for done, _ in ends}
    assert len(counts) == 2
    mesh = cadsweep.read(place)
    assert mesh.n_hexes in counts
    assert mesh.quality().valid
    assert list(tmp_path.iterdir()) == [place]


def test_calls_in_many_threads_take_turns_and_agree(plate):
    n_threads = 50 if LONG else 8
    found = []

    def work():
        mesh = cadsweep.sweep_mesh(plate, size=0.5)
        found.append((mesh.points.tobytes(), mesh.hexes.tobytes()))

    threads = [threading.Thread(target=work) for _ in range(n_threads)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == n_threads
    assert len(set(found)) == 1


def test_runs_in_many_processes_agree(plate, tmp_path):
    n_runs, at_once = (50, 10) if LONG else (3, 3)
    ends, gate = [], threading.Semaphore(at_once)

    def work(number):
        with gate:
            ends.append(run("mesh", plate, "-o", tmp_path / f"{number}.vtu", "--size", "0.5", "--quiet")[0])

    threads = [threading.Thread(target=work, args=(n,)) for n in range(n_runs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [(done.returncode, done.stdout, done.stderr) for done in ends] == [(0, "", "")] * n_runs
    assert len({hashlib.sha256(path.read_bytes()).digest() for path in tmp_path.iterdir()}) == 1


HOSTILE_OPTIONS = """
General.NumThreads = 8;
General.Terminal = 1;
Mesh.Algorithm = 1;
Mesh.ElementOrder = 2;
Mesh.RecombinationAlgorithm = 0;
Mesh.MeshSizeFactor = 0.1;
Mesh.SaveAll = 1;
Geometry.Tolerance = 1;
Error("a hostile configuration");
Exit;
"""


def test_a_hostile_gmsh_configuration_changes_nothing(plate, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    for name in (".gmshrc", ".gmsh-options", ".gmsh-errors"):
        (home / name).write_text(HOSTILE_OPTIONS)
    environments = {"plain": {}, "hostile": {"HOME": str(home), "GMSH_HOME": str(home)}}
    for name, env in environments.items():
        done, _ = run("mesh", plate, "-o", tmp_path / f"{name}.vtu", "--size", "0.4", env=env, cwd=home)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "plain.vtu").read_bytes() == (tmp_path / "hostile.vtu").read_bytes()


@pytest.mark.parametrize("suffix", ["vtu", "msh", "inp", "vtkhdf", "exo", "med"] if LONG else ["vtu"])
def test_the_same_input_gives_the_same_bytes_everywhere(plate, tmp_path, suffix):
    """In this process, in a worker, from the command line, and run after run."""
    places = [tmp_path / f"{name}.{suffix}" for name in ("here", "again", "worker", "command")]
    for place, isolated in zip(places[:3], (False, False, True), strict=True):
        cadsweep.sweep_mesh(plate, size=0.4, isolated=isolated).write(place)
    done, _ = run("mesh", plate, "-o", places[3], "--size", "0.4")
    assert done.returncode == 0
    assert len({place.read_bytes() for place in places}) == 1


def test_an_isolated_mesh_is_the_same_mesh(plate):
    here, there = (cadsweep.sweep_mesh(plate, size=0.4, isolated=isolated) for isolated in (False, True))
    assert here.points.tobytes() == there.points.tobytes()
    assert here.hexes.tobytes() == there.hexes.tobytes()
    assert {k: v.tobytes() for k, v in here.boundaries.items()} == {k: v.tobytes() for k, v in there.boundaries.items()}
    assert there.quality().valid
    there.points[0] += 0.0  # a mesh that came from a worker is as writable as any
