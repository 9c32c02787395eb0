"""Files and scripts: what is read, in which units, and how each kind of damage is refused."""

import os
import random
import re
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from cadsweep.cad import load  # noqa: E402
from cadsweep.errors import CadError, CadSweepError, InputError  # noqa: E402


@pytest.fixture(scope="module")
def box_step(tmp_path_factory):
    path = tmp_path_factory.mktemp("step") / "box.step"
    cq.exporters.export(cq.Workplane().box(1, 2, 3), str(path))
    return path.read_text()


def model_volume(part):
    return part.solids[0].volume * part.scale**3


@pytest.mark.parametrize("suffix", ["step", "stp", "brep", "STEP"])
def test_files_of_a_box(suffix, tmp_path):
    path = tmp_path / f"part.{suffix}"
    shape = cq.Workplane().box(1, 2, 3)
    if suffix == "brep":
        shape.val().exportBrep(str(path))
    else:
        cq.exporters.export(shape, str(path), exportType="STEP")
    part = load(str(path))
    assert part.solids[0].volume == pytest.approx(6.0)
    assert part.name == "part"


def test_iges_faces_are_sewn(tmp_path):
    from OCP.IGESControl import IGESControl_Writer

    writer = IGESControl_Writer()
    writer.AddShape(cq.Workplane().box(1, 2, 3).val().wrapped)
    writer.ComputeModel()
    writer.Write(str(tmp_path / "box.igs"))
    part = load(tmp_path / "box.igs")
    assert part.solids[0].volume == pytest.approx(6.0)
    assert any("sewn" in note for note in part.notes)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere names of files are text")
@pytest.mark.parametrize("suffix", ["step", "brep"])
def test_a_name_that_is_no_utf_8(suffix, tmp_path, box_step):
    path = tmp_path / os.fsdecode(b"K\xf6rper." + suffix.encode())
    if suffix == "step":
        path.write_text(box_step)
    else:
        cq.Workplane().box(1, 2, 3).val().exportBrep(str(tmp_path / "box.brep"))
        (tmp_path / "box.brep").rename(path)
    assert load(path).solids[0].volume == pytest.approx(6.0)


MILLIMETRE = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
INCH = f"""( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9003) );
#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9002);
#9002 = {MILLIMETRE}
#9003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"""


@pytest.mark.parametrize(
    ("unit", "length"),
    [(INCH, 25.4), (MILLIMETRE.replace(".MILLI.", "$"), 1000.0), (MILLIMETRE, 1.0)],
    ids=["inch", "metre", "millimetre"],
)
def test_lengths_are_millimetres_whatever_the_file_says(unit, length, tmp_path, box_step):
    path = tmp_path / "box.step"
    assert MILLIMETRE in box_step
    path.write_text(box_step.replace(MILLIMETRE, unit))
    part = load(path)
    assert model_volume(part) == pytest.approx(6.0 * length**3, rel=1e-9)
    assert any("millimetres" in note for note in part.notes) == (unit != MILLIMETRE)


@pytest.mark.parametrize(("prefix", "millimetres"), [("NANO", 1e-6), ("MICRO", 1e-3), ("KILO", 1e6), ("GIGA", 1e12)])
def test_tiny_and_huge_units_lose_nothing(prefix, millimetres, tmp_path, box_step):
    path = tmp_path / "box.step"
    path.write_text(box_step.replace(".MILLI.", f".{prefix}."))
    part = load(path)
    assert model_volume(part) == pytest.approx(6.0 * millimetres**3, rel=1e-9)
    assert len(part.solids[0].faces) == 6


@pytest.mark.parametrize(
    "change",
    [
        lambda t: "\ufeff" + t,
        lambda t: t.replace("\n", "\r\n"),
        lambda t: re.sub(
            r"FILE_NAME\(.*?\);", "FILE_NAME('a','2020-12-07','Ann','','','','');", t, count=1, flags=re.S
        ),
        lambda t: re.sub(
            r"FILE_NAME\(.*?\);", "FILE_NAME('a','2020-12-07',(''),(''),'','',$);", t, count=1, flags=re.S
        ),
        lambda t: re.sub(r"FILE_NAME\(.*?\);", "FILE_NAME('a');", t, count=1, flags=re.S),
    ],
    ids=["bom", "crlf", "author no list", "no authorisation", "short header"],
)
def test_harmless_oddities(change, tmp_path, box_step):
    path = tmp_path / "box.step"
    path.write_bytes(change(box_step).encode())
    assert load(path).solids[0].volume == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("SOLID_ANGLE_UNIT()", "SOLID_ANGLE_UNIT($)", "SiUnitAndSolidAngleUnit: Count of Parameters"),
        ("SI_UNIT($,.STERADIAN.)", "SI_UNIT(.STERADIAN.)", "SiUnitAndSolidAngleUnit: Count of Parameters"),
        ("PRODUCT_CONTEXT('',", "PRODUCT_CONTEXT(", "Context: Count of Parameters"),
        ("ENDSEC;\nEND-ISO", "#9001=REPRESENTATION('density',(#9001),#9);\nENDSEC;\nEND-ISO", "illegal type"),
        ("ENDSEC;\nEND-ISO", "#9001=SHAPE_REPRESENTATION('',(#1),#9);\nENDSEC;\nEND-ISO", "illegal type"),
    ],
)
def test_faults_beside_the_geometry_become_a_note(old, new, reason, tmp_path, box_step):
    path = tmp_path / "box.step"
    assert old in box_step
    path.write_text(box_step.replace(old, new))
    part = load(path)
    assert model_volume(part) == pytest.approx(6.0)
    assert any(reason in note for note in part.notes)


def test_exponents_may_have_three_digits_as_some_programs_write_them(tmp_path, box_step):
    path = tmp_path / "box.step"
    path.write_text(re.sub(r"(?<=[(,])(-?[\d.]+\.\d*)(?=[,)])", r"\1E+000", box_step))
    assert path.read_text().count("E+000") > 50
    assert model_volume(load(path)) == pytest.approx(6.0)


def test_what_follows_the_end_of_a_file_is_no_part_of_it(tmp_path, box_step):
    path = tmp_path / "box.step"
    path.write_text(box_step + 9999 * "\n")
    assert model_volume(load(path)) == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda t: "", "empty"),
        (lambda t: "solid box\n" * 99, "not a STEP file"),
        (lambda t: "version https://git-lfs.github.com/spec/v1\noid sha256:9d89\nsize 136108\n", "git lfs pull"),
        (lambda t: t[: len(t) // 10], "cut off"),
        (lambda t: t[: len(t) // 2], "cut off"),
        (lambda t: t[: len(t) * 9 // 10], "cut off"),
        (lambda t: t.replace("(0.,0.,0.)", "(nan,0.,0.)"), "line .* not finite"),
        (lambda t: t.replace("(0.,0.,0.)", "(1.E+300,0.,0.)"), "line .* above 1e30"),
        (lambda t: t.replace("(0.,0.,0.)", "(1.E+031,0.,0.)"), "line .* above 1e30"),
        (lambda t: t.replace("ORIENTED_EDGE('',*,*,#2", "ORIENTED_EDGE('',*,*,#9992", 1), "damaged"),
        (lambda t: t.replace("#20 = ORIENTED_EDGE('',*,*,#21", "#20 = ORIENTED_EDGE('',*,*,#20"), "refers to itself"),
        (lambda t: t.replace("CARTESIAN_POINT", "CARTESIAN_P\x01OINT", 1), "damaged"),
        (lambda t: t.replace("LENGTH_UNIT()", "LENGTH_UNIT($)"), "damaged: SiUnitAndLengthUnit"),
        (lambda t: t.replace("PLANE_ANGLE_UNIT()", "PLANE_ANGLE_UNIT($)"), "damaged: SiUnitAndPlaneAngleUnit"),
    ],
)
def test_damaged_step_files_are_refused_with_a_reason(change, reason, tmp_path, box_step):
    path = tmp_path / "box.step"
    assert change(box_step) != box_step
    path.write_text(change(box_step))
    with pytest.raises(CadSweepError, match=reason):
        load(path)


def test_flipped_bytes_end_in_a_box_or_an_error(tmp_path, box_step):
    # A crash here takes the interpreter with it; all seeds of a larger set ended in an error.
    rng = random.Random(7)
    path = tmp_path / "box.step"
    outcomes = []
    for _ in range(40):
        data = bytearray(box_step.encode())
        data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(data)
        try:
            volume = load(path).solids[0].volume
        except CadSweepError as error:
            outcomes.append(str(path) in str(error))
        else:
            outcomes.append(volume > 0)
    assert len(outcomes) == 40
    assert all(outcomes)


@pytest.mark.parametrize("suffix", [".brep", ".igs"])
@pytest.mark.parametrize("text", ["", "no model\n", "DBRep_DrawableShape\n\nCASCADE Topology V1\n"])
def test_damaged_brep_and_iges_files(suffix, text, tmp_path):
    path = tmp_path / f"part{suffix}"
    path.write_text(text)
    with pytest.raises(CadSweepError):
        load(path)


SCRIPT = """import cadquery as cq
height = 3.0
n_holes = 2
round = False
name = "x"
result = cq.Workplane().box(1, 2, height)
print("hello")
show_object(result)
"""


@pytest.fixture
def script(tmp_path):
    def write(text):
        path = tmp_path / "model.py"
        path.write_text(text)
        return path

    return write


def test_a_script_and_its_parameters(script, capfd):
    assert load(script(SCRIPT)).solids[0].volume == pytest.approx(6.0)
    assert load(script(SCRIPT), params={"height": "4"}).solids[0].volume == pytest.approx(8.0)
    assert capfd.readouterr().out == ""


def test_whole_numbers_stay_whole(script):
    text = "import cadquery as cq\nn = 2\nfor _ in range(n): pass\nshow_object(cq.Workplane().box(1, 1, n))\n"
    assert load(script(text), params={"n": "3"}).solids[0].volume == pytest.approx(3.0)


def test_a_script_that_shows_nothing_gives_what_it_calls_result(script):
    part = load(script("import cadquery as cq\nresult = cq.Workplane().box(1, 2, 3)\n"))
    assert part.solids[0].volume == pytest.approx(6)
    assert any("'result'" in note for note in part.notes)


def test_negative_and_annotated_parameters(script):
    text = "import cadquery as cq\nlow = -1.0\nhigh: float = 2\nshow_object(cq.Workplane().box(1, 1, high - low))\n"
    assert load(script(text)).solids[0].volume == pytest.approx(3.0)
    assert load(script(text), params={"low": "-2", "high": 4}).solids[0].volume == pytest.approx(6.0)


@pytest.mark.parametrize(
    "params", [{"depth": 1}, {"height": "tall"}, {"height": float("nan")}, {"round": "perhaps"}, {"name": 3}]
)
def test_wrong_parameters_list_the_right_ones(params, script):
    with pytest.raises(InputError, match=r"height = 3.0 \(number\)"):
        load(script(SCRIPT), params=params)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            "import cadquery as cq\nx = 1\nraise RuntimeError('no luck')\n",
            "line 3: the script raises RuntimeError: no luck",
        ),
        ("def f(:\n", "line 1: this is no Python"),
        ("import sys\nsys.exit(3)\n", "line 2: the script ends the program"),
        ("x = 1\n", "shows nothing"),
        ("import cadquery as cq\nb = cq.Workplane().box(1,1,1)\nshow_object(b)\nshow_object(b)\n", "shows 2 objects"),
        ("show_object(5)\n", "no shape"),
        ("import cadquery as cq\nshow_object(cq.Workplane())\n", "no shape"),
        ("raise MemoryError\n", "MemoryError"),
    ],
)
def test_scripts_that_fail_say_where(text, reason, script):
    path = script(text)
    with pytest.raises((InputError, CadError)) as refusal:
        load(path)
    assert re.search(reason, refusal.value.message)
    assert str(refusal.value).startswith(str(path))


def test_a_folder_is_called_one(tmp_path):
    with pytest.raises(InputError, match="this is a folder"):
        load(tmp_path)


def test_a_script_that_prints_without_end_fills_nothing(script, capfd, caplog):
    text = "import cadquery as cq\nfor _ in range(2000): print('x' * 1000)\nshow_object(cq.Workplane().box(1, 1, 1))\n"
    with caplog.at_level("INFO"):
        assert load(script(text)).solids[0].volume == pytest.approx(1.0)
    assert capfd.readouterr() == ("", "")
    assert sum(len(record.getMessage()) for record in caplog.records) < 20_000


def test_parameters_belong_to_scripts(tmp_path, box_step):
    path = tmp_path / "box.step"
    path.write_text(box_step)
    with pytest.raises(InputError, match="nly scripts"):
        load(path, params={"height": 1})
    with pytest.raises(InputError, match="nly scripts"):
        load(cq.Workplane().box(1, 1, 1), params={"height": 1})


@pytest.fixture
def stand(tmp_path, monkeypatch):
    """A STEP file of an assembly, with each of its two boxes in a file of its own, in a folder below."""
    from cadquery.occ_impl.assembly import toCAF
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType

    (tmp_path / "models").mkdir()
    monkeypatch.chdir(tmp_path / "models")
    lid = cq.Workplane().box(2, 2, 1).translate((0, 0, 2))
    _, document = toCAF(
        cq.Assembly(name="stand").add(cq.Workplane().box(1, 2, 3), name="foot").add(lid, name="lid"), True
    )
    writer = STEPCAFControl_Writer()
    writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs, "own_")
    writer.Write("stand.step")
    monkeypatch.chdir(tmp_path)
    return Path("models/stand.step")


def test_a_step_file_may_refer_to_others_in_its_folder(stand):
    assert [solid.volume for solid in load(stand).solids] == pytest.approx([6.0, 4.0])
    assert load(stand.absolute()).owners == load(stand).owners == (0, 1)


def test_step_files_that_another_one_refers_to_are_missed_by_name(stand):
    (stand.parent / "own_lid.stp").unlink()
    part = load(stand)
    assert part.solids[0].volume == pytest.approx(6.0)
    assert any("own_lid.stp" in note and "own_foot" not in note for note in part.notes)
    (stand.parent / "own_foot.stp").unlink()
    with pytest.raises(CadError, match=r"own_foot\.stp, own_lid\.stp.* into its folder"):
        load(stand)


def test_the_end_of_a_brep_file_of_old_programs(tmp_path):
    path = tmp_path / "box.brep"
    cq.Workplane().box(1, 2, 3).val().exportBrep(str(path))
    path.write_bytes(path.read_bytes().rstrip() + b"\n0\n")
    assert load(path).solids[0].volume == pytest.approx(6.0)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_brep_files_that_are_cut_off(share, tmp_path):
    path = tmp_path / "box.brep"
    cq.Workplane().box(1, 2, 3).val().exportBrep(str(path))
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(CadError, match=r"damaged|cut off|not a BREP"):
        load(path)


def test_every_byte_that_is_no_number_is_found_in_a_brep_file(tmp_path):
    from cadsweep.cad.read.brep_text import check_brep_text

    path = tmp_path / "box.brep"
    cq.Workplane().box(1, 2, 3).faces(">Z").workplane().hole(0.5).val().exportBrep(str(path))
    data = path.read_bytes()
    check_brep_text(path, data)
    rng = random.Random(11)
    for _ in range(50):
        damaged = bytearray(data)
        damaged[rng.randrange(data.index(b"Locations"), len(data))] = rng.randrange(128, 256)
        with pytest.raises(CadError):
            check_brep_text(path, bytes(damaged))
