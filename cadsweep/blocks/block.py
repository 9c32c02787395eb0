"""From layers of nodes to a named mesh: which quads bound which face, and what the face is called.

Place in the flow: after ``projection`` and ``smoothing``, before ``quality``. A :class:`FactoredMesh` is
the whole mesh in a few megabytes: the factors, the moved nodes, and the owner of every boundary quad.
It is what a file of factors holds, what MPI ranks share, and what slabs are streamed from.

Every boundary quad belongs to exactly one CAD face, or patch of a merged face. These may have several names
(their own, and those of groups they are in): what has the same names has one *owner*; the quads of owners never
overlap, and a boundary is all quads of the owners with its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import SweptStructure, hexes_at_faces, side_quads, sweep_hexes
from ..mesh import HexMesh, SurfaceMesh
from ..record import MeshRecord
from ..sweep import Sweep
from .former_faces import own_quads
from .naming import name_sweep

if TYPE_CHECKING:
    from ..projection import FactoredSweep


@dataclass(frozen=True, kw_only=True, eq=False)
class FactoredMesh:
    """A swept mesh that is not yet multiplied out.

    Attributes
    ----------
    sweep : FactoredSweep
        Places of the nodes, working units.
    structure : SweptStructure
    owner_names : tuple of tuple of str
        Boundary names of every owner; the owners below are indices into it.
    source_owners, target_owners : (q,) int64
        Owner of the quad of the source and of the target cap.
    side_owners : (n_layers, b) int64
    moved_nodes : (m,) int64
        Nodes that smoothing moved; empty where none was needed.
    moved_points : (m, 3) float64
        Where to, working units.
    kept_nodes : (w,) int64
        Nodes of a layer that smoothing leaves alone, in all layers: those of wall layers.
    part : str
        Name of the volume.
    scale : float
    offset : (3,) float64
        From working to model units, as in ``brep.Part``.
    info : MeshRecord
    """

    sweep: FactoredSweep
    structure: SweptStructure
    owner_names: tuple[tuple[str, ...], ...]
    source_owners: IntArray
    target_owners: IntArray
    side_owners: IntArray
    moved_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    moved_points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    kept_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    part: str = "part"
    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    info: Mapping[str, Any] = field(default_factory=MeshRecord)

    def __post_init__(self) -> None:
        object.__setattr__(self, "info", MeshRecord.of(self.info))

    @property
    def n_node_layers(self) -> int:
        """Layers of distinct nodes: one fewer on a closed ring."""
        return self.structure.n_layers + (not self.structure.periodic)

    @property
    def is_changed(self) -> bool:
        """Whether nodes were moved away from where the factors put them."""
        return len(self.moved_nodes) > 0

    def noted(self, notes: Sequence[str]) -> FactoredMesh:
        """The same with more notes."""
        return replace(self, info={**self.info, "notes": [*self.info.get("notes", []), *notes]}) if notes else self

    def points(self, start: int = 0, stop: int | None = None, *, out: FloatArray | None = None) -> FloatArray:
        """Nodes of the layers ``start`` to ``stop`` (exclusive), (layers, n_nodes, 3), model units."""
        stop = self.n_node_layers if stop is None else stop
        block = self.sweep.points(slice(start, stop), out=out)
        n = self.structure.n_nodes
        first, last = np.searchsorted(self.moved_nodes, [start * n, stop * n])
        if last > first:
            block.reshape(-1, 3)[self.moved_nodes[first:last] - start * n] = self.moved_points[first:last]
        return self.to_model(block)

    def working_points(self) -> FloatArray:
        """All nodes (n, 3), layer by layer, working units."""
        return replace(self, scale=1.0, offset=np.zeros(3)).points().reshape(-1, 3)

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring working points to model units, in place where there is anything to do."""
        if self.scale != 1.0:
            points = np.multiply(points, self.scale, out=points)
        if self.offset.any():
            points = np.add(points, self.offset, out=points)
        return points

    def owned_quads(self) -> list[tuple[tuple[str, ...], IntArray]]:
        """Names and outward quads (m, 4) of the owners: source, target, sides; an owner may come more than once."""
        s = self.structure
        return self._owned(
            s.quads[:, ::-1],
            s.quads + s.n_layers * s.n_nodes,
            side_quads(s.loops, s.n_nodes, s.n_layers, periodic=s.periodic).reshape(-1, 4),
        )

    def owned_hexes(self) -> list[tuple[tuple[str, ...], IntArray]]:
        """Names of the owners as :meth:`owned_quads`, and the hexahedron (m,) at each of their quads."""
        s = self.structure
        return self._owned(*hexes_at_faces(s.quads, s.loops, s.n_nodes, s.n_layers))

    def _owned(self, source: IntArray, target: IntArray, sides: IntArray) -> list[tuple[tuple[str, ...], IntArray]]:
        """Names of the owners, and the rows that each has of what stands for the quads of source, target and sides."""
        blocks = [(sides, self.side_owners.reshape(-1))]
        if not self.structure.periodic:
            blocks = [(source, self.source_owners), (target, self.target_owners), *blocks]
        found = []
        for rows, owners in blocks:
            # As small numbers, which numpy sorts by their digits.
            order = np.argsort(owners.astype(np.uint16 if len(self.owner_names) < 2**16 else np.int64), kind="stable")
            starts = np.flatnonzero(np.diff(owners[order], prepend=-1))
            for first, last in pairwise([*starts.tolist(), len(order)]):
                chosen = order[first:last]
                found.append((self.owner_names[int(owners[chosen[0]])], rows.take(chosen, axis=0)))
        return found

    def boundaries(self) -> dict[str, IntArray]:
        """Outward boundary quads (m, 4) by name."""
        return unite_quads(self.owned_quads())

    def to_mesh(self) -> HexMesh:
        """Multiply out."""
        s = self.structure
        points = np.empty((self.n_node_layers, s.n_nodes, 3))
        self.points(out=points)
        return HexMesh(
            points=points.reshape(-1, 3),
            hexes=sweep_hexes(s.quads, s.n_nodes, s.n_layers, periodic=s.periodic),
            boundaries=self.boundaries(),
            parts={self.part: np.arange(s.n_layers * len(s.quads), dtype=np.int64)},
            structure=s,
            info=self.info,
        )


def unite_quads(owned: Iterable[tuple[tuple[str, ...], IntArray]]) -> dict[str, IntArray]:
    """Quads of every name, from the names and quads of owners."""
    groups: dict[str, list[IntArray]] = {}
    for names, quads in owned:
        for name in names:
            groups.setdefault(name, []).append(quads)
    return {name: np.concatenate(pieces) for name, pieces in groups.items()}


def factor_mesh(
    sweep: Sweep,
    surfaces: SurfaceMesh,
    placed: FactoredSweep,
    target_faces: IntArray,
    *,
    periodic: bool = False,
    part: str = "part",
    scale: float = 1.0,
    offset: FloatArray | None = None,
    info: Mapping[str, Any] | None = None,
) -> FactoredMesh:
    """Join the placed layers with the names of the CAD faces."""
    pieces = {piece[1:]: names for piece, names in name_sweep(sweep).pieces().items()}
    owner_names = tuple(dict.fromkeys(pieces.values()))
    index = {names: i for i, names in enumerate(owner_names)}
    table = np.zeros(len(sweep.solid.faces), dtype=np.int64)
    patches = {place: index[names] for place, names in pieces.items() if place[1] >= 0}
    for (face, j), names in pieces.items():
        if j < 0:
            table[face] = index[names]
    source = surfaces.source
    structure = SweptStructure(
        quads=source.quads,
        loops=source.loops,
        n_nodes=len(source.points),
        n_layers=len(surfaces.rings) - 1,
        periodic=periodic,
    )
    notes = list((info or {}).get("notes", []))
    owners = {}
    first_names = [names[0] for names in owner_names]
    for role, ids, corners_of in _boundary_quads(surfaces, placed, target_faces):
        owners[role], shares = own_quads(ids, corners_of, sweep.solid.faces, table, patches)
        notes += [share.describe(sweep.solid.faces, first_names) for share in shares]
    return FactoredMesh(
        sweep=placed,
        structure=structure,
        owner_names=owner_names,
        source_owners=owners["source"],
        target_owners=owners["target"],
        side_owners=owners["side"],
        part=part,
        scale=scale,
        offset=np.zeros(3) if offset is None else offset,
        info={**(info or {}), "notes": notes},
    )


def _boundary_quads(
    surfaces: SurfaceMesh, placed: FactoredSweep, target_faces: IntArray
) -> list[tuple[str, IntArray, Callable[[tuple[IntArray, ...]], FloatArray]]]:
    """Role, face ids, and what gives corners (m, 4, 3) of some of them, of the quads of source, target and sides."""
    source, rings = surfaces.source, surfaces.rings
    n_layers = len(rings) - 1
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in source.loops])])
    following = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(starts)])

    def on_source(places: tuple[IntArray, ...]) -> FloatArray:
        return source.points[source.quads[places]]

    def on_target(places: tuple[IntArray, ...]) -> FloatArray:
        return placed.layer(n_layers)[source.quads[places]]

    def on_sides(places: tuple[IntArray, ...]) -> FloatArray:
        k, i = places
        return np.stack([rings[k, i], rings[k, following[i]], rings[k + 1, following[i]], rings[k + 1, i]], axis=1)

    return [
        ("source", source.faces, on_source),
        ("target", target_faces, on_target),
        ("side", surfaces.side_faces, on_sides),
    ]
