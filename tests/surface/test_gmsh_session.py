"""gmsh is opened in one place, and leaves no trace there."""

import subprocess
import sys
import threading

import pytest

from cadsweep.errors import CadSweepError, SurfaceMeshError
from cadsweep.gmsh_session import gmsh_session

pytestmark = pytest.mark.cad

gmsh = pytest.importorskip("gmsh")


@pytest.fixture
def foreign():
    """gmsh as a user has it open, with a box, another model, and options of their own."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 5)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.1 + 0.2)
    gmsh.option.setString("General.AxesLabelX", "mine")
    gmsh.option.setColor("Mesh.Points", 1, 2, 3)
    gmsh.model.add("theirs")
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.add("other")
    gmsh.model.setCurrent("theirs")
    yield gmsh
    gmsh.finalize()


def check_untouched():
    assert gmsh.option.getNumber("Mesh.Algorithm") == 5
    assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 0.1 + 0.2
    assert gmsh.option.getNumber("General.Terminal") == 0
    assert gmsh.option.getString("General.AxesLabelX") == "mine"
    assert gmsh.option.getColor("Mesh.Points")[:3] == (1, 2, 3)
    assert gmsh.model.list() == ["", "theirs", "other"]
    assert gmsh.model.getCurrent() == "theirs"
    assert len(gmsh.model.getEntities(3)) == 1
    assert len(gmsh.view.getTags()) == 0


def test_a_session_closes_what_it_opened():
    with gmsh_session("ours") as session:
        assert session.model.getCurrent() == "ours"
        assert session.option.getNumber("General.NumThreads") == 1
    assert not gmsh.isInitialized()


def test_the_users_models_views_and_options_stand(foreign):
    with gmsh_session("ours", {"Mesh.Algorithm": 8}) as session:
        assert session.option.getNumber("Mesh.Algorithm") == 8
        assert session.option.getNumber("Mesh.MeshSizeMax") > 1e20  # the default, not the user's
        session.option.setNumber("Mesh.SecondOrderLinear", 1)
        session.model.occ.addSphere(0, 0, 0, 1)
        session.model.occ.synchronize()
        session.model.add("a second one of ours")
        session.view.add("ours")
    check_untouched()
    assert gmsh.option.getNumber("Mesh.SecondOrderLinear") == 0


def test_they_stand_after_an_error_too(foreign):
    with pytest.raises(SurfaceMeshError, match=r"gmsh failed \(ours\): "), gmsh_session("ours") as session:
        session.model.occ.addSphere(0, 0, 0, -1)
    check_untouched()


def test_errors_of_other_kinds_pass_through():
    with pytest.raises(ZeroDivisionError), gmsh_session("ours"):
        1 / 0  # noqa: B018
    assert not gmsh.isInitialized()


def test_threads_take_turns():
    found = []

    def work(j):
        with gmsh_session(f"model {j}") as session:
            session.model.occ.addBox(0, 0, 0, 1, 1, j + 1)
            session.model.occ.synchronize()
            found.append((session.model.getCurrent() == f"model {j}", session.model.occ.getMass(3, 1)))

    threads = [threading.Thread(target=work, args=(j,)) for j in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(round(mass, 9) for _, mass in found) == [float(j + 1) for j in range(12)]
    assert all(own for own, _ in found)


def test_a_session_within_a_session_gives_the_outer_one_back():
    with gmsh_session("outer", {"Mesh.Algorithm": 8}) as session:
        with gmsh_session("inner"):
            assert session.option.getNumber("Mesh.Algorithm") == 6
        assert session.model.getCurrent() == "outer"
        assert session.option.getNumber("Mesh.Algorithm") == 8


def test_a_configuration_file_in_the_home_folder_is_not_read(tmp_path):
    (tmp_path / ".gmshrc").write_text("Mesh.Algorithm = 1;\nGeneral.NumThreads = 7;\n")
    code = (
        "from cadsweep.gmsh_session import gmsh_session\n"
        "with gmsh_session('x') as g: print(g.option.getNumber('Mesh.Algorithm'))"
    )
    env = {"HOME": str(tmp_path), "PATH": ""}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env, timeout=60, check=True)
    assert done.stdout.split() == ["6.0"]


def test_a_missing_gmsh_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(CadSweepError, match="pip install gmsh"), gmsh_session("x"):
        pass
