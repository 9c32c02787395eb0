"""The reference: every public name is in it, and every one of them has an example that runs."""

from __future__ import annotations

import doctest
import importlib
import re

import pytest

import cadsweep
import cadsweep.projection

from .docs_pages import ROOT

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

REFERENCE = {
    name
    for page in ROOT.joinpath("docs", "reference").glob("*.md")
    for name in re.findall(r"^::: (\S+)", page.read_text(), re.M)
}
PUBLIC = {f"cadsweep.{name}" for name in cadsweep.__all__ if not name.startswith("_")}
PUBLIC |= {f"cadsweep.projection.{name}" for name in cadsweep.projection.__all__}
WITHOUT_EXAMPLE = {
    "mkdocs-click",
    "cadsweep.brep.ModelSolid",  # in that of Part
    "cadsweep.projection.TargetCap",  # in that of project_target
}


def found(name):
    module, _, attribute = name.rpartition(".")
    return getattr(importlib.import_module(module), attribute)


def test_every_public_name_is_in_the_reference():
    assert PUBLIC <= REFERENCE


@pytest.mark.parametrize("name", sorted((REFERENCE | PUBLIC) - WITHOUT_EXAMPLE))
def test_the_example_of_a_name_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").symlink_to(ROOT / "models")
    examples = [
        test for test in doctest.DocTestFinder(recurse=False).find(found(name), name, globs={}) if test.examples
    ]
    assert examples, f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    said: list[str] = []
    for test in examples:
        runner.run(test, out=said.append)
    assert runner.failures == 0, "".join(said)
