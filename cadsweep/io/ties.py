"""What ties the two sides of a contact together in a solver, where they share no nodes.

Place in the flow: for the writer of decks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..contacts import separate_contacts
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


def find_ties(mesh: LabelledMesh) -> list[Tie]:
    """Pairs of boundaries that are the two sides of one contact."""
    return [_tie(mesh, name) for name in separate_contacts(mesh.faces.names, mesh.volumes.names)]


def _tie(mesh: LabelledMesh, name: str) -> Tie:
    sides = [f"{name}_1", f"{name}_2"]
    quads = [mesh.quads[mesh.faces.named(side)][:, :4] for side in sides]
    fine, coarse = (0, 1) if len(quads[0]) > len(quads[1]) else (1, 0)
    corners = mesh.points[quads[coarse]]
    longest = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())
    return Tie(name=name, dependent=sides[fine], independent=sides[coarse], reach=_REACH * longest)
