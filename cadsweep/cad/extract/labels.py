"""What is known of the faces and edges of a solid besides their geometry.

Place in the flow: ``read`` makes labels, the edits hand them on, :mod:`.solids` puts them on what it reads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...brep import Face, GainedTip, Solid


class FaceLabel(NamedTuple):
    """What is known of a face besides geometry: fields of ``brep.Face``."""

    key: str = ""
    names: tuple[str, ...] = ()
    color: str | None = None
    number: int | None = None
    tips: tuple[GainedTip, ...] = ()


class EdgeLabel(NamedTuple):
    """What is known of an edge besides geometry: fields of ``brep.Edge``."""

    key: str = ""
    names: tuple[str, ...] = ()
    number: int | None = None


class Labels(NamedTuple):
    """What is known of the parts of a solid besides geometry, by id."""

    faces: Sequence[FaceLabel]
    edges: Sequence[EdgeLabel]


def label_of(face: Face | None) -> FaceLabel:
    """The label of a face, for one that is made of it; an empty one for a face that comes from none."""
    return FaceLabel() if face is None else FaceLabel(face.key, face.names, face.color, tips=face.tips)


def labels_of(solid: Solid) -> Labels:
    """The labels of a solid's faces and edges, as they were read."""
    return Labels([label_of(face) for face in solid.faces], [EdgeLabel(edge.key, edge.names) for edge in solid.edges])


def numbered_labels_of(solid: Solid) -> Labels:
    """The same for what is cut from it: faces keep the numbers that a user knows them by."""
    labels = labels_of(solid)
    faces = [label._replace(number=face.known) for label, face in zip(labels.faces, solid.faces, strict=True)]
    return Labels(faces, labels.edges)
