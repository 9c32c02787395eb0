"""A BREP file's text, checked before OpenCASCADE reads it.

Place in the flow: called by ``files``. OpenCASCADE's reader of this format trusts every count and
every word: on a damaged file it loops for ever or crashes.

Method: the file is a list of sections, each a name and a count, of numbers and a few words. Every
token must be one of these, every section must be there once, and as many shapes as announced.

Not checked: whether a well-formed number is the right one.
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

from ...errors import CadError

_SECTIONS = (
    b"Locations",
    b"Curve2ds",
    b"Curves",
    b"Polygon3D",
    b"PolygonOnTriangulations",
    b"Surfaces",
    b"Triangulations",
    b"TShapes",
)
_SHAPES = (b"Ve", b"Ed", b"Wi", b"Fa", b"Sh", b"So", b"CS", b"Co")
_TOKEN = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\*|\d*(?:C[0-3N]|G[12])|[a-z]")
"""A number, the end of a list, a continuity such as ``4CN``, or the mark of a polygon."""


def check_brep_text(path: Path | str, data: bytes) -> None:
    """Refuse a text BREP file that is cut off or has words that are none of its language.

    Raises
    ------
    CadError
    """
    start = data.find(_SECTIONS[0])
    tokens = data[max(start, 0) :].split()
    words = [token for token in tokens if not _TOKEN.fullmatch(token)]
    strange = next((word for word in words if word not in _SECTIONS and word not in _SHAPES), None)
    if strange is not None:
        shown = strange[:20].decode("ascii", "backslashreplace")
        raise CadError(f"{path}: the BREP file is damaged: it holds '{shown}'. Export or copy it again.")
    counts: dict[bytes, int] = {}
    for token, following in pairwise(tokens):
        if token in _SECTIONS and following.isdigit():
            counts[token] = int(following)
    missing = [section for section in _SECTIONS if section not in counts]
    n_shapes = sum(word in _SHAPES for word in words)
    if start < 0 or missing or max(counts.values()) > len(tokens) or counts[b"TShapes"] != n_shapes:
        raise CadError(f"{path}: the BREP file is damaged or cut off. Export or copy it again.")
    if not re.search(rb"[-+]\d+\s+\d+(?:\s+0)?\s*\Z", data[-200:]):  # old programs end with a 0
        raise CadError(f"{path}: the BREP file is cut off. Export or copy it again.")
