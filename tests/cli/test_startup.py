"""What is imported before it is needed is waited for by every user."""

import subprocess
import sys

import cadquery as cq

import cadsweep as cs

SLOW = {"OCP", "cadquery", "vtkmodules", "gmsh", "numba", "scipy.optimize", "scipy.sparse", "scipy.spatial", "h5py"}


def modules_after(code):
    found = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return set(found.stdout.split())


def test_command_asks_for_nothing_slow_before_it_starts_its_worker():
    loaded = modules_after(
        "from cadsweep.cli.making import check_suffix, mesh\nfrom cadsweep import isolation, machine\n"
        "check_suffix('a.vtu'); machine.free_memory()"
    )
    assert not loaded & (SLOW | {"numpy"})


def test_step_file_is_read_without_cadquery_or_scipy(tmp_path):
    path = tmp_path / "box.step"
    cq.exporters.export(cq.Workplane().box(1, 2, 3), str(path))
    loaded = modules_after(f"from cadsweep.cad import load; load({str(path)!r})")
    assert "OCP" in loaded
    assert not loaded & (SLOW - {"OCP", "numba"})


def test_pipeline_is_there_before_any_of_the_large_libraries_but_numba():
    assert not modules_after("import cadsweep.pipeline") & (SLOW - {"numba"})


def test_one_sweep_loads_neither_other_ways_nor_what_compiles(tmp_path):
    path = tmp_path / "box.step"
    cq.exporters.export(cq.Workplane().box(1, 2, 3), str(path))
    cs.sweep_mesh(path)  # its loops are compiled from here on
    loaded = modules_after(
        "from cadsweep.cli.work import mesh_file\n"
        f"mesh_file({str(path)!r}, {str(tmp_path / 'box.vtu')!r}, options={{}}, on_progress=lambda stage, done: None)"
    )
    assert {"OCP", "cadsweep.recognition", "cadsweep.surface", "cadsweep.quality"} <= loaded
    other_ways = {"decomposition", "stacks", "smoothing", "pipeline.like", "pipeline.assemblies"}
    assert not loaded & {f"cadsweep.{room}" for room in other_ways}
    assert not loaded & ((SLOW | {"numba.np.arraymath", "scipy.linalg", "multiprocessing"}) - {"OCP", "numba"})
