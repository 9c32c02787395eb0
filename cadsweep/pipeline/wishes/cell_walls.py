"""From the user's words for walls to rows and layers in a part of several cells.

A wall is a face of the part before it was cut; its pieces are sides of some cells and caps of others. Every edge that
leaves a wall is divided by the heights of the layers, in whatever cells it is. A grid then has its rows, and so have
the layers of a sweep from a wall; a cap of other quads gets rows along its walls, which end at nodes of these edges.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ...asked import WallLayers
from ...brep import Edge, Face, Part, Solid
from ...corner_blocks import CornerBlocks
from ...errors import InputError
from ...options import SweepOptions
from ...plan import Plan
from ...surface import Division
from ...sweep import Sweep
from .leaving import MOST_OF_EDGE, STRAIGHT_ON, Leaving, joints, leave_at, walls_asked


@dataclass(kw_only=True, eq=False)
class CellWalls(Leaving[int]):
    """What wall layers ask of the cells of a part, and of the edges that leave walls, by keys.

    Attributes
    ----------
    layers : dict of int to WallLayers
        By face, heights in working units.
    """

    layers: dict[int, WallLayers] = field(default_factory=dict)

    def divisions(self, part: Part) -> dict[int, Division]:
        """How the edges that leave walls divide themselves."""
        return {key: self.division(key, edge.length, edge.label()) for key, edge in self._edges(part)}

    def least_counts(self, part: Part, size: float) -> dict[int, int]:
        """Segments that these edges need for the layers, and for what is left of them at most `size` long."""
        return {key: self.needed(key, edge.length, size) for key, edge in self._edges(part)}

    def shorten_all(self, part: Part) -> None:
        """Thin layers where an edge is too short for them."""
        for key, edge in self._edges(part):
            self.shorten(key, edge)

    def _edges(self, part: Part) -> Iterator[tuple[int, Edge]]:
        """The edges that leave walls, each once."""
        seen: set[int] = set()
        for solid in part.solids:
            for key, edge in zip(solid.edge_keys.tolist(), solid.edges, strict=True):
                if key in self.ends and key not in seen:
                    seen.add(key)
                    yield key, edge


def plan_cell_walls(part: Part, model: Part, plan: Plan, options: SweepOptions) -> CellWalls:
    """Find what wall layers ask of the cells.

    Raises
    ------
    InputError
        A name that no outer face has, walls that contradict each other, or a cell that cannot have layers; names the
        cell and the face.
    """
    walls = CellWalls()
    for word, own, (cell, f) in walls_asked(part, model, options):
        key = int(part.solids[cell].face_keys[f])
        if walls.layers.setdefault(key, own) != own:
            label = part.solids[cell].faces[f].label()
            raise InputError(f"{label}: wall layers of '{word}' and of another name differ")
    if not walls.layers:
        return walls
    _go_on(part, plan, walls)
    grids = {int(part.solids[cell].face_keys[f]) for cell, way in enumerate(plan.ways) for f in way.grids}
    for cell, way in enumerate(plan.ways):
        solid = part.solids[cell]
        own_walls = {f: walls.layers[key] for f, key in enumerate(solid.face_keys.tolist()) if key in walls.layers}
        if not own_walls:
            continue
        if isinstance(way.fill, CornerBlocks):
            label = solid.faces[min(own_walls)].label()
            raise InputError(
                f"wall layers: {label} bounds cell {cell} of '{part.models[part.owners[cell]].name}', which has a "
                "block at every corner: cut it into cells that are swept, with cuts"
            )
        _leave(part, cell, way.fill, own_walls, grids, walls)
    walls.shorten_all(part)
    return walls


def _go_on(part: Part, plan: Plan, walls: CellWalls) -> None:
    """Let walls go on into the sides of a section that they run into without a corner; not into cuts."""
    users: dict[int, int] = {}
    for solid in part.solids:
        for key in solid.face_keys.tolist():
            users[key] = users.get(key, 0) + 1
    changed = True
    while changed:
        changed = False
        for cell, way in enumerate(plan.ways):
            if not isinstance(way.fill, Sweep):
                continue
            solid = part.solids[cell]
            for cap, (a, _), (b, _), angle in joints(way.fill):
                one, other = (next((f for f in solid.edges[e].faces if f != cap), cap) for e in (a, b))
                keys = int(solid.face_keys[one]), int(solid.face_keys[other])
                if angle < STRAIGHT_ON or (keys[0] in walls.layers) == (keys[1] in walls.layers):
                    continue
                known, new, face = (keys[0], keys[1], other) if keys[0] in walls.layers else (keys[1], keys[0], one)
                if users[new] > 1:
                    continue
                walls.layers[new] = walls.layers[known]
                walls.notes.append(
                    f"wall layers go on along {solid.faces[face].label()}, into which the wall runs without a corner"
                )
                changed = True


def _leave(  # noqa: PLR0917
    part: Part,
    cell: int,
    sweep: Sweep,
    own_walls: Mapping[int, WallLayers],
    grids: Collection[int],
    walls: CellWalls,
) -> None:
    """Divide the edges of a cell that leave its walls."""
    solid = part.solids[cell]
    caps = {*sweep.source, *sweep.target}
    ruled = all(int(solid.face_keys[f]) in grids for f in sweep.source)
    for f, own in own_walls.items():
        face = solid.faces[f]
        at = {v for e in face.edges for v in (solid.edges[e].start, solid.edges[e].end)}
        for edge in solid.edges:
            if f in edge.faces or not at & {edge.start, edge.end}:
                continue
            others = [g for g in edge.faces if g in own_walls]
            if others and not ruled and f not in caps and not caps.intersection(others):
                _check_alike(part, cell, own, [own_walls[g] for g in others])
                continue  # two walls of a section meet here: their rows turn along the bisector
            key = int(solid.edge_keys[edge.id])
            for at_start, sine in leave_at(solid, face, edge, at):
                taken = float(walls.leave(key, own, sine=sine, at_start=at_start)[-1])
                if f in caps and edge.id in sweep.rails and taken > MOST_OF_EDGE * edge.length:
                    _refuse_high(solid, face, edge, own, taken)


def _refuse_high(solid: Solid, face: Face, edge: Edge, own: WallLayers, taken: float) -> None:
    scale = solid.units.scale
    raise InputError(
        f"wall layers: {own.n} layers at {face.label()} take {taken * scale:.3g} of {edge.label()}, which is "
        f"{edge.length * scale:.3g} long: ask for fewer or thinner ones"
    )


def _check_alike(part: Part, cell: int, own: WallLayers, others: Sequence[WallLayers]) -> None:
    for other in others:
        if other.n != own.n:
            raise InputError(
                f"two walls that meet in cell {cell} of '{part.models[part.owners[cell]].name}' have {own.n} and "
                f"{other.n} layers: ask for as many of both"
            )
