"""From a model as read to a ``Part``: heal, normalise, divide, extract.

Place in the flow: the second half of ``load``.
"""

from __future__ import annotations

import logging
from typing import Any

from ..errors import CadError
from ..topology import Part
from .divide import divide_closed
from .extract import Labels, extract_solid
from .model import Model, Named
from .names import plain
from .naming import declare_names
from .shapes import EDGE, FACE, SOLID, index_map, subshapes
from .tracing import Traced

logger = logging.getLogger(__name__)


def make_part(model: Model) -> Part:
    """Heal the model and read its solid.

    Raises
    ------
    CadError
        The model is not one usable solid.
    """
    solids = subshapes(model.shape, SOLID)
    if len(solids) != 1:
        raise CadError(f"{model.source}: holds {len(solids)} solids; cadsweep needs one.")
    notes = list(model.notes)
    traced = Traced(solids[0])
    faces, lost_faces = declare_names(model.names, traced.shape, FACE)
    edges, lost_edges = declare_names(model.names, traced.shape, EDGE)
    naming_notes = faces.notes + edges.notes + lost_faces + lost_edges
    for note in naming_notes:
        logger.warning("%s: %s", model.source, note)
    notes += naming_notes
    name, material = _first_name(model.names, solids[0]), _first_name(model.materials, solids[0])

    notes += divide_closed(traced)
    solid = subshapes(traced.shape, SOLID)[0]
    face_origins = traced.face_origins(index_map(solid, FACE))
    edge_origins = traced.edge_origins(index_map(solid, EDGE))
    labels = Labels(
        [f"face {j}" if j is not None else "" for j in face_origins],
        [faces.by_entity.get(j) if j is not None else None for j in face_origins],
        [edges.by_entity.get(j) if j is not None else None for j in edge_origins],
    )
    return Part(
        solids=(
            extract_solid(
                solid,
                labels=labels,
                name=None if name is None else plain(name, "part"),
                material=None if material is None else plain(material, "material"),
            ),
        ),
        name=model.name or name or "part",
        scale=model.scale,
        notes=tuple(notes),
        names={**edges.originals, **faces.originals},
    )


def _first_name(named: list[Named], solid: Any) -> str | None:
    return next((name for shape, name in named if shape.IsSame(solid)), None)
