"""Bad input of every kind ends in an error of its own that says what, where and what to try."""

import math
import os
import re

import pytest

import cadsweep
from cadsweep.errors import CadSweepError, InputError

from .bad_files import HARMLESS, TEXTS, in_unit
from .bad_scripts import GEOMETRY, HANGS, HARMLESS_SCRIPTS, HOSTILE, SCALES, SCRIPTS, far_box, scaled_plate
from .damaged import FAMILY, flipped, write_parts
from .many import mesh_all

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(900)]

N_FLIPS = int(os.environ.get("CADSWEEP_FUZZ", "10"))

LONG = "CADSWEEP_LONG" in os.environ

NAMED = {name for name in dir(cadsweep) if name.endswith("Error")}

STEP_ERRORS = {
    "empty": "empty",
    "blank": "empty",
    "not_step": "not a STEP file",
    "html": "not a STEP file",
    "header_only": "no shape|ENDSEC",
    "truncated_10": "cut off",
    "truncated_50": "cut off",
    "truncated_90": "cut off",
    "nan": "line 35.*not finite",
    "huge": "line 35.*1e30",
    "overflow": "line 35.*1e30",
    "moved_corner": "invalid.*face",
    "dangling": "#999999",
    "cyclic": "refers to itself",
    "missing_face": "face is missing",
    "no_solid": "solid",
    "zeros": "empty|not a STEP file",
}


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    """The family of good parts as STEP files."""
    return write_parts(tmp_path_factory.mktemp("steps"))


@pytest.fixture(scope="module")
def ends(steps, tmp_path_factory):
    """How every bad file, bad script and hard geometry ends; all of them are run in a few workers."""
    folder = tmp_path_factory.mktemp("bad")
    good = steps["box"].read_text()
    paths = {}
    for name, change in {**TEXTS, **HARMLESS}.items():
        paths[name] = folder / f"{name}.step"
        paths[name].write_text(change(good), encoding="utf-8", newline="")
    sources = {f"script_{name}": text for name, (text, _) in SCRIPTS.items()}
    sources |= {f"geometry_{name}": text for name, (text, _) in GEOMETRY.items()}
    sources |= {f"good_{name}": text for name, text in HARMLESS_SCRIPTS.items()}
    sources |= {f"scale_{scale:g}": scaled_plate(scale) for scale in SCALES}
    sources |= {f"far_{offset:g}": far_box(offset) for offset in (1e4, 1e7)}
    for name, text in sources.items():
        paths[name] = folder / f"{name}.py"
        paths[name].write_bytes(text.encode("latin-1" if name.endswith("latin_1") else "utf-8"))
    return dict(zip(paths, mesh_all(list(paths.values())), strict=True))


def refused(end, words):
    kind, message, *_ = end
    assert kind in NAMED, end
    assert message.strip()
    pattern = re.compile(words, re.DOTALL)
    assert pattern.search(message), message


@pytest.mark.parametrize("name", TEXTS)
def test_a_bad_step_file_is_refused_with_its_own_reason(ends, name):
    refused(ends[name], STEP_ERRORS[name])


@pytest.mark.parametrize("name", HARMLESS)
def test_what_does_no_harm_does_none(ends, name):
    assert ends[name][0] == "mesh", ends[name]
    assert math.isclose(ends[name][3], 6.0, rel_tol=1e-9)


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_bad_script_is_refused_with_its_own_reason(ends, name):
    refused(ends[f"script_{name}"], SCRIPTS[name][1] or ".")


@pytest.mark.parametrize("name", HARMLESS_SCRIPTS)
def test_an_odd_script_that_shows_a_box_is_meshed(ends, name):
    assert ends[f"good_{name}"][0] == "mesh", ends[f"good_{name}"]


@pytest.mark.parametrize("name", GEOMETRY)
def test_hard_geometry_is_meshed_validly_or_refused_by_name(ends, name):
    end, words = ends[f"geometry_{name}"], GEOMETRY[name][1]
    if words is not None or end[0] != "mesh":
        refused(end, words or ".")


@pytest.mark.parametrize("scale", SCALES)
def test_every_scale_is_meshed_or_refused_by_name(ends, scale):
    kind, message, _, volume = ends[f"scale_{scale:g}"]
    if 1e-6 <= scale <= 1e6:
        assert kind == "mesh", message
        assert math.isclose(volume, (12 - math.pi * 0.49) * scale**3, rel_tol=0.01)
    else:
        assert kind == "mesh" or kind in NAMED


@pytest.mark.parametrize("offset", [1e4, 1e7])
def test_a_part_far_from_the_origin_is_meshed(ends, offset):
    kind, message, _, volume = ends[f"far_{offset:g}"]
    assert kind == "mesh", message
    assert math.isclose(volume, 6.0, rel_tol=1e-6)


@pytest.mark.parametrize(("unit", "factor"), [("metre", 1000.0), ("inch", 25.4)])
def test_a_file_in_other_units_is_read_in_millimetres(steps, tmp_path, unit, factor):
    path = tmp_path / "box.step"
    path.write_text(in_unit(steps["box"].read_text(), unit))
    mesh = cadsweep.sweep_mesh(path, layers=2)
    assert math.isclose(mesh.quality().volume, 6.0 * factor**3, rel_tol=1e-9)


@pytest.mark.parametrize("name", HOSTILE if LONG else [name for name in HOSTILE if name not in HANGS[1:]])
def test_a_hostile_script_ends_with_its_worker(tmp_path, name):
    text, words = HOSTILE[name]
    path = tmp_path / "script.py"
    path.write_text(text)
    timeout = 12.0 if name in HANGS else 250.0
    with pytest.raises(CadSweepError, match=words):
        cadsweep.sweep_mesh(str(path), isolated=True, timeout=timeout, max_memory=1.5)


@pytest.mark.parametrize(
    "options",
    [
        {"size": 0},
        {"size": -1.0},
        {"size": math.nan},
        {"size": math.inf},
        {"size": "2"},
        {"size": True},
        {"layers": 0},
        {"layers": -1},
        {"layers": 1.5},
        {"layers": 10**9},
        {"bias": 0},
        {"bias": 1e6},
        {"bias": math.nan},
        {"bias": (1, 2, 3)},
        {"fractions": [0, 1, 0.5]},
        {"functional": "K"},
        {"strategy": "best"},
        {"order": 3},
        {"sizes": {"source": 0}},
        {"sizes": 2.0},
        {"counts": {"edge 1": 1.5}},
        {"counts": {"edge 1": 0}},
        {"rail_layers": {"span 1": True}},
        {"rail_layers": 3},
        {"max_hexes": 0},
        {"colour": "red"},
        {"timeout": 3.0},
    ],
    ids=str,
)
def test_bad_options_are_refused_before_anything_is_read(options):
    with pytest.raises(InputError):
        cadsweep.sweep_mesh("absent.step", **options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"size": 1e-9}, "hexes.*try size"),
        ({"size": 1e-300}, "hexes.*raise the limit"),
        ({"layers": 10**8}, "hexes.*layers"),
        ({"size": 0.05, "max_hexes": 1000}, "1,000 hexes.*try size"),
        ({"sizes": {"absent": 1.0}}, "absent"),
        ({"counts": {"absent": 3}}, "No edge matches 'absent'.*edge 0 to edge 11"),
        ({"counts": {"faces:>Z": 3}}, "choice of edges"),
        ({"counts": {"edge 0": 10**12}}, "hexes.*raise the limit"),
        ({"rail_layers": {"span 2": 3}}, "no span 2"),
        ({"rail_layers": {"edges:|X": 3, "edges:|Y": 4}}, r"not run along the\ssweep"),
        ({"source": "absent"}, "absent"),
        ({"source": 99}, "99"),
        ({"source": 1, "target": 1}, "."),
        ({"params": {"w": 1}}, "script"),
    ],
    ids=str,
)
def test_options_that_do_not_fit_the_part_are_refused_at_once(steps, options, words):
    with pytest.raises(CadSweepError, match=f"(?s){words}"):
        cadsweep.sweep_mesh(steps["box"], **options)


def test_flipped_bytes_end_in_a_valid_mesh_or_a_named_error(steps, tmp_path):
    """CADSWEEP_FUZZ=300 runs the whole of it."""
    sources = []
    for seed in range(N_FLIPS):
        name = FAMILY[seed % len(FAMILY)]
        sources.append(tmp_path / f"{name}_{seed}.step")
        sources[-1].write_bytes(flipped(steps[name].read_bytes(), seed))
    ends = mesh_all(sources, size=0.5)
    wrong = {path.name: end for path, end in zip(sources, ends, strict=True) if end[0] not in NAMED | {"mesh"}}
    assert not wrong
