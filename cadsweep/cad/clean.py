"""From a model as read to a ``Part``: heal, normalise, divide, extract.

Place in the flow: the second half of ``load``.
"""

from __future__ import annotations

from ..errors import CadError
from ..topology import Part
from .divide import divide_closed
from .extract import Labels, extract_solid
from .model import Model
from .shapes import EDGE, FACE, SOLID, index_map, subshapes
from .tracing import Traced


def make_part(model: Model) -> Part:
    """Heal the model and read its solid."""
    solids = subshapes(model.shape, SOLID)
    if len(solids) != 1:
        raise CadError(f"{model.source}: holds {len(solids)} solids; cadsweep needs one.")
    traced = Traced(solids[0])
    notes = list(model.notes)
    notes += divide_closed(traced)
    solid = subshapes(traced.shape, SOLID)[0]
    faces, edges = index_map(solid, FACE), index_map(solid, EDGE)
    labels = Labels(
        [f"face {j}" if j is not None else "" for j in traced.face_origins(faces)],
        [None] * faces.Extent(),
        [None] * edges.Extent(),
    )
    return Part(solids=(extract_solid(solid, labels=labels),), name=model.name, scale=model.scale, notes=tuple(notes))
