"""The site is built by one command, whole: strict MkDocs takes a dead link or an unknown name for an error."""

import importlib.util
import re
import subprocess
import sys

import pytest

from .docs_pages import ROOT

pytest.importorskip("material")
pytest.importorskip("mkdocstrings")
pytest.importorskip("mkdocs_click")


@pytest.mark.timeout(300)
def test_the_site_is_built_and_loads_nothing_from_the_network(tmp_path):
    command = [sys.executable, str(ROOT / "scripts" / "build_docs.py"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stderr
    functions = (tmp_path / "reference" / "functions.html").read_text()
    assert 'id="cadsweep.sweep_mesh"' in functions
    assert "--rail-layers" in (tmp_path / "reference" / "command.html").read_text()
    for page in tmp_path.rglob("*.html"):
        loaded = re.findall(r'<(?:script|img|link)[^>]+(?:src|href)="(https?:[^"]+)"', page.read_text())
        assert not [address for address in loaded if "canonical" not in address], page.name


def test_the_step_files_are_those_that_the_script_draws(tmp_path):
    """By what cadsweep reads of them: names, volumes, faces."""
    pytest.importorskip("cadquery")
    import cadsweep as cs

    spec = importlib.util.spec_from_file_location("draw_step_files", ROOT / "scripts" / "draw_step_files.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(tmp_path)
    files = sorted(ROOT.joinpath("models").glob("*.step"))
    assert [file.stem for file in files] == sorted(module.DRAWINGS)
    for file in files:
        kept, drawn = cs.load(file), cs.load(tmp_path / file.name)
        assert [model.name for model in kept.models] == [model.name for model in drawn.models]
        assert [m.volume for m in kept.models] == pytest.approx([m.volume for m in drawn.models], rel=1e-9)
        assert [[f.name for f in s.faces] for s in kept.solids] == [[f.name for f in s.faces] for s in drawn.solids]


def test_the_version_is_the_same_everywhere():
    version = re.search(r'^__version__ = "(.+)"', ROOT.joinpath("cadsweep", "_version.py").read_text(), re.MULTILINE)[1]
    assert re.search(rf"^version: {re.escape(version)}$", ROOT.joinpath("CITATION.cff").read_text(), re.MULTILINE)
    assert f"## {version}" in ROOT.joinpath("CHANGELOG.md").read_text()
