"""Pairs of nodes on matched faces of a finished mesh, whatever it is made of.

Place in the flow: the last step of making a mesh, and of refining it. :mod:`..wishes.periodic` says which faces answer
each other, and by what motion.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...mesh import HexMesh

Place = tuple[int, int]
"""A cell, and its id of a face."""


def with_pairs(mesh: HexMesh) -> HexMesh:
    """The mesh with the pairs of nodes of its matched faces.

    Raises
    ------
    SurfaceMeshError
        A node has no partner.
    """
    origin = mesh.origin
    if origin is None or not origin.options.periodic:
        return mesh
    from ..wishes.periodic import find_matches, pair_nodes  # few ask for pairs

    part, outside = origin.part, origin.names.outside
    pairs = {}
    for match in find_matches(part, origin.model, origin.options):
        names = tuple(_boundary(mesh, outside, own) for own in match.places)
        nodes = [np.unique(np.concatenate([mesh.boundaries[name] for name in own])) for own in names]
        motion = match.motion.in_units(part.scale, part.offset)
        key = "__".join("_and_".join(own) for own in names)
        pairs[key] = pair_nodes(mesh.points, (nodes[0], nodes[1]), motion, match.words)
    return replace(mesh, periodic=pairs)


def _boundary(mesh: HexMesh, names: dict[Place, tuple[str, ...]], places: frozenset[Place]) -> tuple[str, ...]:
    """Fewest boundaries that are these faces and no others."""
    covered: dict[str, set[Place]] = {}
    for place, labels in names.items():
        for name in labels:
            covered.setdefault(name, set()).add(place)
    inside = {name: found for name, found in covered.items() if name in mesh.boundaries and found <= places}
    whole = [name for name, found in inside.items() if found == places]
    return (whole[0],) if whole else tuple(inside)
