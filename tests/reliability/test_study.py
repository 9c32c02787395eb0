"""A study file is understood or refused with the key that is wrong, before any case is begun."""

from pathlib import Path

import pytest

from cadsweep.batch import read_study
from cadsweep.errors import InputError


@pytest.fixture
def study(tmp_path):
    (tmp_path / "part.py").write_text("width = 1.0\n")
    (tmp_path / "part.step").write_text("ISO-10303-21;\n")

    def write(text):
        path = tmp_path / "study.toml"
        path.write_text(text)
        return path

    return write


def test_options_that_belong_together_may_stand_apart(study):
    text = 'script = "part.py"\n[options]\nnodes = 27\n[[cases]]\nwidth = 1.0\n'
    plan = read_study(study(text + "options.order = 2\n"))
    assert plan.cases[0].options == {"nodes": 27, "order": 2}
    with pytest.raises(InputError, match=r"case 1.*nodes=27 goes with order=2"):
        read_study(study(text))


def test_the_study_of_the_docs_is_read(study, tmp_path):
    page = Path(__file__).parents[2] / "docs" / "studies.md"
    text = page.read_text().split("```toml\n")[1].split("```")[0]
    (tmp_path / "elbow.py").write_text("bend_radius = 30.0\nangle = 90.0\nwall = 2.5\n")
    plan = read_study(study(text))
    assert len(plan.cases) == 3 * 2 * 2 + 1
    assert {case.options["layers"] for case in plan.cases} == {20}


def test_a_grid_is_every_combination_and_cases_come_after_it(study):
    plan = read_study(
        study(
            """
            script = "part.py"
            format = "msh"
            timeout = 60
            [options]
            layers = 5
            [grid]
            width = [1.0, 2.0, 3.0]
            options.size = [0.1, 0.2]
            [[cases]]
            name = "thin wall"
            wall = 0.5
            options.order = 2
            """
        )
    )
    assert len(plan.cases) == 3 * 2 + 1
    assert {(c.params["width"], c.options["size"]) for c in plan.cases[:-1]} == {
        (w, s) for w in (1.0, 2.0, 3.0) for s in (0.1, 0.2)
    }
    assert all(case.options["layers"] == 5 for case in plan.cases)
    assert plan.cases[-1].name == "thin_wall"
    assert plan.cases[-1].options == {"layers": 5, "order": 2}
    assert (plan.suffix, plan.timeout) == (".msh", 60.0)


def test_a_case_is_known_by_script_parameters_and_options(study, tmp_path):
    text = 'script = "part.py"\n[grid]\nwidth = [1, 2]\n'
    first = read_study(study(text)).cases
    assert [c.key for c in read_study(study(text.replace("[1, 2]", "[2, 1]"))).cases] == [c.key for c in first[::-1]]
    assert {c.key for c in read_study(study(text + "[options]\nlayers = 3\n")).cases}.isdisjoint(c.key for c in first)
    (tmp_path / "part.py").write_text("width = 1.5\n")
    assert {c.key for c in read_study(study(text)).cases}.isdisjoint(c.key for c in first)


def test_a_case_is_called_what_it_has_for_itself(study):
    text = """
        script = "part.py"
        [options]
        layers = 5
        [grid]
        width = [1.0, -2]
        sharp = [true]
        options.size = [0.1]
        [[cases]]
        note = "a b"
        [[cases]]
        note = "a/b"
        [[cases]]
        name = "thin wall"
        width = 1.0
        """
    cases = read_study(study(text)).cases
    names = [case.name for case in cases]
    assert names[:2] == ["width-1.0_sharp-true_size-0.1", "width--2_sharp-true_size-0.1"]
    assert names[2:] == [f"note-a_b_{cases[2].key[:8]}", f"note-a_b_{cases[3].key[:8]}", "thin_wall"]
    assert all(case.folder.endswith("_" + case.key[:8]) for case in cases)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("script = ", "not a TOML file"),
        ("[grid]\nw = [1]", "'script' must name"),
        ('script = "absent.py"\n[grid]\nw = [1]', "cannot read the script"),
        ('script = "part.py"', "no cases"),
        ('script = "part.py"\nsize = 1\n[grid]\nw = [1]', "(?s)no 'size'.*options"),
        ('script = "part.py"\n[grid]\nw = 1', "'w' must be a list"),
        ('script = "part.py"\n[grid]\nw = []', "'w' must be a list"),
        ('script = "part.py"\n[grid]\nw = [{a = 1}]', "'w' must be a number"),
        ('script = "part.py"\n[grid]\nw = [1979-05-27]', "'w' must be a number"),
        ('script = "part.py"\n[grid]\nw = [1, 1]', "are the same"),
        ('script = "part.py"\ngrid = 3', "must be a table"),
        ('script = "part.py"\ncases = 3', "must be a table"),
        ('script = "part.py"\n[options]\nsizze = 1\n[grid]\nw = [1]', "(?s)no 'sizze'.*size"),
        ('script = "part.py"\n[options]\nsize = -1\n[grid]\nw = [1]', "size must be a positive"),
        ('script = "part.py"\n[grid]\nw = [1]\noptions.layers = [0]', "layers must be"),
        ('script = "part.py"\ntimeout = 0\n[grid]\nw = [1]', "'timeout' must be"),
        ('script = "part.py"\nmax_memory = "much"\n[grid]\nw = [1]', "'max_memory' must be"),
        ('script = "part.step"\n[grid]\nw = [1]', "go with a CadQuery script"),
        ('script = "part.py"\n[[cases]]\nname = "a"\nw = 1\n[[cases]]\nname = "a"\nw = 2', "same name"),
        ('script = "part.py"\n[[cases]]\nname = 3', "'name' must be"),
        ('script = "part.py"\n[grid]\n' + "\n".join(f"p{i} = {list(range(10))}" for i in range(6)), "1,000,000"),
    ],
)
def test_a_wrong_study_is_refused_with_its_key(study, text, words):
    with pytest.raises(InputError, match=words):
        read_study(study(text))


def test_a_missing_or_binary_study_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        read_study(tmp_path / "absent.toml")
    (tmp_path / "bytes.toml").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="not a TOML file"):
        read_study(tmp_path / "bytes.toml")
