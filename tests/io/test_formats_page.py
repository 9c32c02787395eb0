"""docs/formats.md says what the code does."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from cadsweep import io
from cadsweep.errors import InputError

from .io_meshes import bent_box

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"


def rows() -> list[list[str]]:
    table = [line for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


def test_every_format_has_its_row():
    named = {word.strip("`").lower() for row in rows() for word in row[0].split() if "version" not in word}
    named = {".polymesh" if word == "polymesh" else word for word in named}
    assert named == set(io.FORMATS)


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_orders_and_lengths_of_names_are_those_of_the_code(tmp_path, row):
    suffix = row[0].split()[0].strip("`")
    if suffix == ".pvtu":
        pytest.skip("written by a run over several ranks")
    version = re.search(r'version="(.*)"', row[0])
    options = {"version": version[1]} if version else {}
    kept = []
    for nodes in (8, 20, 27):
        path = tmp_path / (suffix if suffix == "polyMesh" else f"part{nodes}{suffix}")
        try:
            io.write(bent_box(nodes), path, **options)
        except InputError:
            continue
        if options != {"version": "fluent"}:  # which is not read
            assert io.read(path).hexes.shape[1] == nodes
        kept.append(nodes)
    assert [int(n) for n in row[2].split(",")] == kept
    module = importlib.import_module(f"cadsweep.io.{io._MODULES['.polymesh' if suffix == 'polyMesh' else suffix]}")
    assert int(row[6]) == getattr(module, "MAX_NAME", 80)
