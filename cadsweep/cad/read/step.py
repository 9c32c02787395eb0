"""STEP files with their names, through XCAF.

Place in the flow: called by ``files`` for a file whose frame has been checked.

Units: lengths come out in millimetres, whatever unit the file was written in, as in CadQuery and
gmsh. A file whose part would be tiny or huge in millimetres is read in a unit that is a power of two
of one, since OpenCASCADE works with absolute tolerances of 1e-7; ``Model.scale`` remembers it.

Names: products become parts; in an assembly a face called F of a part P is ``P_F``. Two structures
are met: products with named ADVANCED_FACEs, and CadQuery's assemblies, which wrap each object as
``NAME`` and ``NAME_part``. CadQuery writes each byte of a name's UTF-8 as a letter; such a name is put right.

Colours: of a face before those of its solid, of an instance before those of its part and of its assembly.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Quantity import Quantity_ColorRGBA
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TColStd import TColStd_SequenceOfAsciiString
from OCP.TDataStd import TDataStd_Name, TDataStd_TreeNode
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import (
    XCAFDoc,
    XCAFDoc_ColorTool,
    XCAFDoc_ColorType,
    XCAFDoc_DocumentTool,
    XCAFDoc_Material,
    XCAFDoc_ShapeTool,
)

from ...errors import CadError
from ..names.unique import MATERIAL_PREFIX, is_meaningful, join_part
from ..quiet import kernel_path, kernel_setting
from ..shapes import EDGE, FACE, SOLID, bounds, compound, subshapes
from .colors import color_of, color_text
from .model import Model, Named

_SMALLEST, _GREATEST = 1e-1, 1e6
"""Sizes in millimetres between which a file is read in millimetres."""

_EXTERNAL = re.compile(rb"DOCUMENT_FILE\s*\(\s*'([^']+\.(?i:stp|step|p21))'")
_OF_HEADER = re.compile(r"^Parameter | for file_")
_NUMBERED = re.compile(r"^(NAUO)?\d+$")
"""Names of placements that programs make up."""

_SHAPING = re.compile(
    r"StepGeom_|StepShape_(?!ShapeRepresentation$)"
    r"|StepRepr_(?!Representation$|.*(Property|Material|Descriptive|ValueRange|ShapeAspect))"
    r"|StepBasic_(.*(Length|PlaneAngle)|(NamedUnit|SiUnit|ConversionBasedUnit|MeasureWithUnit|DimensionalExponents)$)"
)
"""Entities that shape the part or give its size. Damage to others (views, products, other units) is noted."""


def read_step(path: Path, data: bytes) -> Model:
    """Read a STEP file.

    Raises
    ------
    CadError
        OpenCASCADE cannot read it, or it holds no shape.
    """
    missing = _missing_files(path, data)
    with _without_bom(path, data) as clean_path:
        model = _read(path, clean_path, unit=1.0)
        if missing:
            said = f"the STEP file refers to {', '.join(missing[:6])}{' and others' if len(missing) > 6 else ''}"
            if not subshapes(model.shape, FACE):
                raise CadError(f"{path}: {said}, which hold its shapes. Put them into its folder.")
            model.notes.append(f"{said}, not to be found in its folder: what they hold is missing")
        box = bounds(model.shape)
        size = float(abs(box[1] - box[0]).max())
        if 0 < size < _SMALLEST or _GREATEST < size < math.inf:
            unit = 2.0 ** round(math.log2(size / 64.0))
            model = _read(path, clean_path, unit=unit)
    return model


def _missing_files(path: Path, data: bytes) -> list[str]:
    """STEP files that an assembly refers to and that are not beside it."""
    names = [name.decode("utf-8", "replace") for name in _EXTERNAL.findall(data)]
    return [name for name in dict.fromkeys(names) if not (path.parent / name).is_file()]


@contextmanager
def _without_bom(path: Path, data: bytes) -> Iterator[Path]:
    """A path of the file without its byte order mark, which OpenCASCADE's parser refuses."""
    start = data.find(b"ISO-10303-21")
    if not data[:start].strip():
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="cadsweep-") as folder:
        copy = Path(folder) / "model.step"
        copy.write_bytes(data[start:])
        yield copy


def _read(path: Path, clean_path: Path, *, unit: float) -> Model:
    """Read with lengths in `unit` millimetres."""
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetMatMode(True)
    reader.SetColorMode(True)
    document = TDocStd_Document(TCollection_ExtendedString("cadsweep"))
    with kernel_setting("read.stepcaf.subshapes.name", 1):
        try:
            with kernel_path(clean_path) as name:
                status = reader.ReadFile(name)
            if status != IFSelect_ReturnStatus.IFSelect_RetDone:
                raise CadError(
                    f"{path}: OpenCASCADE cannot read the STEP file: it is damaged. Export or copy it again."
                )
            complaints = _check_read(path, reader.ChangeReader().StepModel())
            units = _file_units(reader)
            # The document's unit is in metres; the reader converts to it.
            XCAFDoc_DocumentTool.SetLengthUnit_s(document, unit * 1e-3)
            done = reader.Transfer(document)
        except CadError:
            raise
        except Exception as error:
            raise CadError(
                f"{path}: OpenCASCADE cannot read the STEP file ({_first_line(error)}). Export or copy it again."
            ) from error
    model = Model(shape=None, source=str(path), scale=unit)
    parts: list[Any] = []
    if done:
        labels = TDF_LabelSequence()
        XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(labels)
        for label in _each(labels):
            _walk(model, parts, label, TopLoc_Location(), prefix=None, color=None, path=())
    parts = [part for part in parts if not part.IsNull()]
    if not parts:
        raise CadError(
            f"{path}: the STEP file holds no shape, or refers to entities that are not in it. "
            "Export a solid again from its CAD program."
        )
    if complaints:
        more = f" (and {len(complaints) - 1} more)" if len(complaints) > 1 else ""
        model.notes.append(f"the STEP file has faults that do not touch its geometry: {complaints[0]}{more}")
    model.shape = parts[0] if len(parts) == 1 else compound(parts)
    model.name = path.stem
    foreign = [u.lower() for u in units if u.lower() not in ("millimetre", "millimeter", "mm")]
    if foreign:
        model.notes.append(f"the file is in {', '.join(foreign)}; lengths here are in millimetres")
    return model


def _check_read(path: Path, model: Any) -> list[str]:
    """Refuse a file with damaged geometry: OpenCASCADE reads on, and crashes when it builds the shapes.

    Returns
    -------
    list of str
        Faults of what does not shape the part; whether its solids are valid is seen when they are healed.
    """
    # Of parameters the check of the whole says only those of the header (its author, its date), which do no harm.
    whole = [fault for fault in _failures(model.GlobalCheck(True)) if not _OF_HEADER.search(fault)]
    found = [fault.removeprefix("Undefined Parsing: ") for fault in whole]
    harmless: list[str] = []
    for number in filter(model.IsReportEntity, range(1, model.NbEntities() + 1)):
        check = model.Check(number, True)
        if check.HasFailed():
            kind = model.Value(number).DynamicType().Name()
            named = [f"{kind.partition('_')[2]}: {failure}" for failure in _failures(check)]
            (found if _SHAPING.match(kind) else harmless).extend(named)
    if found:
        more = f" (and {len(found) - 1} more faults)" if len(found) > 1 else ""
        raise CadError(f"{path}: the STEP file is damaged: {found[0]}{more}. Export or copy it again.")
    return harmless


def _failures(check: Any) -> list[str]:
    return [" ".join(str(check.CFail(j)).split()) for j in range(1, check.NbFails() + 1)]


def _file_units(reader: Any) -> list[str]:
    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles)
    return [str(lengths.Value(j).ToCString()) for j in range(1, lengths.Length() + 1)]


def _walk(
    model: Model,
    parts: list[Any],
    label: Any,
    location: Any,
    *,
    prefix: str | None,
    color: str | None,
    path: tuple[str, ...],
) -> None:
    """Collect the shapes, names and colours under a label.

    `prefix` is the name of the part that the label stands for, `color` what it has where it has no other, `path` the
    names of the assemblies that it is in.
    """
    tool = XCAFDoc_ShapeTool
    name = _name(label)
    material = _material(label)
    own_color = _color(label)
    if tool.IsReference_s(label):
        location = location.Multiplied(tool.GetLocation_s(label))
        referred = TDF_Label()
        tool.GetReferredShape_s(label, referred)
        label = referred
        # Numbers and NAUO1, NAUO2 are what programs write where the placement has no name of its own.
        name = name if is_meaningful(name) and not _NUMBERED.match(name) else _name(label) or name
        material = material or _material(label)
        own_color = own_color or _color(label)
    color = own_color or color
    if tool.IsAssembly_s(label):
        components = TDF_LabelSequence()
        tool.GetComponents_s(label, components)
        prefix = name if is_meaningful(name) else ""
        path = (*path, prefix) if prefix else path
        for component in _each(components):
            _walk(model, parts, component, location, prefix=prefix, color=color, path=path)
        return
    shape = tool.GetShape_s(label).Moved(location)
    parts.append(shape)
    if name.endswith("_part") and prefix == name.removesuffix("_part"):
        name = prefix
    solids = subshapes(shape, SOLID)
    if name.startswith(MATERIAL_PREFIX):
        material = material or name
        name = ""
    if is_meaningful(name):
        model.names.extend(Named(solid, name) for solid in solids)
        path = path if path and path[-1] == name else (*path, name)  # CadQuery's NAME and NAME_part are one
    # What holds no solid has a place, too: what is left out is called by it.
    model.paths.extend(Named(body, "/".join(path)) for body in solids or [shape] if path)
    if material:
        model.materials.extend(Named(solid, material.removeprefix(MATERIAL_PREFIX)) for solid in solids)
    _add_sub_shapes(model, label, location, part=name if prefix is not None else None)
    if color is not None:  # after those of its sub-shapes: the first counts
        model.colors += color_of(shape, color)


def _add_sub_shapes(model: Model, label: Any, location: Any, *, part: str | None) -> None:
    """Collect the names and colours of the faces, edges and solids under a shape's label."""
    tool = XCAFDoc_ShapeTool
    inner = TDF_LabelSequence()
    tool.GetSubShapes_s(label, inner)
    for sub in _each(inner):
        name, color = _name(sub), _color(sub)
        shape = tool.GetShape_s(sub).Moved(location)
        if color is not None:
            model.colors += color_of(shape, color)
        if not is_meaningful(name):
            continue
        if shape.ShapeType() in (FACE, EDGE):
            model.names.append(Named(shape, join_part(part, name)))
        elif shape.ShapeType() == SOLID:
            model.names.append(Named(shape, name))


def _each(labels: Any) -> Iterator[Any]:
    for j in range(1, labels.Length() + 1):
        yield labels.Value(j)


def _name(label: Any) -> str:
    attribute = _attribute(label, TDataStd_Name.GetID_s(), TDataStd_Name())
    return "" if attribute is None else decoded(str(attribute.Get().ToExtString()).strip())


def decoded(name: str) -> str:
    """A name whose every letter is a byte of UTF-8, as CadQuery writes them, in letters; another name as it is."""
    try:
        return name.encode("latin-1").decode("utf-8")
    except UnicodeError:
        return name


def _color(label: Any) -> str | None:
    found = Quantity_ColorRGBA()
    for kind in (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen):
        if XCAFDoc_ColorTool.GetColor_s(label, kind, found):
            return color_text(found)
    return None


def _material(label: Any) -> str | None:
    node = _attribute(label, XCAFDoc.MaterialRefGUID_s(), TDataStd_TreeNode())
    if node is None or not node.HasFather():
        return None
    material = _attribute(node.Father().Label(), XCAFDoc_Material.GetID_s(), XCAFDoc_Material())
    if material is None or material.GetName() is None:
        return None
    return str(material.GetName().ToCString()) or None


def _attribute(label: Any, guid: Any, empty: Any) -> Any:
    # FindAttribute crashes the interpreter where there is no such attribute, hence the question first.
    return empty if label.IsAttribute(guid) and label.FindAttribute(guid, empty) else None


def _first_line(error: Any) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
