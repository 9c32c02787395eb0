"""From a model as read to a ``Part``: heal, normalise, divide, extract.

Place in the flow: the second half of ``load``.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from ...brep import Part, Units
from ...errors import CadError, CadSweepError
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..extract.solids import extract_solid
from ..names.naming import declare_names
from ..names.unique import declare_words
from ..read.colors import split_colors
from ..read.model import Model, Named
from ..shapes import EDGE, FACE, SOLID, index_map, subshapes
from .divide import divide_closed
from .shared_surfaces import part_surfaces
from .slivers import merge_slivers
from .solids import mend, take_solid
from .tracing import Traced
from .units import normalise
from .validate import check_closed, check_finite

logger = logging.getLogger(__name__)


def make_part(model: Model) -> Part:
    """Heal a model of at most one solid, and read it.

    Raises
    ------
    CadError
        The model is not one usable solid; the message names the source and the stage.
    """
    notes = list(model.notes)
    with stage(model, "checking coordinates"):
        check_finite(model.shape)
    traced = Traced(model.shape)
    with stage(model, "reading names"):
        faces, lost_faces = declare_names(model.names, model.shape, FACE)
        edges, lost_edges = declare_names(model.names, model.shape, EDGE)
    with stage(model, "choosing the solid"):
        notes += take_solid(traced)
    [(color, face_colors)] = split_colors(model.colors, [traced.shape], model.shape)
    (name, material), of_solid = declare_words(
        (_first_name(model.names, traced.shape), "part"), (_first_name(model.materials, traced.shape), "material")
    )
    naming_notes = faces.notes + edges.notes + lost_faces + lost_edges + of_solid.notes
    for note in naming_notes:
        logger.warning("%s: %s", model.source, note)
    with stage(model, "healing"):
        notes += mend(traced)
    with stage(model, "normalising units"):
        scale, offset, size = normalise(traced)
    units = Units(model.scale * scale, model.scale * offset)
    with stage(model, "merging slivers"):
        notes += merge_slivers(traced, size)
    with stage(model, "dividing closed faces"):
        part_surfaces(traced)
        notes += divide_closed(traced)
        solid = subshapes(traced.shape, SOLID)[0]
        check_closed(solid)
    face_origins = traced.face_origins(index_map(solid, FACE))
    edge_origins = traced.edge_origins(index_map(solid, EDGE))
    for what, names, origins in (("face", faces, face_origins), ("edge", edges, edge_origins)):
        for name_lost in lost_names(names.by_entity, origins):
            notes.append(f"name '{name_lost}' is lost: its {what} was a sliver, or no part of the solid")
    labels = Labels(
        [
            FaceLabel() if j is None else FaceLabel(f"face {j}", faces.by_entity.get(j, ()), face_colors.get(j))
            for j in face_origins
        ],
        [EdgeLabel() if j is None else EdgeLabel(f"edge {j}", edges.by_entity.get(j, ())) for j in edge_origins],
    )
    with stage(model, "reading the geometry"):
        extracted = extract_solid(
            solid,
            labels=labels,
            name=name,
            material=material,
            color=color,
            units=units,
        )
    return Part(
        solids=(extracted,),
        name=model.name or name or "part",
        scale=units.scale,
        offset=units.offset,
        notes=tuple(notes + naming_notes),
        names={**of_solid.originals, **edges.originals, **faces.originals},
    )


@contextmanager
def stage(model: Model, doing: str) -> Iterator[None]:
    """Say in every error which model it is, and turn OpenCASCADE's own into a ``CadError``."""
    try:
        yield
    except CadError as error:
        raise CadError(f"{model.source}: {error}") from error
    except (CadSweepError, MemoryError):
        raise
    except Exception as error:
        detail = str(error).strip().splitlines()
        how = f"while {doing} ({type(error).__name__}{': ' + detail[0] if detail else ''})"
        if type(error).__module__.startswith("OCP"):
            raise CadError(
                f"{model.source}: OpenCASCADE failed {how}", try_="repair the model, or export it again"
            ) from error
        raise CadError(
            f"{model.source}: cadsweep failed {how}", try_="report this with the model: it is no fault of the model"
        ) from error


def lost_names(names: Mapping[int, tuple[str, ...]], origins: Sequence[int | None]) -> list[str]:
    """Names that no face (or edge) of the result carries."""
    carried = {name for j in origins if j is not None for name in names.get(j, ())}
    return [name for name in dict.fromkeys(name for own in names.values() for name in own) if name not in carried]


def _first_name(named: list[Named], solid: Any) -> str | None:
    return next((name for shape, name in named if shape.IsSame(solid)), None)
