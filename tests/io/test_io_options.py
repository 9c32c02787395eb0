"""What the writers are told: scales, patch types, element types, numbers and prefixes; interfaces in every format."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from cadsweep.errors import InputError
from cadsweep.io import FORMATS, read, write
from cadsweep.mesh import HexMesh

from .io_meshes import TOLERANCES, box, twisted_box

WRITTEN = [suffix for suffix in FORMATS if suffix not in (".pvtu", ".exo", ".polymesh", ".su2", ".re2", ".xyz")]


def two_solids() -> HexMesh:
    """A box of two parts, one on the other, with the interface between them."""
    mesh = box()
    per_layer = mesh.n_hexes // 4
    low = np.arange(2 * per_layer)
    high = np.arange(2 * per_layer, 4 * per_layer)
    between = mesh.hexes[per_layer : 2 * per_layer, 4:8]
    info = {"materials": {"low": "steel 37", "high": "rubber"}}
    return replace(mesh, parts={"low": low, "high": high}, interfaces={"low__high": between}, info=info)


def place_for(suffix, tmp_path):
    return tmp_path / "polyMesh" if suffix == ".polymesh" else tmp_path / f"mesh{suffix}"


@pytest.mark.parametrize("suffix", [*WRITTEN, ".polymesh"])
def test_interfaces_come_back_as_interfaces(suffix, tmp_path):
    mesh = two_solids()
    write(mesh, place_for(suffix, tmp_path))
    back = read(place_for(suffix, tmp_path))
    assert list(back.interfaces) == ["low__high"]
    assert "low__high" not in back.boundaries
    sent, got = mesh.interfaces["low__high"], back.interfaces["low__high"]
    assert np.array_equal(np.unique(np.sort(sent, axis=1), axis=0), np.unique(np.sort(got, axis=1), axis=0))
    turns = {tuple(np.roll(quad, -int(np.argmin(quad)))) for quad in sent.tolist()}
    assert turns == {tuple(np.roll(quad, -int(np.argmin(quad)))) for quad in got.tolist()}  # outward from the first
    assert back.quality().valid


@pytest.mark.parametrize("suffix", [*WRITTEN, ".polymesh"])
def test_every_format_is_written_to_scale(suffix, tmp_path):
    mesh = twisted_box()
    write(mesh, place_for(suffix, tmp_path), scale=1e-3)
    assert np.allclose(read(place_for(suffix, tmp_path)).points, mesh.points * 1e-3, rtol=TOLERANCES.get(suffix, 1e-12))
    for wrong in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="scale"):
            write(mesh, place_for(suffix, tmp_path), scale=wrong)


def patch_types_of(folder):
    text = (folder / "boundary").read_text()
    return dict(re.findall(r"(\w+)\s*\{\s*type\s+(\w+);", text))


def test_walls_are_walls_by_name_or_as_said(tmp_path):
    mesh = box()
    names = {"source": "inlet", "target": "outlet", "side_1": "wall", "side_2": "hot_WALL", "side_3": "walled"}
    boundaries = {names.get(name, name): quads for name, quads in mesh.boundaries.items() if name != "walls"}
    mesh = replace(mesh, boundaries=boundaries)
    write(mesh, tmp_path / "polyMesh", patch_types={"side_4": "symmetryPlane"})
    assert patch_types_of(tmp_path / "polyMesh") == {
        "inlet": "patch", "outlet": "patch", "wall": "wall", "hot_WALL": "wall", "walled": "patch",
        "side_4": "symmetryPlane",
    }  # fmt: skip
    with pytest.raises(InputError, match=r"no boundary 'inlt'.*inlet"):
        write(mesh, tmp_path / "polyMesh", patch_types={"inlt": "wall"})
    with pytest.raises(InputError, match=r"no type of a patch.*wall"):
        write(mesh, tmp_path / "polyMesh", patch_types={"inlet": "wal"})


def test_inp_has_the_type_the_numbers_and_the_prefix_it_is_told(tmp_path):
    mesh = two_solids()
    write(mesh, tmp_path / "a.inp", element="c3d8i", first_node=1001, first_element=501, prefix="left_")
    text = (tmp_path / "a.inp").read_text()
    assert set(re.findall(r"TYPE=(C3D\w+)", text)) == {"C3D8I"}
    node, element = (int(re.search(rf"\*{word}[^\n]*\n(\d+),", text)[1]) for word in ("NODE", "ELEMENT"))
    assert (node, element) == (1001, 501)
    names = re.findall(r"(?:ELSET|NSET|NAME)=(\w+)", text)
    assert all(name.startswith("left_") for name in names)
    assert {"left_low__high", "left_high__low", "left_material_steel_37", "left_material_rubber"} <= set(names)
    back = read(tmp_path / "a.inp")
    assert np.array_equal(back.hexes, mesh.hexes)
    assert np.array_equal(back.parts["left_material_rubber"], mesh.parts["high"])
    for wrong in ({"element": "C3D20R"}, {"element": "S4"}, {"first_node": 0}, {"prefix": "1st"}, {"prefix": "a b"}):
        with pytest.raises(InputError):
            write(mesh, tmp_path / "b.inp", **wrong)
    assert not (tmp_path / "b.inp").exists()


def test_the_two_sides_of_an_interface_are_surfaces_of_their_own_parts(tmp_path):
    mesh = two_solids()
    write(mesh, tmp_path / "a.inp")
    text = (tmp_path / "a.inp").read_text()
    for name, part in (("low__high", "low"), ("high__low", "high")):
        body = re.search(rf"\*SURFACE, NAME={name}, [^\n]*\n((?:\d+, S\d\n)+)", text)[1]
        elements = {int(line.split(",")[0]) - 1 for line in body.splitlines()}
        assert len(elements) == len(mesh.interfaces["low__high"])
        assert elements <= set(mesh.parts[part].tolist())


def test_contacts_of_separate_parts_are_tied_the_finer_to_the_coarser(tmp_path):
    low, high = box(3, 3, 2), box(2, 2, 2)
    height = low.points[:, 2].max() - high.points[:, 2].min()
    mesh = HexMesh(
        points=np.concatenate([low.points, high.points + [0, 0, height]]),
        hexes=np.concatenate([low.hexes, high.hexes + low.n_nodes]),
        boundaries={
            "a__b__c_1": low.boundaries["target"],
            "a__b__c_2": high.boundaries["source"] + low.n_nodes,
            "other_1": low.boundaries["source"],
            "other_2": high.boundaries["target"] + low.n_nodes,
        },
        parts={"a__b": np.arange(low.n_hexes), "c": low.n_hexes + np.arange(high.n_hexes)},
    )
    write(mesh, tmp_path / "a.inp", prefix="p_")
    ties = re.findall(r"\*TIE, NAME=(\w+), .*\n(\w+), (\w+)\n", (tmp_path / "a.inp").read_text())
    assert ties == [("p_a__b__c", "p_a__b__c_1", "p_a__b__c_2")]
    write(mesh, tmp_path / "a.inp", ties=False)
    assert "*TIE" not in (tmp_path / "a.inp").read_text()


def test_su2_files_are_what_gmsh_writes(tmp_path):
    gmsh = pytest.importorskip("gmsh")
    mesh = replace(twisted_box(), boundaries={k: v for k, v in twisted_box().boundaries.items() if k != "walls"})
    write(mesh, tmp_path / "ours.su2")
    write(mesh, tmp_path / "mesh.msh", version="2.2")
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "mesh.msh"))
        gmsh.write(str(tmp_path / "theirs.su2"))
    finally:
        gmsh.finalize()
    ours, theirs = read(tmp_path / "ours.su2"), read(tmp_path / "theirs.su2")
    assert np.array_equal(ours.hexes, theirs.hexes)
    assert np.allclose(ours.points, theirs.points, rtol=1e-14)
    assert {k: len(v) for k, v in ours.boundaries.items()} == {k: len(v) for k, v in theirs.boundaries.items()}
    for name, quads in ours.boundaries.items():
        assert np.array_equal(np.sort(np.sort(quads, 1), 0), np.sort(np.sort(theirs.boundaries[name], 1), 0))


def test_su2_and_fluent_say_what_they_lack(tmp_path):
    from .io_meshes import bent_box

    for path, options in ((tmp_path / "a.su2", {}), (tmp_path / "a.msh", {"version": "fluent"})):
        with pytest.raises(InputError, match="order=1"):
            write(bent_box(20), path, **options)
        assert not path.exists()
    (tmp_path / "cut.su2").write_text("NDIME= 3\nNELEM= 2\n12 0 1 2 3 4 5 6 7 0\nNPOIN= 8\n")
    with pytest.raises(InputError):
        read(tmp_path / "cut.su2")
