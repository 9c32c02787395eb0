"""Meshes of order 2 to 8 of one of order 1, valid inside or refused.

Place in the flow: after ``smoothing``, before the last ``quality``; ``pipeline`` calls :func:`elevate` and hands over
the CAD geometry as callables. Nodes are placed by :mod:`.placing`, and what is not valid then is mended by
:mod:`.mending`; of order 2 the form of 20 nodes is that of 27 without those inside faces and hexahedra.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import InputError, InvertedHexError
from ..lattice import MOST
from ..mesh import HexMesh
from ..quality import positive_inside
from .distance import distance
from .mending import mended
from .placing import OnCad, place


def elevate(
    mesh: HexMesh,
    *,
    order: int = 2,
    nodes: int = 20,
    curves: OnCad = (),
    surfaces: OnCad = (),
    allow_inverted: bool = False,
) -> HexMesh:
    """Return the mesh with hexes of order 2 (20 or 27 nodes) or p (``(p + 1) ** 3``), its quads alike.

    Parameters
    ----------
    mesh : HexMesh
        Of order 1.
    order : int
        2 to 8.
    nodes : {20, 27}
        Of a hex of order 2.
    curves : sequence of (segments (s, 2) int64, projection or None)
        Mesh edges that lie on a CAD edge, as pairs of nodes in any order, and the projection to that edge's curve, None
        to a straight one.
    surfaces : sequence of (quads (q, 4) int64, projection or None)
        Quads that lie on a CAD face, and the projection to that face's surface, None to a plane. Where a mesh edge lies
        on several surfaces and no curve, the first one counts.
    allow_inverted : bool
        Return a mesh with hexes that are not valid, instead of raising.

    Returns
    -------
    HexMesh
        Its first ``mesh.n_nodes`` points are those of `mesh`, bit for bit.

    Raises
    ------
    InputError
        The mesh is not of order 1, `order` or `nodes` is none of those above, or a segment or quad is none of the mesh.
    InvertedHexError
        The Jacobian of a hex is not positive everywhere; names the hexes.
    """
    if not 2 <= order <= MOST:
        raise InputError(f"the order of a raised mesh is 2 to {MOST}, not {order!r}")
    if nodes not in {20, 27}:
        raise InputError(f"a hex of order 2 has 20 or 27 nodes, not {nodes!r}")
    points, lattice = place(mesh, order, curves=curves, surfaces=surfaces)
    of_hex, of_quad = (20, 8) if order == 2 and nodes == 20 else (lattice.hexes.shape[1], (order + 1) ** 2)
    hexes = np.ascontiguousarray(lattice.hexes[:, :of_hex])
    bad = np.flatnonzero(~positive_inside(points, hexes)[0])
    info = dict(mesh.info)
    if len(bad) and not allow_inverted:
        points, left = mended(points, hexes, lattice, bad, curves=curves, surfaces=surfaces)
        if len(left):
            x, y, z = mesh.points[mesh.hexes[left[0]]].mean(axis=0)
            raise InvertedHexError(
                f"{len(left)} hexes of order {order} have a Jacobian that is not positive inside, the first is hex "
                f"{left[0]} at ({x:.6g}, {y:.6g}, {z:.6g}): "
                "the curved boundary is too coarsely meshed; try a smaller size or order=1",
                hexes=left[:10].tolist(),
            )
        note = f"order {order}: {len(bad)} hexahedra were invalid when bent; nodes around them were moved on the CAD"
        info["notes"] = [*info.get("notes", ()), note]
    boundaries, interfaces = (
        {name: lattice.quads(quads)[:, :of_quad] for name, quads in named.items()}
        for named in (mesh.boundaries, mesh.interfaces)
    )
    if surfaces:
        info["curved_distance"] = distance(points, lattice, surfaces, of_quad)
    points = points[: int(np.max(hexes, initial=-1)) + 1]  # those inside come last
    return replace(
        mesh, points=points, hexes=hexes, boundaries=boundaries, interfaces=interfaces, structure=None, info=info
    )
