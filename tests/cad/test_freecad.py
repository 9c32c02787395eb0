"""FreeCAD documents: three that FreeCAD 0.20.2 has written, with the places that it states itself, and bad ones.

``plate`` is a cut with hidden operands, turned and moved, coloured orange with its hole in blue; ``body`` a PartDesign
body of two features; ``links`` a box in a part that is linked to in four ways, a peg attached to the box, a folder, a
fusion, and a hidden box.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs

pytestmark = pytest.mark.cad
FOLDER = Path(__file__).parent / "freecad"


def boxes(part):
    """Name to the least and largest corner of every solid, in model units."""
    corners = [solid.vertices * part.scale + part.offset for solid in part.solids]
    return {part.models[j].name: (c.min(axis=0), c.max(axis=0)) for j, c in zip(part.owners, corners, strict=True)}


def test_a_cut_is_where_freecad_has_it_with_its_colours():
    part = cs.load(FOLDER / "plate.FCStd")
    assert part.name == "Plate with hole"
    assert [model.name for model in part.models] == ["Plate_with_hole"]
    np.testing.assert_allclose(boxes(part)["Plate_with_hole"], [[92, 0, 0], [100, 10, 4]], atol=1e-6)
    assert part.models[0].color == "#ff8000"
    [hole] = {face.key for face in part.solids[0].faces if face.color == "#0000ff"}
    assert {face.kind for face in part.solids[0].faces if face.key == hole} == {"cylinder"}
    assert part.models[0].volume * part.scale**3 == pytest.approx(10 * 8 * 4 - np.pi * 4 * 4)
    assert list(cs.sweep_mesh(part, size=2.0).parts) == ["Plate_with_hole"]


def test_of_a_body_the_tip_is_taken():
    part = cs.load(FOLDER / "body.FCStd")
    assert part.name == "Bracket"
    np.testing.assert_allclose(boxes(part)["Bracket"], [[1, 2, 3], [21, 12, 8]], atol=1e-6)
    assert part.models[0].volume * part.scale**3 == pytest.approx(20 * 10 * 5 - np.pi * 4 * 5)


def test_links_and_groups_lie_where_freecad_shows_them():
    part = cs.load(FOLDER / "links.FCStd")
    found = {model.path: model.name for model in part.models}
    assert set(found) == {
        "Unit/Box",
        "Copy/Box",
        "Copy2/Box",
        "AlongUnit/Box",
        "Along",
        "Peg",
        "Folder/InFolder",
        "Fuse",
    }
    corners = {path: boxes(part)[name][0] for path, name in found.items()}
    for path, y in {"Unit/Box": 0, "Copy/Box": 20, "Copy2/Box": 40, "Along": 60, "AlongUnit/Box": 80}.items():
        np.testing.assert_allclose(corners[path], [1, y, 0], atol=1e-6)
    np.testing.assert_allclose(corners["Folder/InFolder"], [0, -20, 0], atol=1e-6)
    np.testing.assert_allclose(corners["Fuse"], [50, 0, 0], atol=1e-6)


def changed(source, *, without=(), **members):
    """The bytes of a document with some members replaced."""
    out = io.BytesIO()
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            if name not in without and name not in members:
                new.writestr(name, old.read(name))
        for name, data in members.items():
            new.writestr(name, data)
    return out.getvalue()


def document():
    with zipfile.ZipFile(FOLDER / "body.FCStd") as archive:
        return archive.read("Document.xml").decode()


BODY = FOLDER / "body.FCStd"
BAD = {
    "cut off": (lambda: BODY.read_bytes()[:2000], "damaged or cut off"),
    "no zip": (lambda: b"PK" * 50, "damaged or cut off"),
    "another archive": (lambda: changed(BODY, without=["Document.xml"]), "no Document.xml"),
    "no shape": (lambda: changed(BODY, without=["PartShape.brp"]), r"PartShape.brp is not in it"),
    "half a shape": (lambda: changed(BODY, **{"PartShape.brp": b"CASCADE Topology V1\n"}), "object 'Bracket'"),
    "bomb": (lambda: changed(BODY, **{"PartShape.brp": b"0" * 20_000_000}), "would unpack to 20 MB"),
    "entities": (
        lambda: changed(BODY, **{"Document.xml": '<!DOCTYPE a [<!ENTITY b "c">]>' + document().split("?>", 1)[1]}),
        "document type",
    ),
    "half of the XML": (lambda: changed(BODY, **{"Document.xml": document()[:9000]}), "Document.xml.*damaged"),
    "placement": (lambda: changed(BODY, **{"Document.xml": document().replace("Px=", "Rx=")}), "placement of"),
    "hidden": (
        lambda: changed(BODY, **{"Document.xml": document().replace('value="true"', 'value="false"')}),
        r"no visible object.*Bracket.*show one",
    ),
    "itself": (
        lambda: changed(
            FOLDER / "links.FCStd",
            **{
                "Document.xml": zipfile.ZipFile(FOLDER / "links.FCStd")
                .read("Document.xml")
                .decode()
                .replace('<XLink file="" stamp="" name="Unit"/>', '<XLink file="" stamp="" name="Copy"/>')
            },
        ),
        "a part of itself",
    ),
}


@pytest.mark.parametrize("kind", BAD)
def test_what_is_wrong_with_a_document_is_said(kind, tmp_path):
    make, words = BAD[kind]
    (tmp_path / "part.FCStd").write_bytes(make())
    with pytest.raises(cs.CadError, match=words) as caught:
        cs.load(tmp_path / "part.FCStd")
    assert "part.FCStd" in str(caught.value)
