"""What the tests ask a worker process to do; every function takes ``on_progress``, as a stage does."""

import ctypes
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

from cadsweep.errors import NotSweepableError


def arrays(n, on_progress):
    on_progress("projection", 0.5)
    return {"points": np.arange(3 * n, dtype=np.float64).reshape(n, 3), "none": np.empty((0, 3)), "name": "box"}


def stages(on_progress):
    for stage in ("cad", "surface"):
        on_progress(stage, 0.0)
        on_progress(stage, 1.0)


def chatter(on_progress):
    print("from Python" * 1000)
    os.write(1, b"from a library\n" * 100_000)
    os.write(2, b"and its errors\n" * 100_000)
    sys.stdout.flush()


def refuse(on_progress):
    raise NotSweepableError("no caps", reasons=["face 1: no", "face 2: neither"])


def fail(on_progress):
    on_progress("intervals", 0.0)
    raise KeyError("a defect")


def leave(on_progress):
    sys.exit(0)


def crash(on_progress):
    on_progress("cad", 0.0)
    ctypes.string_at(0)


def die(on_progress):
    on_progress("surface", 0.0)
    os.kill(os.getpid(), 9)


def hang(on_progress):
    on_progress("surface", 0.0)
    time.sleep(600)


def hang_in_native_code(on_progress):
    """A loop that never lets Python's own signal handlers run."""
    on_progress("cad", 0.0)
    ctypes.PyDLL(None).sleep(600)


def grow(on_progress):
    on_progress("projection", 0.0)
    kept = []
    while True:
        kept.append(np.ones(10**6))


def grow_at_once(on_progress):
    on_progress("projection", 0.0)
    np.ones(10**10)


def start_a_child(pid_file, on_progress):
    """Leave a process of its own behind, as a script may."""
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    with open(pid_file, "w", encoding="ascii") as file:
        file.write(str(child.pid))


def litter_and_hang(folder, on_progress):
    """A temporary file, an unfinished output beside its place, and no end."""
    with tempfile.NamedTemporaryFile(delete=False) as file:
        file.write(b"x" * 1000)
    with open(os.path.join(folder, f".out.vtu.{os.getpid()}-abcdef.tmp"), "wb") as file:
        file.write(b"half a mesh")
    with open(os.path.join(folder, "ready"), "w", encoding="ascii") as file:
        file.write(f"{os.getpid()} {tempfile.gettempdir()}")
    time.sleep(600)


def where(on_progress):
    return os.getpid(), tempfile.gettempdir(), os.getsid(0), sys.stdin.read()


def mesh_many(sources, options, record, on_progress):
    """Mesh one source after the other, and write down how each ended before the next is begun."""
    import json

    from cadsweep import sweep_mesh
    from cadsweep.errors import CadSweepError
    from cadsweep.quality import check_mesh

    with open(record, "a", encoding="utf-8") as file:
        for source in sources:
            try:
                mesh = sweep_mesh(source, on_progress=on_progress, **options)
                report = check_mesh(mesh)
                end = ["mesh" if report.valid else "invalid", "; ".join(report.problems), mesh.n_hexes, report.volume]
            except CadSweepError as error:
                end = [type(error).__name__, error.message, 0, 0.0]
            except Exception as error:
                end = [f"not named: {type(error).__name__}", str(error), 0, 0.0]
            file.write(json.dumps(end) + "\n")
            file.flush()


def leave_traces(folder, on_progress):
    """Change what a task may change in its process: folder, environment, path, modules, files, processes."""
    import subprocess

    os.chdir(folder)
    os.environ["LEFT_BEHIND"] = "1"
    sys.path.insert(0, folder)
    import beside

    with open(os.path.join(tempfile.gettempdir(), "left"), "wb") as file:
        file.write(b"x")
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    return os.getpid(), child.pid, beside.VALUE


def look_around(on_progress):
    return {
        "pid": os.getpid(),
        "folder": os.getcwd(),
        "environment": "LEFT_BEHIND" in os.environ,
        "path": list(sys.path),
        "modules": "beside" in sys.modules,
        "files": sorted(os.listdir(tempfile.gettempdir())),
    }


def leave_a_thread(on_progress):
    import threading

    threading.Thread(target=time.sleep, args=(600,), daemon=False).start()
    return os.getpid()


def hold(n_bytes, on_progress):
    """Keep memory for good, as a library that leaks does."""
    kept = sys.modules.setdefault("kept_memory", [])  # where nothing clears it
    kept.append(np.ones(n_bytes // 8))
    return os.getpid()


def n_arguments(on_progress):
    return len(sys.argv)


def threads_of_blas(*, on_progress):
    """How many threads there are once numpy has solved something that is large enough for more than one."""
    import numpy as np

    np.linalg.solve(np.eye(600), np.ones(600))
    return len(os.listdir("/proc/self/task")) if os.path.isdir("/proc/self/task") else 1
