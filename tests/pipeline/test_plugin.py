"""The CadQuery plugin, and build123d's builders."""

from __future__ import annotations

from types import SimpleNamespace

import cadquery as cq
import pytest

import cadsweep as cs

from ..pictures import skip_where_nothing_draws

pytestmark = pytest.mark.cad


def test_workplanes_mesh_and_show_themselves(tmp_path):
    import cadsweep.cadquery  # noqa: F401

    work = cq.Workplane().box(4, 4, 2)
    work.faces(">Z").tag("top")
    mesh = work.sweepMesh(size=1.0, layers=2)
    assert mesh.n_hexes == 4 * 4 * 2
    assert "top" in mesh.boundaries
    skip_where_nothing_draws()
    assert work.showMesh(size=1.0, screenshot=tmp_path / "mesh.png") is work
    assert (tmp_path / "mesh.png").stat().st_size > 1000


def test_anything_with_a_part_is_taken():
    """As build123d's BuildPart, whose .part is the shape that was built."""
    shape = cq.Workplane().box(1, 2, 3).val()
    built = SimpleNamespace(part=SimpleNamespace(wrapped=shape.wrapped, label="block", color=None))
    part = cs.load(built)
    assert part.name == "block"
    assert part.solids[0].volume * part.scale**3 == pytest.approx(6.0)
