"""Every refusal is read: at most three short lines that name a face or a place, and what they advise helps."""

import json
import re
from pathlib import Path

import pytest

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadsweep as cs  # noqa: E402
from cadsweep.brief import MOST_LINES, in_lines  # noqa: E402
from cadsweep.cli.failure import describe_failure, in_command_words  # noqa: E402
from cadsweep.errors import InputError  # noqa: E402

from ..commands import as_program  # noqa: E402

pytestmark = pytest.mark.cad

MOST_IN_ALL = 450
PARTS = Path(__file__).parents[1] / "parts"
UNSWEEPABLE = sorted((PARTS / "unsweepable").glob("*.py"))
PLACE = re.compile(r"\b(face|edge|cell|solid|axis)\b.*\d|\(-?\d")


def is_read(error):
    """Three short lines with a place."""
    said = f"cadsweep: {in_command_words(str(error))}"
    assert len(said) <= MOST_IN_ALL
    assert len(said.splitlines()) <= MOST_LINES
    assert PLACE.search(said), said
    return said


def follow(part, error):
    """Mesh the part with the option that a refusal advises; whether it advises one."""
    options = {}
    for name in ("suppress", "cuts"):
        found = re.search(rf"{name}=\[([^\]]*)\]", error.try_)
        if found:
            options[name] = [word.strip("' ") for word in found[1].split(",")]
    found = re.search(r"size=([\d.e-]+)", error.try_)
    if found:
        options["size"] = float(found[1])
    if "decompose=False out" not in error.try_:
        options["decompose"] = False
    if not options and "decompose" not in error.try_:
        return False
    assert cs.sweep_mesh(part, **options).quality().valid
    return True


@pytest.mark.parametrize("path", UNSWEEPABLE, ids=lambda path: path.stem)
@pytest.mark.parametrize("decompose", [True, False])
def test_a_part_that_cannot_be_meshed_is_refused_in_three_short_lines(path, decompose):
    try:
        cs.sweep_mesh(path, decompose=decompose)
    except cs.CadSweepError as error:
        is_read(error)
        if "suppress=" in error.try_ or "cuts=" in error.try_ or "decompose=" in error.try_:
            follow(cs.load(path), error)


def test_what_is_advised_was_seen_to_help():
    """Two bores that cross: nothing but cuts helps, and these were not allowed."""
    block = cq.Workplane().box(20, 20, 20).faces(">Z").hole(5).faces(">X").workplane().hole(5)
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.sweep_mesh(block, decompose=False)
    is_read(refused.value)
    assert refused.value.faces
    assert len(refused.value.reasons) > MOST_LINES
    assert follow(cs.load(block), refused.value)


@pytest.mark.parametrize(("options", "words"), [
    ({"counts": {f"edge {j}": 3 + j for j in range(12)}, "layers": 4}, "counts"),
    ({"source": "face 0", "target": "face 2"}, "no sweep has"),
    ({"sizes": {"absent": 1.0}}, "No edge matches|No face matches"),
    ({"size": 1e-7}, "hexes"),
])  # fmt: skip
def test_what_is_asked_wrongly_is_refused_in_three_short_lines(options, words):
    with pytest.raises(cs.CadSweepError) as refused:
        cs.sweep_mesh(cq.Workplane().box(4, 3, 2), **options)
    said = f"cadsweep: {in_command_words(str(refused.value))}"
    assert len(said) <= MOST_IN_ALL
    assert len(said.splitlines()) <= MOST_LINES
    assert re.search(words, refused.value.message)


def test_programs_get_all_of_it(tmp_path):
    path = UNSWEEPABLE[0].with_name("lens.py")
    done = as_program("mesh", str(path), "-o", "lens.vtu", "--json", cwd=tmp_path)
    assert done.returncode == 1
    error = json.loads(done.stdout)["error"]
    assert len(done.stderr) <= MOST_IN_ALL
    assert len(done.stderr.strip().splitlines()) <= MOST_LINES
    assert len(error["reasons"]) > len(error["faces"]) > 0
    assert all(error[word] for word in ("what", "where", "hint"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("what", [
    "x" * 1000,
    "a word " * 200,
    "; ".join(f"face {j} (plane at 1, 2, 3) is no cap" for j in range(40)) + "; try another size",
])  # fmt: skip
def test_no_words_make_a_refusal_long_and_none_are_lost(what):
    error = InputError(what, where=what, try_=what)
    assert len(str(error)) + len("cadsweep: ") <= MOST_IN_ALL
    assert len(str(error).splitlines()) <= MOST_LINES
    assert error.message.count(what.split()[0]) >= 3
    assert len("\n".join(in_lines(what))) + len("cadsweep: ") <= MOST_IN_ALL
    assert describe_failure(error)["message"]


def test_the_last_clause_stays_since_it_says_what_to_try():
    what = "; ".join(f"face {j} (plane at 1, 2, 3) is no cap" for j in range(40)) + "; try another size"
    assert in_lines(what)[-1].endswith("try another size")
    assert in_lines(what)[0].startswith("face 0 ")
