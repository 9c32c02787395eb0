"""What a failed command says to people and to programs, and how few notes there are."""

from __future__ import annotations

import json

import pytest

from cadsweep.cli.failure import describe_failure, in_command_words
from cadsweep.cli.show import few_notes
from cadsweep.errors import CadSweepError, InputError, NotSweepableError, PlanError

from ..commands import as_program


def test_a_failure_is_one_object_for_programs(tmp_path):
    done = as_program("mesh", "nothing.step", "-o", "a.vtu", "--json", cwd=tmp_path)
    assert done.returncode == 1
    error = json.loads(done.stdout)["error"]
    assert set(error) == {"type", "message", "what", "where", "hint", "faces", "reasons"}
    assert "nothing.step" in error["message"]
    assert done.stderr.strip().endswith(error["message"])


@pytest.mark.parametrize(("error", "hint", "faces"), [
    (InputError("the size is larger than the part; try a smaller one"), "try a smaller one", []),
    (CadSweepError("face 3 'top' (plane at 1, 2) and face 12 cross. Repair the model."), "Repair the model.", [3, 12]),
    (NotSweepableError("no sweep", reasons=["face 4: not closed", "faces 5, 6 and 9 differ"]), "", [4, 5, 6, 9]),
    (InputError("No face matches 'topp'; did you mean 'top'? There are: face 0 'top'."),
     "did you mean 'top'? There are: face 0 'top'.", []),
    (InputError("time-out: not done in 3 s; allow more time, or ask for less"), "allow more time, or ask for less", []),
    (InputError("'step' must be a positive number, not -1"), "'step' must be a positive number, not -1", []),
    (PlanError("no plan; cut it", faces=[(0, 7), (1, 2)]), "cut it", [2, 7]),
])  # fmt: skip
def test_what_to_try_and_the_faces_are_told_apart(error, hint, faces):
    told = describe_failure(error)
    assert (told["type"], told["hint"], told["faces"]) == (type(error).__name__, hint, faces)


@pytest.mark.parametrize(("python", "command"), [
    ("ask for a picture with screenshot='mesh.png'", "ask for a picture with --screenshot mesh.png"),
    ("try a smaller size or order=1", "try a smaller size or --order 1"),
    ("allow_inverted=True writes it", "--allow-inverted writes it"),
    ("max_hexes = 1000 is too few", "--max-hexes 1000 is too few"),
    ("the part has size 3", "the part has size 3"),
    ("cut it there: cuts=, or --cut", "cut it there: --cut"),
    ("skip=['pin', 'ball'] (--skip pin,ball) meshes the rest", "--skip pin,ball meshes the rest"),
    ("raise it: max_hexes=... (--max-hexes N, or --yes)", "raise it: --max-hexes N, or --yes"),
    ("cut it (cuts=['face 3', 'plane z=1'])", "cut it (--cut 'face 3' --cut 'plane z=1')"),
    ("leave out: suppress=['fillets r<2'] (4 fillets)", "leave out: --suppress 'fillets r<2' (4 fillets)"),
    ("choose one with part=, or fuse them", "choose one with --part, or fuse them"),
    ("counts: 'a' asks for 3; order=2, nodes=20", "--edge-count: 'a' asks for 3; --order 2, --nodes 20"),
])  # fmt: skip
def test_messages_speak_the_words_of_the_command_line(python, command):
    assert in_command_words(python) == command


def test_notes_are_one_line_a_kind():
    notes = [
        "relax 12 hexahedra of layers 1 to 2: worst scaled Jacobian -0.2 to 0.15",
        "untangle 12 hexahedra of layers 1 to 2: rolled back, worst stays 0.15",
        "polish 12 hexahedra of layers 1 to 2: worst scaled Jacobian 0.15 to 0.36",
        "polish 40 hexahedra of layers 0 to 8: worst scaled Jacobian 0.1 to 0.4",
        "name 'a b' became 'a_b'",
        "name 'c d' became 'c_d'",
        "the file is in inches",
    ]
    assert few_notes(notes) == [
        "smoothing: 2 places mended, worst -0.2 -> 0.36",
        "name 'a b' became 'a_b' (and 1 more like it: -v)",
        "the file is in inches",
    ]


def test_wrong_usage_is_told_to_programs_and_to_people(command, tmp_path):
    done = command("mesh", "a.step", "-o", "a.vtu", "--sise", "2", "--json", cwd=tmp_path)
    assert done.returncode == 2
    assert json.loads(done.stdout)["error"]["type"] == "UsageError"
    assert "--size" in json.loads(done.stdout)["error"]["hint"]
    assert "--size" in done.stderr


@pytest.mark.parametrize(("word", "meant"), [("mseh", "mesh"), ("veiw", "view"), ("raport", "report")])
def test_a_misspelled_command_gets_the_nearest_one(word, meant, command, tmp_path):
    done = command(word, cwd=tmp_path)
    assert done.returncode == 2
    assert f"did you mean '{meant}'?" in done.stderr


def test_check_holds_meshes_to_limits(tmp_path, command):
    import numpy as np

    from cadsweep.cells import HEX_FACES
    from cadsweep.io import write
    from cadsweep.mesh import HexMesh

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) * 1.0
    for name, stretch in (("cube", 1.0), ("bar", 5.0)):
        mesh = HexMesh(points=points * [1, 1, stretch], hexes=np.arange(8)[None], boundaries={"all": HEX_FACES})
        write(mesh, tmp_path / f"{name}.vtu")

    def check(*args):
        return command("check", *args, cwd=tmp_path)

    done = check("cube.vtu", "bar.vtu", "--strict", "--min-scaled-jacobian", "0.3")
    assert (done.returncode, done.stdout) == (0, "")
    done = check("cube.vtu", "bar.vtu", "--strict", "--max-aspect", "2")
    assert done.returncode == 1
    assert done.stdout.startswith("bar.vtu: the largest aspect ratio is 5")
    assert len(done.stdout.splitlines()) == 1
    (tmp_path / "cut.vtu").write_bytes((tmp_path / "cube.vtu").read_bytes()[:400])
    done = check("cut.vtu", "bar.vtu", "--strict", "--max-aspect", "2")
    assert done.returncode == 1
    assert [line.split(":")[0] for line in done.stdout.splitlines()] == ["cut.vtu", "bar.vtu"]
    done = check("cut.vtu", "cube.vtu", "--json")
    damaged, sound = map(json.loads, done.stdout.splitlines())
    assert (damaged["file"], damaged["passed"], sound["file"], sound["passed"]) == ("cut.vtu", False, "cube.vtu", True)
    assert damaged["error"]["type"] == "InputError"
