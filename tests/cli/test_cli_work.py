"""The commands at work: what they write, print and return."""

import json
import os
import pty
import re
import select
import subprocess
import sys
import time

import numpy as np
import pytest

import cadsweep as cs

from ..commands import as_program
from ..pictures import skip_where_nothing_draws

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [
    pytest.mark.cad,
    pytest.mark.timeout(900),
    pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX"),
]

SCRIPT = """
import cadquery as cq
width = 3.0
show_object(cq.Workplane().box(width, 2, 1).faces(">Z").workplane().hole(0.8))
"""

KEYS = {
    "n_nodes",
    "n_hexes",
    "min_scaled_jacobian",
    "mean_scaled_jacobian",
    "n_inverted",
    "volume",
    "cad_volume",
    "distance",
    "seconds",
    "sweeps",
}


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """A folder with a script, a part that is refused, and the mesh of the script, made by the command line."""
    folder = tmp_path_factory.mktemp("work")
    (folder / "part.py").write_text(SCRIPT)
    (folder / "crossing.py").write_text(
        "import cadquery as cq\nblock = cq.Workplane().box(20, 20, 20).faces('>Z').hole(5)\n"
        "show_object(block.faces('>X').workplane().hole(5))\n"
    )
    done = as_program("mesh", "part.py", "-o", "part.vtu", "--size", "0.3", "--layers", "4", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "answer.json").write_text(done.stdout)
    assert done.stderr == ""
    return folder


def few_lines(done):
    assert done.returncode == 1
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) <= 3, done.stderr
    assert len(done.stderr) <= 450
    return done.stderr


def test_json_is_one_object_with_the_promised_keys(work):
    answer = json.loads((work / "answer.json").read_text())
    assert set(answer) >= KEYS
    assert answer["n_inverted"] == 0
    assert 0 < answer["min_scaled_jacobian"] <= answer["mean_scaled_jacobian"] <= 1
    (sweep,) = answer["sweeps"]
    assert {"source", "target", "layers"} <= set(sweep)
    assert sweep["layers"] == 4
    assert answer["volume"] == pytest.approx(6 - np.pi * 0.16, rel=0.01)
    assert answer["cad_volume"] == pytest.approx(6 - np.pi * 0.16, rel=1e-9)
    assert all(value >= 0 for value in answer["seconds"].values())
    mesh = cs.read(work / "part.vtu")
    assert (mesh.n_nodes, mesh.n_hexes) == (answer["n_nodes"], answer["n_hexes"])


def test_a_parameter_reaches_the_script_and_quiet_is_silent(work):
    args = ["mesh", "part.py", "-o", "wide.vtu", "--param", "width=6", "--size", "0.5", "--quiet"]
    done = as_program(*args, cwd=work)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert np.ptp(cs.read(work / "wide.vtu").points[:, 0]) == pytest.approx(6.0)


def test_what_cannot_be_swept_is_three_short_lines_and_no_file(work, command):
    before = sorted(os.listdir(work))
    # What is in the way, its place and what to do come first; programs get them apart.
    refused = ("mesh", "crossing.py", "-o", "crossing.vtu", "--no-decompose")
    line = few_lines(as_program(*refused, cwd=work))
    said = r"cadsweep: the solid is no sweep.*\nwhere: face \d+ \(cylinder at [^)]+\).*\ntry: leave --no-decompose out"
    assert re.match(said, line)
    told = command(*refused, "--json", cwd=work)
    assert told.returncode == 1
    error = json.loads(told.stdout)["error"]
    assert error["type"] == "NotSweepableError"
    assert error["hint"].startswith("leave --no-decompose out")
    assert command(*refused[:-1], cwd=work).returncode == 0  # what is advised helps
    (work / "crossing.vtu").unlink()
    assert f"face {error['faces'][0]} " in line
    assert "absent.step" in few_lines(command("mesh", "absent.step", "-o", "absent.vtu", cwd=work))
    words = few_lines(command("mesh", "part.py", "-o", "x.vtu", "--param", "wdth=6", cwd=work))
    assert "wdth" in words
    assert "width = 3.0" in words
    assert sorted(os.listdir(work)) == before


def test_info_shows_faces_sweeps_and_reasons(work, command):
    done = command("info", "part.py", cwd=work)
    assert done.returncode == 0
    for word in ("cylinder", "source", "target", "area"):
        assert word in done.stdout
    data = json.loads(command("info", "part.py", "--json", cwd=work).stdout)
    roles = {face["role"] for face in data["faces"]}
    assert {"source", "target", "linking side"} <= roles
    assert sum(face["area"] for face in data["faces"] if face["role"] == "source") == pytest.approx(
        6 - np.pi * 0.16, rel=1e-6
    )
    assert data["sweeps"]


def test_the_report_of_a_refused_part_is_a_page_about_it(work, command):
    done = command("report", "crossing.py", "-o", "crossing.html", "--no-decompose", "--json", cwd=work)
    assert done.returncode == 1
    assert "crossing.html shows the faces in question" in json.loads(done.stdout)["error"]["message"]
    assert "Faces in question" in (work / "crossing.html").read_text(encoding="utf-8")


def test_info_of_what_cannot_be_swept_succeeds_with_reasons(work, command):
    done = command("info", "crossing.py", cwd=work)
    assert done.returncode == 0
    assert "No sweep" in done.stdout
    data = json.loads(command("info", "crossing.py", "--json", cwd=work).stdout)
    assert data["sweeps"] == []
    assert len(data["rejected"]) == len(data["faces"])


def test_check_tells_a_valid_mesh_from_one_that_is_not(work, command):
    done = command("check", "part.vtu", cwd=work)
    assert done.returncode == 0
    assert "valid" in done.stdout
    data = json.loads(command("check", "part.vtu", "--json", cwd=work).stdout)
    assert data["valid"] is True
    assert data["n_inverted"] == 0
    mesh = cs.read(work / "part.vtu")
    mesh.points[mesh.hexes[0, 0]] += 10.0
    mesh.write(work / "spoilt.vtu")
    done = command("check", "spoilt.vtu", "--json", cwd=work)
    assert done.returncode == 1
    assert json.loads(done.stdout)["valid"] is False


def test_check_of_what_is_no_mesh_is_few_lines(work, command):
    (work / "letter.vtu").write_text("Dear friend")
    few_lines(command("check", "letter.vtu", cwd=work))
    few_lines(command("check", "absent.vtu", cwd=work))


def test_factors_expand_to_the_same_bytes(work, command):
    options = ["--size", "0.3", "--layers", "4", "--quiet"]
    assert command("mesh", "part.py", "-o", "part.sweep.npz", *options, cwd=work).returncode == 0
    assert command("expand", "part.sweep.npz", "-o", "again.vtu", "--quiet", cwd=work).returncode == 0
    assert cs.read(work / "again.vtu").points.tobytes() == cs.read(work / "part.vtu").points.tobytes()
    few_lines(command("expand", "part.vtu", "-o", "again.vtu", cwd=work))


def test_a_streamed_mesh_is_announced_like_any_other(work, command):
    done = command(
        "mesh", "part.py", "-o", "part.vtkhdf", "--stream", "--size", "0.3", "--layers", "4", "--json", cwd=work
    )
    assert done.returncode == 0, done.stderr
    answer, other = json.loads(done.stdout), json.loads((work / "answer.json").read_text())
    assert set(answer) >= KEYS
    assert [answer[k] for k in ("n_nodes", "n_hexes")] == [other[k] for k in ("n_nodes", "n_hexes")]
    assert command("mesh", "part.py", "-o", "part.msh", "--stream", cwd=work).returncode == 2


def test_a_terminal_sees_progress_and_a_pipe_does_not(work):
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "cadsweep", "mesh", "part.py", "-o", "bar.vtu", "--size", "0.06"],
        stdout=subprocess.PIPE, stderr=theirs, cwd=work, env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
    )  # fmt: skip
    os.close(theirs)
    seen = b""
    end = time.monotonic() + 200
    while time.monotonic() < end:
        if select.select([ours], [], [], 0.1)[0]:
            try:
                seen += os.read(ours, 65536)
            except OSError:  # the other end is closed
                break
        elif process.poll() is not None:
            break
    out, _ = process.communicate()
    os.close(ours)
    assert process.returncode == 0
    assert b"cad" in seen  # importing CadQuery takes more than a second
    assert b"hexes" in out
    assert b"\x1b" not in out


def test_output_into_a_closed_pipe_is_no_traceback(work):
    line = f"{sys.executable} -m cadsweep check part.vtu | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, cwd=work, timeout=800, check=False)
    assert "Traceback" not in done.stderr


def test_a_picture_and_a_page(work, command):
    skip_where_nothing_draws()
    pytest.importorskip("plotly")
    done = command("view", "part.vtu", "--screenshot", "part.png", cwd=work)
    assert done.returncode == 0, done.stderr
    assert (work / "part.png").read_bytes().startswith(b"\x89PNG")
    done = command("report", "part.py", "-o", "part.html", "--size", "0.4", "--json", cwd=work)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["valid"]
    assert said["file"] == "part.html"
    page = (work / "part.html").read_text(encoding="utf-8")
    assert "cadsweep report part.py -o part.html" in page


def test_a_family_is_numbered_files_and_a_table(tmp_path, command):
    (tmp_path / "disc.py").write_text("import cadquery as cq\nshow_object(cq.Workplane().circle(1).extrude(1))\n")
    options = ["mesh", "disc.py", "-o", "disc.vtu", "--size", "0.5", "--allow-coarse", "--family", "3"]
    done = command(*options, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert [os.path.basename(row["file"]) for row in said["family"]] == ["disc.vtu", "disc_1.vtu", "disc_2.vtu"]
    for row in said["family"]:
        assert cs.read(row["file"]).n_hexes == row["n_hexes"]
    assert said["convergence"]["volume"]["order"] == pytest.approx(2.0, abs=0.1)
    assert command("mesh", "disc.py", "-o", "x.sweep.npz", "--family", "3", cwd=tmp_path).returncode == 2
