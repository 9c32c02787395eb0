import subprocess
import sys

import pytest

from cadsweep.brief import MOST_LINES
from cadsweep.errors import CadSweepError
from cadsweep.libraries import ALL_PACKAGES, explain_import_error

BOX = "import cadquery as cq\nshow_object(cq.Workplane().box(1, 1, 1))\n"


@pytest.mark.parametrize(
    ("library", "package"),
    [
        ("libGLU.so.1", "libglu1-mesa"),
        ("libXrender.so.1", "libxrender1"),
        ("libXcursor.so.1", "libxcursor1"),
        ("libXft.so.2", "libxft2"),
        ("libXinerama.so.1", "libxinerama1"),
        ("libGL.so.1", "libgl1"),
        ("libX11.so.6", "libx11-6"),
    ],
)
def test_a_missing_system_library_names_its_package(library, package):
    error = OSError(f"{library}: cannot open shared object file: No such file or directory")
    text = explain_import_error("gmsh", error, distribution="gmsh")
    assert f"apt-get install {package} " in text
    assert "\n" not in text


def test_a_system_library_that_nobody_knows_is_still_named():
    error = OSError("libodd-2.so.7: cannot open shared object file: No such file or directory")
    assert "libodd" in explain_import_error("gmsh", error, distribution="gmsh")


def test_the_list_of_all_packages_is_what_the_installer_looks_for():
    from pathlib import Path

    installer = (Path(__file__).parent.parent / "install.sh").read_text()
    assert not [package for package in ALL_PACKAGES.split() if f":{package}" not in installer]


def test_opencascade_without_its_library_is_said_on_the_command_line(tmp_path):
    (tmp_path / "box.py").write_text(BOX)
    (tmp_path / "OCP.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file: No such file')\n")
    done = subprocess.run(
        [sys.executable, "-m", "cadsweep", "mesh", str(tmp_path / "box.py"), "-o", str(tmp_path / "box.vtu")],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": f"{tmp_path}:{':'.join(sys.path)}", "PATH": "/usr/bin:/bin"},
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") <= MOST_LINES
    assert "OpenCASCADE needs the system library libGL: apt-get install libgl1 " in done.stderr
    assert not (tmp_path / "box.vtu").exists()


def test_a_part_cannot_be_loaded_without_opencascade(monkeypatch, tmp_path):
    from cadsweep.cad import load

    monkeypatch.setitem(sys.modules, "OCP", None)
    (tmp_path / "box.py").write_text(BOX)
    with pytest.raises(CadSweepError, match="pip install cadquery"):
        load(tmp_path / "box.py")
