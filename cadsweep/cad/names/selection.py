"""From what a user calls a face or an edge to its ids: name, id, or CadQuery selector.

Place in the flow: called by the pipeline and the command line; reads the ``Part`` alone, and the
OpenCASCADE shape behind it only for selector strings.

===================== ==============================================================================
``"inlet"``           the faces (or edges) of that name
``"face 7"``          the face of that id, as ``cadsweep info`` and every message show it; also ``7``
``"edge 12"``         the edge of that id, as ``cadsweep info --edges`` and every message show it
``">Z"``              a CadQuery selector
``"faces:..."``       any of the above, among the faces only
``"edges:..."``       any of the above, among the edges only: ``"edges:|Z and >X"``, ``"edges:rim"``
``"vertices:>X"``     a CadQuery selector of vertices, where vertices are asked for
===================== ==============================================================================
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Literal

from ...brep import Edge, Face, FormerFace, Part, Solid
from ...errors import InputError

if TYPE_CHECKING:
    from ..shapes import SolidShape

Kind = Literal["face", "edge"]

_MOST_LISTED = 40
"""Names in a message: what fits a screen."""
_SELECTOR_WORDS = ("XY", "XZ", "YZ", "front", "back", "left", "right", "top", "bottom")


def select_faces(part: Part, selector: str | int) -> tuple[int, ...]:
    """Find the faces that a user means.

    Parameters
    ----------
    part : Part
    selector : str or int
        A face's name (as declared in ``Part.names``, or as the user gave it), its id (``7``, ``"7"`` or
        ``"face 7"``), or a CadQuery selector (``">Z"``, ``"|Z and %PLANE"``); ``"faces:"`` may stand before it.

    Returns
    -------
    tuple of int
        Face ids of the part's first solid that has such faces, ascending.

    Raises
    ------
    InputError
        Nothing matches; the message lists names and ids.
    """
    return _select(part, selector, "face")


def select_faces_of_all(part: Part, selector: str | int) -> list[tuple[int, int]]:
    """Find faces of any solid of a part: a selector chooses among the faces of all of them together.

    Returns
    -------
    list of (int, int)
        Cell and face id, ascending. ``"<Y"`` are the outermost faces of the model, and not those of every solid.

    Raises
    ------
    InputError
        Nothing matches.
    """
    text = str(selector).strip().removeprefix("faces:").strip()
    found: list[tuple[int, int]] = []
    for cell, solid in enumerate(part.solids):
        word = text if isinstance(selector, str) else selector
        found += [(cell, face) for face in _by_word(part, solid.faces, word, "face")]
    if not found and isinstance(selector, str) and _looks_like_selector(text) and not _is_name(part, text):
        places = [(cell, face.id) for cell, solid in enumerate(part.solids) for face in solid.faces]
        shapes = [shape for solid in part.solids for shape in _holder(solid).faces]
        found = [places[j] for j in _chosen(shapes, text, "face")]
    if not found:
        select_faces(part, selector)  # says what there is
    return found


def select_edges(part: Part, selector: str | int) -> tuple[int, ...]:
    """Find the edges that a user means: as :func:`select_faces`, with ``"edge 12"`` and ``"edges:|Z"``."""
    return _select(part, selector, "edge")


def select_edges_of(part: Part, selector: str | int) -> tuple[Kind, tuple[int, ...]]:
    """Find edges by what a user calls them, or by the faces that they bound.

    Parameters
    ----------
    part : Part
    selector : str or int
        What chooses faces (:func:`select_faces`), an edge's name, ``"edge 12"``, or ``"edges:"`` before
        whatever chooses edges.

    Returns
    -------
    "face" or "edge"
        What was named.
    tuple of int
        Ids of the edges: those named, or those of the faces named.

    Raises
    ------
    InputError
        Nothing matches, or the name is that of a face and of an edge.
    """
    text = str(selector).strip()
    if text.startswith("edges:"):
        return "edge", select_edges(part, selector)
    for solid in part.solids:
        if text.isdigit():  # a bare number is a face
            break
        edges = _by_word(part, solid.edges, text, "edge")
        faces = _by_word(part, solid.faces, text, "face")
        if edges and faces:
            raise InputError(f"'{text}' names both faces and edges: write 'faces:{text}' or 'edges:{text}'.")
        if edges:
            return "edge", edges
    try:
        faces = select_faces(part, selector)
    except InputError as error:
        named = "" if text.startswith("faces:") or not isinstance(selector, str) else f" {_choices(part, 'edge')}"
        raise InputError(f"{error.message}{named}") from error
    return "face", tuple(dict.fromkeys(e for f in faces for e in part.solids[0].faces[f].edges))


def select_vertices(part: Part, selector: str) -> tuple[int, ...]:
    """Find the vertices of a part of one solid that a CadQuery selector chooses; ``"vertices:"`` may stand before it.

    Raises
    ------
    InputError
        It is no selector, or chooses none.
    """
    text = selector.strip().removeprefix("vertices:").strip()
    found = _by_selector(part.solids[0], text, "vertex")
    if not found:
        raise InputError(f"No vertex matches {selector!r}.")
    return found


def _select(part: Part, selector: str | int, kind: Kind) -> tuple[int, ...]:
    if isinstance(selector, bool) or not isinstance(selector, (str, int)):
        article = "A" if kind == "face" else "An"
        raise InputError(
            f"{article} {kind} is chosen by name, id or selector string, not by a {type(selector).__name__}."
        )
    text = str(selector).strip()
    other = "edges:" if kind == "face" else "faces:"
    if text.startswith(other):
        raise InputError(f"{selector!r} chooses {other[:-1]}, and a choice of {kind}s is asked for here.")
    text = text.removeprefix(f"{kind}s:").strip()
    for solid in part.solids:
        word = text if isinstance(selector, str) else selector
        found = _by_word(part, solid.faces if kind == "face" else solid.edges, word, kind)
        if not found and isinstance(selector, str) and _looks_like_selector(text) and not _is_name(part, text):
            found = _by_selector(solid, text, kind)
        if found:
            return found
    lost = [note for note in part.notes if text and f"'{text}'" in note]
    near = _nearest_name(part, text, kind)
    meant = f"; did you mean '{near}'?" if near else "."
    raise InputError(f"No {kind} matches '{text}'{meant} {'; '.join([*lost, _choices(part, kind)])}")


def _nearest_name(part: Part, text: str, kind: Kind) -> str | None:
    """The name of a face or edge that is most like a word that names none."""
    items = [item for solid in part.solids for item in (solid.faces if kind == "face" else solid.edges)]
    names = [part.names.get(name, name) for item in items for name in item.names]
    return next(iter(get_close_matches(text, names, n=1)), None)


def _by_word(part: Part, items: Sequence[Face | Edge], selector: str | int, kind: Kind) -> tuple[int, ...]:
    """Ids of the faces or edges of a name, or of an id."""
    text = str(selector)

    def by_id(item: Face | Edge) -> bool:
        numbers = [item.known, *(patch.number for patch in _former_faces(item) if patch.number is not None)]
        return any(text in (str(number), f"{kind} {number}") for number in numbers)

    tests: list[Callable[[Face | Edge], bool]] = [
        lambda item: text in item.names,
        lambda item: any(part.names.get(name) == text for name in item.names),
        # An assembly's "{part}_{name}" is also found by the name alone.
        lambda item: any(part.names.get(name, "").endswith(f"_{text.lstrip('~')}") for name in item.names),
        by_id,
        # A name inside a merged face.
        lambda item: any(text in (name, part.names.get(name)) for patch in _former_faces(item) for name in patch.names),
    ]
    if not text:
        return ()
    for test in [by_id] if isinstance(selector, int) else tests:
        found = tuple(item.id for item in items if test(item))
        if found:
            return found
    return ()


def _former_faces(item: Face | Edge) -> tuple[FormerFace, ...]:
    return item.former if isinstance(item, Face) else ()


def _is_name(part: Part, text: str) -> bool:
    """Whether something in the part, in another solid maybe, is called so: ``left`` and ``top`` are CadQuery's, too."""
    return any(text == name or name.endswith(f"_{text}") for name in part.names.values())


def _looks_like_selector(text: str) -> bool:
    """Whether a string can be a CadQuery selector, so that a misspelt name does not import CadQuery."""
    return bool(re.search(r"[<>|#+\-%()]", text)) or text in _SELECTOR_WORDS


def _by_selector(solid: Solid, text: str, kind: Literal["face", "edge", "vertex"]) -> tuple[int, ...]:
    holder = _holder(solid)
    shapes = {"face": holder.faces, "edge": holder.edges, "vertex": holder.vertices}[kind]
    return _chosen(shapes, text, kind)


def _holder(solid: Solid) -> SolidShape:
    holder: SolidShape = solid.kernel  # type: ignore[assignment]
    return holder


def _chosen(shapes: Sequence[Any], text: str, kind: Literal["face", "edge", "vertex"]) -> tuple[int, ...]:
    """Numbers of the shapes that a CadQuery selector chooses."""
    import cadquery

    make = {"face": cadquery.Face, "edge": cadquery.Edge, "vertex": cadquery.Vertex}[kind]
    candidates = [make(shape) for shape in shapes]
    try:
        chosen = set(cadquery.selectors.StringSyntaxSelector(text).filter(candidates))
    except Exception as error:
        raise InputError(
            f"{text!r} is neither the name of {'vertices' if kind == 'vertex' else kind + 's'} nor a CadQuery "
            "selector, such as '>Z', '|X', '#Y' or '%CYLINDER'"
        ) from error
    return tuple(j for j, candidate in enumerate(candidates) if candidate in chosen)


def _choices(part: Part, kind: Kind) -> str:
    """What there is to choose from: all faces; the named edges, for a part has many."""
    lines = []
    for solid in part.solids:
        if kind == "face":
            lines.append(_listed([face.label() for face in solid.faces]))
            continue
        named: dict[str, list[str]] = {}
        for edge in solid.edges:
            for name in edge.names:
                named.setdefault(part.names.get(name, name), []).append(str(edge.id))
        words = [f"'{name}' (edge{'s' if len(ids) > 1 else ''} {', '.join(ids)})" for name, ids in named.items()]
        lines.append(
            (f"named edges {_listed(words)}" if words else "no named edges")
            + f", and edge 0 to edge {len(solid.edges) - 1}; 'cadsweep info --edges' shows them"
        )
    return f"There are: {'; '.join(lines)}."


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words[:_MOST_LISTED]) + (f", and {len(words) - _MOST_LISTED} more" * (len(words) > _MOST_LISTED))
