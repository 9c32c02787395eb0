"""From what a user calls a face to its ids: name, id, key of the input, or CadQuery selector.

Place in the flow: called by the pipeline and the command line; reads the ``Part`` alone, and the
OpenCASCADE shape behind it only for selector strings.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..topology import Part, Solid

if TYPE_CHECKING:
    from .shapes import SolidShape

_MOST_LISTED = 40


def select_faces(part: Part, selector: str | int) -> tuple[int, ...]:
    """Find the faces that a user means.

    Parameters
    ----------
    part : Part
    selector : str or int
        A face's name (as declared in ``Part.names``, or as the user gave it), its id (``7`` or
        ``"7"``), its key in the input (``"face 7"``), or a CadQuery selector (``">Z"``,
        ``"|Z and %PLANE"``).

    Returns
    -------
    tuple of int
        Face ids of the part's first solid that has such faces, ascending.

    Raises
    ------
    InputError
        Nothing matches; the message lists names and ids.
    """
    if isinstance(selector, bool) or not isinstance(selector, (str, int)):
        raise InputError(f"A face is chosen by name, id or selector string, not by a {type(selector).__name__}.")
    for solid in part.solids:
        found = _in_solid(part, solid, selector)
        if found:
            return found
    raise InputError(f"No face matches {selector!r}. {_choices(part)}")


def _in_solid(part: Part, solid: Solid, selector: str | int) -> tuple[int, ...]:
    text = str(selector).strip()
    tests = [
        lambda face: text in face.names,
        lambda face: any(part.names.get(name) == text for name in face.names),
        # An assembly's "{part}_{name}" is also found by the name alone.
        lambda face: any(part.names.get(name, "").endswith(f"_{text.lstrip('~')}") for name in face.names),
        lambda face: str(face.id) == text,
        lambda face: bool(face.key) and face.key == text,
        lambda face: any(text in (name, part.names.get(name)) for patch in face.patches for name in patch.names),
    ]
    if isinstance(selector, int):
        tests = tests[3:4]
    for test in tests:
        found = tuple(face.id for face in solid.faces if test(face))
        if found:
            return found
    if isinstance(selector, str) and _looks_like_selector(text):
        return _by_selector(solid, text)
    return ()


def _looks_like_selector(text: str) -> bool:
    """Whether a string can be a CadQuery selector, so that a misspelt name does not import CadQuery."""
    return bool(re.search(r"[<>|#+\-%()]", text)) or text in (
        "XY",
        "XZ",
        "YZ",
        "front",
        "back",
        "left",
        "right",
        "top",
        "bottom",
    )


def _by_selector(solid: Solid, text: str) -> tuple[int, ...]:
    import cadquery

    shape: SolidShape = solid.write_brep  # type: ignore[assignment]
    candidates = [cadquery.Face(face) for face in shape.faces]
    try:
        chosen = cadquery.selectors.StringSyntaxSelector(text).filter(candidates)
    except Exception as error:
        raise InputError(f"{text!r} is neither a face's name nor a CadQuery selector: {_first_line(error)}") from error
    return tuple(j for j, face in enumerate(shape.faces) if any(face.IsSame(c.wrapped) for c in chosen))


def _first_line(error: Any) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__


def _choices(part: Part) -> str:
    lines = []
    for solid in part.solids:
        labels = [face.label() for face in solid.faces]
        more = f", and {len(labels) - _MOST_LISTED} more" if len(labels) > _MOST_LISTED else ""
        lines.append(", ".join(labels[:_MOST_LISTED]) + more)
    return "There are: " + "; ".join(lines) + "."
