"""A study of one mesh: equal hexahedra in all cases, one file of all, failures by name."""

import sys

import h5py
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.batch import read_study, run_study
from cadsweep.errors import CadSweepError, InputError
from cadsweep.io.steps import write_steps

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [
    pytest.mark.cad,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="locks of Linux"),
]

SCRIPT = """
import cadquery as cq
hole = 0.4
holes = 1
body = cq.Workplane().box(2, 1, 0.3)
if hole > 1:
    body = cq.Workplane().sphere(hole)
elif holes:
    body = body.faces(">Z").workplane().hole(hole)
show_object(body)
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "part.py").write_text(SCRIPT)

    def write(text):
        path = tmp_path / "study.toml"
        path.write_text('script = "part.py"\nsame_mesh = true\n' + text)
        return path

    return write


def test_all_cases_have_one_mesh_and_one_file(study):
    text = "[options]\nsize = 0.3\nlayers = 2\n[grid]\nhole = [0.4, 0.5, 0.6]\n[[cases]]\nholes = 0\n"
    result = run_study(read_study(study(text)))
    assert [record["status"] for record in result.records] == ["ok", "ok", "ok", "failed"]
    assert "do not correspond" in result.records[3]["error"]
    meshes = [cs.read(result.table.parent / record["mesh"]) for record in result.records[:3]]
    for mesh, hole in zip(meshes, (0.4, 0.5, 0.6), strict=True):
        assert np.array_equal(mesh.hexes, meshes[0].hexes)
        # The hole's nodes are those of the first, further out.
        on_hole = np.abs(np.hypot(*meshes[0].points[:, :2].T) - 0.2) < 1e-9
        assert np.allclose(mesh.points[on_hole, :2], meshes[0].points[on_hole, :2] * hole / 0.4, atol=1e-9)
    with h5py.File(result.together) as file:
        root = file["VTKHDF"]
        points = root["Points"][:].reshape(3, -1, 3)
        assert np.array_equal(points, [mesh.points for mesh in meshes])
        assert np.array_equal(root["Connectivity"][:].reshape(-1, 8), meshes[0].hexes)
        assert root["Cases/hole"][:].tolist() == [0.4, 0.5, 0.6]
    # What is done is not done again; another base is another study.
    assert run_study(read_study(study(text))).n_resumed == 4
    other = text.replace("[0.4, 0.5, 0.6]", "[0.5, 0.4, 0.6]")
    assert {c.key for c in read_study(study(other)).cases}.isdisjoint(c.key for c in read_study(study(text)).cases)


def test_vtk_steps_through_the_file(tmp_path):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    import cadquery as cq
    from vtkmodules.util.numpy_support import vtk_to_numpy

    mesh = cs.sweep_mesh(cq.Workplane().box(2, 1, 1), size=0.5)
    steps = [mesh.points, 2.0 * mesh.points, mesh.points + [0, 0, 3]]
    with open(tmp_path / "steps.vtkhdf", "w+b") as stream:
        write_steps(stream, mesh, steps, times=[0.0, 1.0, 2.0])
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "steps.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    for step, points in enumerate(steps):
        reader.SetStep(step)
        reader.Update()
        grid = reader.GetOutput()
        assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), points)
        assert np.array_equal(vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 8), mesh.hexes)
    with open(tmp_path / "bad.vtkhdf", "w+b") as stream, pytest.raises(InputError, match="step 1"):
        write_steps(stream, mesh, [mesh.points, mesh.points[:-1]], times=[0.0, 1.0])


def test_a_base_that_cannot_be_meshed_ends_the_study(study):
    with pytest.raises(CadSweepError, match=r"first case 'hole-3\.0'.*cannot be meshed"):
        run_study(read_study(study("[options]\ndecompose = false\n[grid]\nhole = [3.0, 0.4]\n")))


def test_options_may_not_vary(study):
    with pytest.raises(InputError, match=r"(?s)same_mesh.*size = 0\.2 where.*has 0\.1"):
        read_study(study("[grid]\noptions.size = [0.1, 0.2]\n"))
    path = study("[grid]\nhole = [1.0]\n")
    path.write_text(path.read_text().replace("= true", "= 3"))
    with pytest.raises(InputError, match="'same_mesh' must be true or false"):
        read_study(path)
