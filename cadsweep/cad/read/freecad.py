"""FreeCAD documents (``.FCStd``): a zip with a BREP file for every object, and XML that says what they are.

Place in the flow: one of the readers. What is read is what FreeCAD would show: visible objects with a solid, of a
body its tip, of a cut or fusion the result and not its operands, links where they are, each in the place of the
groups that it is in. Labels name the solids, colours of objects and faces are kept.

A document is data of a stranger: members are read by name within limits, never unpacked, and XML with a document type,
which could hold entities, is refused.

Not handled, and refused by name: links into other documents, arrays of links and scaled links. Colours that FreeCAD
1.0 and later writes as a list of materials are not read.
"""

from __future__ import annotations

import struct
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from OCP.gp import gp_Quaternion, gp_Trsf, gp_Vec
from OCP.TopLoc import TopLoc_Location

from ...errors import CadError
from ..quiet import quiet_opencascade
from ..shapes import FACE, SOLID, subshapes
from .brep_files import read_brep
from .model import Model
from .objects import read_object
from .tree import AssemblyNode, Held

_ADVICE = "Export the part from FreeCAD as STEP (File, Export) and take that."

_MOST_BYTES = 2 << 30
"""Unpacked size of all members that are read: a BREP file of this size has some million faces."""

_MOST_PACKED = 400
"""Unpacked over packed size: a BREP file is packed to a fifth, a run of equal bytes, as in a bomb, to a thousandth."""

_DEFAULT_GREY = "#cccccc"
"""What FreeCAD gives a shape that nobody has coloured."""

_CONTAINERS = ("App::Part", "App::DocumentObjectGroup", "Assembly::AssemblyObject", "App::LinkGroup")
_NOT_CONSUMED = ("Group", "Origin", "Support", "AttachmentSupport", "ExternalGeometry", "Parent", "Material")
"""Properties that link to an object and leave it where it is; what others link to, they are made of."""


@dataclass(kw_only=True)
class _Object:
    """One object of a document."""

    name: str
    kind: str
    label: str
    visible: bool
    placement: Any
    shape_file: str | None
    members: list[str] = field(default_factory=list)
    made_of: set[str] = field(default_factory=set)
    linked: str | None = None
    moves_along: bool = False
    refused: str = ""
    color: str | None = None
    color_file: str | None = None

    @property
    def is_container(self) -> bool:
        return self.kind in _CONTAINERS


def read_freecad(path: Path) -> Model:
    """Read a FreeCAD document.

    Raises
    ------
    CadError
        It is no zip or damaged, too large when unpacked, holds no visible solid, or something that is not read.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            document = _Document(path, archive)
            tree = document.tree()
            model = read_object(tree)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise CadError(
            f"{path}: the FreeCAD document is damaged or cut off ({error}): save or copy it again."
        ) from error
    assert model is not None
    model.source = str(path)
    model.name = model.name or path.stem
    return model


class _Document:
    """The objects of a document, and the archive that their shapes are in."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self.path, self.archive = path, archive
        self.infos = {info.filename: info for info in archive.infolist()}
        self.left = _MOST_BYTES
        if "Document.xml" not in self.infos:
            raise CadError(f"{path}: this is no FreeCAD document: the archive holds no Document.xml.")
        self.objects = self._read_objects()
        self._read_looks()
        self.shapes: dict[str, Any] = {}

    def member(self, name: str) -> bytes:
        """The bytes of a member, within limits."""
        info = self.infos.get(name)
        if info is None:
            raise CadError(f"{self.path}: the FreeCAD document is damaged: {name} is not in it. Save it again.")
        if info.flag_bits & 1:
            raise CadError(f"{self.path}: {name} is encrypted. {_ADVICE}")
        self.left -= info.file_size
        if self.left < 0 or info.file_size > _MOST_PACKED * max(info.compress_size, 4096):
            raise CadError(
                f"{self.path}: {name} would unpack to {info.file_size / 1e6:.4g} MB from "
                f"{info.compress_size / 1e6:.2g} MB, which no shape does: the document is not read. {_ADVICE}"
            )
        return self.archive.read(info)

    def _xml(self, name: str) -> ElementTree.Element:
        try:
            return ElementTree.fromstring(self.member(name), parser=ElementTree.XMLParser(target=_NoDocumentType()))
        except ElementTree.ParseError as error:
            raise CadError(f"{self.path}: {name} of the FreeCAD document is damaged: {error}.") from error
        except ValueError as error:
            raise CadError(f"{self.path}: {name} of the FreeCAD document is not read: {error}.") from error

    def _read_objects(self) -> dict[str, _Object]:
        root = self._xml("Document.xml")
        kinds = {str(one.get("name")): str(one.get("type")) for one in root.iterfind("Objects/Object")}
        found = {}
        for one in root.iterfind("ObjectData/Object"):
            name = str(one.get("name"))
            found[name] = self._object(name, kinds.get(name, ""), one)
        return found

    def _object(self, name: str, kind: str, data: ElementTree.Element) -> _Object:
        values = {str(prop.get("name")): prop for prop in data.iterfind("Properties/Property")}
        label = _value(values, "Label", "String") or name
        shape = values["Shape"].find("Part") if "Shape" in values else None
        made = _Object(
            name=name,
            kind=kind,
            label=label,
            visible=_value(values, "Visibility", "Bool") != "false",
            placement=self._placement(label, values),
            shape_file=None if shape is None else shape.get("file") or None,
            members=_links(values.get("Group")) + _links(values.get("ElementList")),
        )
        if kind.startswith("App::Link"):
            self._note_link(made, values)
        elif made.shape_file:
            made.made_of = {
                target for key, prop in values.items() if key not in _NOT_CONSUMED for target in _links(prop)
            }
            if kind == "PartDesign::Body":
                made.made_of |= set(made.members)
                made.members = []
        return made

    def _note_link(self, made: _Object, values: dict[str, ElementTree.Element]) -> None:
        target = values["LinkedObject"].find("XLink") if "LinkedObject" in values else None
        made.linked = None if target is None else target.get("name") or None
        made.moves_along = _value(values, "LinkTransform", "Bool") == "true"
        scale = values["ScaleVector"].find("PropertyVector") if "ScaleVector" in values else None
        if target is not None and target.get("file"):
            made.refused = f"links to another document ({target.get('file')})"
        elif int(_value(values, "ElementCount", "Integer") or 0) > 0:
            made.refused = "is an array of links"
        elif scale is not None and any(float(scale.get(f"value{axis}", "1")) != 1.0 for axis in "XYZ"):
            made.refused = "is a scaled link"

    def _placement(self, label: str, values: dict[str, ElementTree.Element]) -> Any:
        """The place of an object in its group, as a ``TopLoc_Location``."""
        key = "LinkPlacement" if "LinkPlacement" in values else "Placement"
        given = values[key].find("PropertyPlacement") if key in values else None
        if given is None:
            return TopLoc_Location()
        try:
            x, y, z, *turn = (float(given.attrib[word]) for word in ("Px", "Py", "Pz", "Q0", "Q1", "Q2", "Q3"))
        except (KeyError, ValueError) as error:
            raise CadError(f"{self.path}: the placement of '{label}' is damaged ({error}).") from error
        move = gp_Trsf()
        move.SetRotation(gp_Quaternion(*turn))
        move.SetTranslationPart(gp_Vec(x, y, z))
        return TopLoc_Location(move)

    def _read_looks(self) -> None:
        """Visibility and colours as the window had them; a document made by a script has none."""
        if "GuiDocument.xml" not in self.infos:
            return
        for one in self._xml("GuiDocument.xml").iterfind("ViewProviderData/ViewProvider"):
            made = self.objects.get(str(one.get("name")))
            if made is None:
                continue
            values = {str(prop.get("name")): prop for prop in one.iterfind("Properties/Property")}
            if "Visibility" in values:
                made.visible = _value(values, "Visibility", "Bool") != "false"
            packed = _value(values, "ShapeColor", "PropertyColor")
            made.color = _color(int(packed)) if packed else None
            listed = values["DiffuseColor"].find("ColorList") if "DiffuseColor" in values else None
            made.color_file = None if listed is None else listed.get("file") or None

    def tree(self) -> AssemblyNode:
        """What the document shows."""
        shown = {name for name, one in self.objects.items() if one.visible and (one.shape_file or one.linked)}
        hidden_by: set[str] = set()
        for name in shown:
            hidden_by |= self._operands(name)
        inside = {member for one in self.objects.values() if one.is_container for member in one.members}
        taken = shown - hidden_by
        tops = [one for name, one in self.objects.items() if name not in inside]
        nodes = [node for one in tops for node in self._nodes(one, taken)]
        if not nodes:
            there = sorted({one.label for one in self.objects.values() if one.shape_file})
            listed = f"it has {', '.join(there[:20])}" if there else "no object has a shape"
            raise CadError(f"{self.path}: no visible object of the FreeCAD document is a solid ({listed}): show one.")
        return AssemblyNode(name="", children=nodes)

    def _operands(self, name: str) -> set[str]:
        found: set[str] = set()
        todo = [name]
        while todo:
            for target in self.objects[todo.pop()].made_of - found - {name}:
                if target in self.objects:
                    found.add(target)
                    todo.append(target)
        return found

    def _nodes(
        self, one: _Object, taken: set[str], above: tuple[str, ...] = (), *, asked: bool = False
    ) -> Iterator[AssemblyNode]:
        """The nodes of an object: none where there is nothing to be meshed; a link shows (`asked`) what is hidden."""
        if one.name in above:
            raise CadError(f"{self.path}: '{one.label}' of the FreeCAD document is a part of itself.")
        above = (*above, one.name)
        if one.is_container:
            # A plain group is a folder, whose visibility is that of nothing.
            if one.kind != "App::DocumentObjectGroup" and not (one.visible or asked):
                return
            members = [self.objects[name] for name in one.members if name in self.objects]
            children = [node for member in members for node in self._nodes(member, taken, above)]
            if children:
                yield AssemblyNode(name=one.label, loc=Held(one.placement), children=children)
        elif one.name in taken:
            if one.linked:
                yield from self._link(one, taken, above)
            elif one.shape_file:
                yield from self._leaf(one, one.label, one.placement)

    def _link(self, one: _Object, taken: set[str], above: tuple[str, ...]) -> Iterator[AssemblyNode]:
        target = self.objects.get(one.linked or "")
        if one.refused or target is None:
            problem = one.refused or "links to an object that is not there"
            raise CadError(f"{self.path}: '{one.label}' {problem}, which is not read. {_ADVICE}")
        place = one.placement.Multiplied(target.placement) if one.moves_along else one.placement
        if target.shape_file and not target.is_container:
            yield from self._leaf(target, one.label, place)
            return
        for node in self._nodes(target, taken | {target.name}, above, asked=True):
            yield replace(node, name=one.label, loc=Held(place))

    def _leaf(self, one: _Object, label: str, place: Any) -> Iterator[AssemblyNode]:
        """An object with its shape, where it has a solid."""
        shape = self._shape(one)
        if not subshapes(shape, SOLID):
            return
        shape = shape.Located(TopLoc_Location())
        faces = subshapes(shape, FACE)
        listed = self._face_colors(one)
        color = listed[0] if len(listed) == 1 else one.color
        own = {Held(face): c for face, c in zip(faces, listed, strict=True)} if len(listed) == len(faces) > 1 else {}
        yield AssemblyNode(
            name=label,
            loc=Held(place),
            obj=Held(shape),
            color=None if color == _DEFAULT_GREY else color,
            _subshape_colors={held: c for held, c in own.items() if c != color},
        )

    def _face_colors(self, one: _Object) -> list[str]:
        data = self.member(one.color_file) if one.color_file else b""
        n = (len(data) - 4) // 4
        return [_color(value) for value in struct.unpack(f"<{n}I", data[4 : 4 + 4 * n])] if n > 0 else []

    def _shape(self, one: _Object) -> Any:
        assert one.shape_file is not None
        if one.name not in self.shapes:
            data = self.member(one.shape_file)
            with tempfile.TemporaryDirectory() as folder, quiet_opencascade():
                file = Path(folder) / "shape.brp"
                file.write_bytes(data)
                self.shapes[one.name] = read_brep(f"{self.path}, object '{one.label}'", data, file)
        return self.shapes[one.name]


class _NoDocumentType(ElementTree.TreeBuilder):
    """FreeCAD writes no document type; one could define entities that grow without end."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise ValueError("it declares a document type, which FreeCAD never does")


def _value(values: dict[str, ElementTree.Element], key: str, tag: str) -> str | None:
    found = values[key].find(tag) if key in values else None
    return None if found is None else found.get("value")


def _links(prop: ElementTree.Element | None) -> list[str]:
    """The objects that a property links to."""
    if prop is None:
        return []
    found = [one.get("value") or one.get("obj") or one.get("name") for one in prop.iter() if one.tag in _LINKS]
    return [name for name in found if name]


_LINKS = ("Link", "LinkSub", "XLink", "XLinkSub")


def _color(packed: int) -> str:
    """FreeCAD packs red, green, blue and transparency, the highest byte first."""
    return f"#{packed >> 8 & 0xFFFFFF:06x}"
