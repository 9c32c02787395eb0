"""Rules in tables: every row has one name, can be switched off by it, and a mesh says which had a share in it."""

import re

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep import rows
from cadsweep.errors import CadSweepError, InputError
from cadsweep.pipeline.tables import all_rows

pytestmark = pytest.mark.cad


def plate_with_hole():
    return cq.Workplane().box(8, 6, 2).faces(">Z").workplane().hole(2)


def crossed():
    """A block with two bores that do not meet: no sweep, no columns."""
    block = cq.Workplane().box(40, 30, 20).faces(">Z").workplane().center(-10, 0).hole(8)
    return block.faces(">X").workplane(centerOption="CenterOfMass").hole(6, 12)


def test_names_are_those_of_one_row_each():
    names = all_rows()
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z]+: [a-z, ]+", name) for name in names)


@pytest.mark.parametrize(
    ("make", "wanted"),
    [
        (plate_with_hole, {"way: sweep", "sweep: as it is", "cap: lattice"}),
        (crossed, {"way: cells"}),
    ],
)
def test_a_mesh_says_what_had_a_share_in_it(make, wanted):
    mesh = cs.sweep_mesh(make(), size=1.0 if make is plate_with_hole else 3.0)
    assert wanted <= set(mesh.record.rows) <= set(all_rows())
    if "way: cells" in wanted:
        assert any(row.startswith("cut: ") for row in mesh.record.rows)


@pytest.mark.parametrize("row", ["cap: lattice", "way: sweep"])
def test_a_row_that_is_off_has_no_share(row):
    mesh = cs.sweep_mesh(plate_with_hole(), size=1.0, without=[row])
    assert row not in mesh.record.rows
    assert mesh.info["quality"].valid
    assert rows.is_on(row)  # for the next mesh


def test_without_any_way_a_part_is_refused():
    with pytest.raises(CadSweepError, match="table 'way'"):
        cs.sweep_mesh(plate_with_hole(), without=[row for row in all_rows() if row.startswith("way: ")])


def test_a_name_that_no_row_has_is_refused_with_one_that_is_like_it():
    with pytest.raises(InputError, match=r"'cap: fann'.*'cap: fan'"):
        cs.sweep_mesh(plate_with_hole(), without=["cap: fann"])
