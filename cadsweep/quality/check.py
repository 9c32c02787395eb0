"""Every check on a mesh before it is handed over: :func:`check_mesh`.

Place in the flow: the last stage of the pipeline, ``HexMesh.quality()``, and ``cadsweep check``.

What is checked:

- coordinates are finite, indices in range, nodes of a hexahedron distinct, no hexahedron twice;
- the Jacobian is positive everywhere inside (:mod:`cadsweep.quality.bernstein`);
- every face has one or two users, in opposite directions; the faces with one user are exactly the
  named boundary quads, outward; they form a closed 2-manifold of the right Euler characteristic;
- no node is unused, no two boundary nodes coincide (two nodes inside can only coincide where
  hexahedra overlap or a face was torn, which makes its nodes boundary nodes);
- the boundary does not cross itself, and no closed piece of it lies where it cannot: with positive Jacobians, that
  makes hexahedra that overlap nowhere (:mod:`cadsweep.quality.overlap`);
- against the CAD model, where a :class:`CadReference` is given: volume, areas, Euler characteristic,
  distance of boundary nodes from their faces.

Not handled here: a mesh without any named boundary is not asked for one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import BlockStructure
from ..lattice import EDGES, number_lattice, order_of
from ..mesh import HexMesh
from ..threads import CHUNK, LIGHT, beside, map_chunks
from . import conformity
from .accumulate import QualityAccumulator
from .block_faces import match_blocks
from .boundary import boundary_problems
from .limits import BoundaryLimit, boundary_limit
from .overlap import BoundaryCrossing
from .report import CadReference, QualityReport
from .several import interface_problems, lie_in_parts, part_surfaces
from .skin import Skin, check_skin, of_whole
from .structure import follows_structure, structure_boundary, structure_problems

POOR = 0.5
"""Worst scaled Jacobian below which the report says how much of it is the boundary's."""


def check_mesh(
    mesh: HexMesh,
    *,
    cad: CadReference | Mapping[str, CadReference] | None = None,
    blocks: Sequence[BlockStructure] = (),
) -> QualityReport:
    """Measure and check a mesh.

    Parameters
    ----------
    mesh : HexMesh
        Where ``mesh.structure`` describes its hexahedra, conformity is known from the quads; a mesh
        without structure, as read from a file, is examined face by face. Both find the same.
    cad : CadReference, mapping of part name to CadReference, or None
        What the CAD model says; of a mesh of several parts, of each. None: ``mesh.info["cad_volume"]``, where there
        is one.
    blocks : sequence of BlockStructure
        What hexahedra of it are known to be layers of quads, in their order: where that is so, only the faces between
        blocks are matched. Where it is not, or these do not conform, all are.

    Returns
    -------
    QualityReport
        ``report.valid`` says whether nothing is wrong, ``report.problems`` what is.

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep import HexMesh
    >>> from cadsweep.quality import check_mesh
    >>> cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    >>> mesh = HexMesh(points=cube, hexes=np.arange(8)[None], boundaries={})
    >>> check_mesh(mesh).valid
    True
    >>> inside_out = HexMesh(points=cube * [1, 1, -1], hexes=np.arange(8)[None], boundaries={})
    >>> check_mesh(inside_out).n_inverted
    1
    """
    points = np.ascontiguousarray(mesh.points, dtype=np.float64)
    hexes = np.ascontiguousarray(mesh.hexes, dtype=np.int64)
    seen = QualityAccumulator()
    if hexes.ndim != 2 or not order_of(hexes.shape[1]) or points.ndim != 2 or points.shape[1] != 3:
        return make_report(seen, n_nodes=len(points), problems=[f"points {points.shape}, hexes {hexes.shape}"])
    if not len(hexes):
        return make_report(seen, n_nodes=len(points), problems=["there are no hexahedra"])
    problems = _coordinate_problems(points)
    structure = mesh.structure
    swept = structure is not None and follows_structure(hexes, structure)
    if structure is not None and not swept:
        problems.append("the structure (quads times layers) does not describe these hexahedra")
    if swept:
        assert structure is not None
        found = structure_problems(structure, len(points))
        problems += found
        swept = not found
    per_layer, use = 0, None
    if swept:
        assert structure is not None
        per_layer, expected = len(structure.quads), structure_boundary(structure)
    else:
        use = match_blocks(hexes, len(points), blocks) if blocks else None
        if use is None:
            trouble, use, blocks = *_general_problems(points, hexes), ()
            problems += trouble
        if use is None:
            return make_report(seen, n_nodes=len(points), problems=problems, order=mesh.order)
        expected = conformity.face_nodes(hexes, use.once)
    known_use = use if lie_in_parts(mesh, blocks) else None  # of faces inside of blocks nothing is known
    skin = Skin(
        points=points,
        quads=expected,
        boundaries=mesh.boundaries,
        interfaces=mesh.interfaces,
        parts=mesh.parts,
        surfaces=lambda: part_surfaces(mesh, known_use),
        between=lambda: interface_problems(mesh, known_use),
    )
    every = all(np.array_equal(ids, np.arange(mesh.n_hexes)) for ids in mesh.parts.values())
    known = _cad_of(mesh) if cad is None else of_whole(cad, mesh.parts, every=every)

    def measure() -> float:
        seen.add_hexes(points, hexes, per_layer=per_layer)
        return seen.volume

    with beside(measure, pays=len(hexes) > CHUNK) as volume:
        surface = check_skin(skin, known, volume=volume)
        problems += boundary_problems(mesh, expected)
    limit = boundary_limit(points, structure) if swept and structure and seen.min_scaled_jacobian < POOR else None
    return make_report(
        seen,
        n_nodes=len(points),
        order=mesh.order,
        problems=problems + surface.problems,
        areas=surface.areas,
        euler=surface.euler,
        limit=limit,
        crossings=surface.crossings,
    )


def make_report(
    seen: QualityAccumulator,
    *,
    n_nodes: int,
    order: int = 1,
    problems: list[str] | tuple[str, ...] = (),
    areas: Mapping[str, float] | None = None,
    euler: int | None = None,
    limit: BoundaryLimit | None = None,
    crossings: tuple[BoundaryCrossing, ...] = (),
) -> QualityReport:
    """Turn running metrics and findings into a report; inverted hexahedra come first among the problems."""
    found = list(problems)
    if seen.n_inverted:
        named = "; ".join(str(h) for h in seen.worst[:3])
        found.insert(0, f"{seen.n_inverted} of {seen.n_hexes} hexahedra are inverted, the worst are {named}")
    ratio, bound = seen.least_jacobians or (None, None)
    return QualityReport(
        n_nodes=n_nodes,
        n_hexes=seen.n_hexes,
        order=order,
        n_inverted=seen.n_inverted,
        min_scaled_jacobian=seen.min_scaled_jacobian,
        mean_scaled_jacobian=seen.mean_scaled_jacobian,
        metrics=seen.summaries(),
        worst=seen.worst,
        volume=seen.volume,
        areas=dict(areas or {}),
        jacobian_ratio=ratio,
        jacobian_bound=bound,
        euler=euler,
        problems=tuple(found),
        limit=limit,
        crossings=crossings,
    )


def _coordinate_problems(points: FloatArray) -> list[str]:
    if all(map_chunks(lambda chunk: bool(np.isfinite(points[chunk]).all()), len(points), chunk=LIGHT)):
        return []
    nodes = np.flatnonzero(~np.isfinite(points).all(axis=1))
    return [f"{len(nodes)} nodes have coordinates that are not finite, the first is node {nodes[0]}"]


def _general_problems(points: FloatArray, hexes: IntArray) -> tuple[list[str], conformity.FaceUse | None]:
    """Problems of any hexahedra, and the users of their faces (None where indices are out of range)."""
    problems = []
    (outside, where, repeated, where_repeated), used = conformity.scan_hexes(hexes, len(points))
    if outside:
        problems.append(f"{outside} hexahedra refer to nodes outside 0 .. {len(points) - 1}, the first is hex {where}")
    if repeated:
        problems.append(f"{repeated} hexahedra use a node twice, the first is hex {where_repeated}")
    if outside:
        return problems, None
    if not used.all():
        stray = np.flatnonzero(~used)
        problems.append(f"{len(stray)} nodes belong to no hexahedron, the first is node {stray[0]}")
    twins = conformity.duplicate_rows(hexes[:, :8])
    if twins:
        problems.append(f"{len(twins)} hexahedra occur more than once, the first are {twins[0][0]} and {twins[0][1]}")
    use = conformity.match_faces(hexes, len(points))
    if len(use.crowded):
        problems.append(
            f"{len(use.crowded)} times a face has more than two hexahedra, the first is on hex {use.crowded[0] // 6}"
        )
    if len(use.clashing):
        problems.append(
            f"{len(use.clashing)} faces are shared by hexahedra that turn the same way round on them, "
            f"the first is on hex {use.clashing[0] // 6}"
        )
    if hexes.shape[1] > 8:
        problems += _between_problems(hexes)
    return problems, use


def _between_problems(hexes: IntArray) -> list[str]:
    """An edge and a face must have the same nodes, at the same places, whichever hexahedron they are seen from."""
    order, size = order_of(hexes.shape[1]), hexes.shape[1]
    lattice = number_lattice(hexes[:, :8], int(np.max(hexes)) + 1, order)
    own = np.empty(lattice.n_nodes, dtype=np.int64)
    own[lattice.hexes[:, :size]] = hexes
    rows, columns = np.nonzero(own[lattice.hexes[:, :size]] != hexes)
    if not len(rows):
        return []
    on_edges = np.flatnonzero(columns < 8 + 12 * (order - 1))
    if not len(on_edges):
        return [f"faces have different nodes inside in different hexahedra, the first is on hex {rows[0]}"]
    ends = hexes[rows[on_edges, None], EDGES[(columns[on_edges] - 8) // (order - 1)]]
    a, b = min(np.sort(ends, axis=1).tolist())
    return [f"edges have different middle nodes in different hexahedra, the first is between nodes {a} and {b}"]


def _cad_of(mesh: HexMesh) -> CadReference | None:
    """What a mesh remembers of its CAD model."""
    volume = mesh.info.get("cad_volume")
    if volume is None:
        return None
    doubt = float(mesh.info.get("cad_volume_doubt") or 0.0)
    made = mesh.info.get("quality")
    if isinstance(made, QualityReport) and made.valid:
        # Held against the faces themselves when it was made: what they explained then needs no explanation by angles.
        doubt = max(doubt, abs(made.volume - float(volume)) * (1.0 + 1e-9))
    return CadReference(volume=float(volume), volume_doubt=doubt)
