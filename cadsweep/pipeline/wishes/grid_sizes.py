"""Sizes asked for at places, for a fitted grid: how far apart its planes may be there.

Place in the flow: before a grid is chosen (:mod:`..fitted_grids`). A grid's planes go through the whole part, so what
is fine somewhere is fine in the slabs through it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ... import cad
from ...arrays import FloatArray
from ...asked import local_size
from ...brep import Part
from ...fitted import Facets, sampled
from ...options import SweepOptions
from .local_sizes import size_field

_APART = 0.5
"""Distance of the places on a face that are looked at, over the size asked for there."""
_ALONG = np.linspace(0.0, 1.0, 65)
"""Places along an edge that are looked at."""


def sizes_at_places(part: Part, facets: Facets, options: SweepOptions, size: float) -> tuple[FloatArray, FloatArray]:
    """Places (k, 3) of a part of one solid at which less than `size` is asked for, and how much, (k,); working units.

    Raises
    ------
    InputError
        Nothing has such a name.
    """
    found = [(np.empty((0, 3)), np.empty(0)), *_named(part, facets, options), *_local(part, facets, options, size)]
    places, sizes = (np.concatenate(own) for own in zip(*found, strict=True))
    return places[sizes < size], sizes[sizes < size]


def _named(part: Part, facets: Facets, options: SweepOptions) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Places on the faces and edges that words mean."""
    solid = part.solids[0]
    for word, asked in (options.sizes or {}).items():
        own = asked / part.scale
        if word in {model.name for model in part.models}:
            edges, faces = tuple(range(len(solid.edges))), tuple(range(len(solid.faces)))
        else:
            kind, edges = cad.select_edges_of(part, word)
            faces = cad.select_faces(part, word) if kind == "face" else ()
        triangles = facets.of(np.array(faces, dtype=np.int64)).triangles
        places = [sampled(facets.points[triangles], _APART * own)[0]]
        places += [solid.edges[e].curve.evaluate(_ALONG) for e in edges]
        yield np.concatenate(places), np.full(sum(map(len, places)), own)


def _local(part: Part, facets: Facets, options: SweepOptions, size: float) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Places all over the faces, and those that are spoken of."""
    field = size_field(part, options, size)
    if field is None:
        return
    places = [sampled(facets.points[facets.triangles], _APART * size)[0]]
    if not callable(options.local_sizes):
        spoken = [local_size("a local size", own).at for own in options.local_sizes or ()]
        points = [np.array([at], dtype=float) for at in spoken if not isinstance(at, str | int)]
        places += [(point - part.offset) / part.scale for point in points]
    for own in places:
        yield own, field(own)


__all__ = ["sizes_at_places"]
