"""Names of contacts, and what ties the two sides of one together in a solver.

Place in the flow: for the writer of decks. Meshes whose solids share nodes have an interface ``a__b`` a contact; those
with ``interfaces="separate"`` have two boundaries, ``a__b_1`` on the first solid and ``a__b_2`` on the second.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from .labels import LabelledMesh

_REACH = 0.5
"""Distance to look for the other side within, as a share of the coarser side's longest edge: facets of two densities on
one curved face are apart by less than an eighth of that, where an edge goes around by a radian at the most."""


@dataclass(frozen=True, kw_only=True)
class Tie:
    """Two boundaries in contact.

    Attributes
    ----------
    name : str
        Of the contact, ``a__b``.
    dependent, independent : str
        The boundary whose nodes follow, which is the finer one, and the boundary whose quads they follow.
    reach : float
        Distance within which nodes find their quad.
    """

    name: str
    dependent: str
    independent: str
    reach: float


def solids_of(contact: str, parts: Collection[str]) -> tuple[str, str] | None:
    """The two parts that a contact ``a__b`` is between; None where the name is no contact's."""
    words = contact.split("__")
    for k in range(1, len(words)):
        first, second = "__".join(words[:k]), "__".join(words[k:])
        if first in parts and second in parts:
            return first, second
    return None


def find_ties(mesh: LabelledMesh) -> list[Tie]:
    """Pairs of boundaries that are the two sides of one contact."""
    names, parts = set(mesh.faces.names), set(mesh.volumes.names)
    stems = [name[:-2] for name in mesh.faces.names if name.endswith("_1") and f"{name[:-2]}_2" in names]
    return [_tie(mesh, stem) for stem in stems if solids_of(stem, parts) is not None]


def _tie(mesh: LabelledMesh, name: str) -> Tie:
    sides = [f"{name}_1", f"{name}_2"]
    quads = [mesh.quads[mesh.faces.named(side)][:, :4] for side in sides]
    fine, coarse = (0, 1) if len(quads[0]) > len(quads[1]) else (1, 0)
    corners = mesh.points[quads[coarse]]
    longest = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())
    return Tie(name=name, dependent=sides[fine], independent=sides[coarse], reach=_REACH * longest)
