"""Wall layers in a stack: rows along the walls on its plane, layers at caps between their sheets.

The rows are carried through all heights over the plane: below a pocket they go on through its floor. Layers at a cap go
through its whole level.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ...asked import WallLayers
from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from ...stack import Stack
from ...stacks import Sheets
from ...surface import Division, Walls
from ...sweep import Intervals
from .leaving import MOST_OF_EDGE, Leaving, walls_asked
from .stack_hints import StackHints
from .wall_corners import finer_at_corners
from .walls import WallPlan


@dataclass(kw_only=True, eq=False)
class StackWalls:
    """What wall layers ask of a stack.

    Attributes
    ----------
    plan : WallPlan
        Of the prism whose cap the plane is.
    at_caps : Leaving
        Heights between two sheets, from the lower one, at which layers begin.
    between : dict of (int, int) to callable
        How the layers between two sheets divide the height.
    sizes : dict of (int, int) to float
        Mean height of these layers.
    """

    plan: WallPlan = field(default_factory=WallPlan)
    at_caps: Leaving[tuple[int, int]] = field(default_factory=Leaving)
    between: dict[tuple[int, int], Division] = field(default_factory=dict)
    sizes: dict[tuple[int, int], float] = field(default_factory=dict)

    def added_to(self, stack: Stack, hints: StackHints, counts: Intervals) -> StackHints:
        """The hints with what walls ask for; what is demanded of edges already stays.

        Raises
        ------
        InputError
            A bias on an edge at which rows end.
        """
        ends, plane = self.plan.ends, hints.plane
        both = bool(plane.divisions.keys() & ends.keys() or hints.gradings.keys() & self.between.keys())
        if both and plane.field is None:
            raise InputError("a bias, and wall layers that end at the same edge, cannot both be")
        divided: dict[int, Division] = {}
        most: dict[int, float] = {}
        if not plane.partners:
            known = {e.id: e.length / max(1, int(counts.counts[e.id])) for e in stack.plan.solid.edges}
            kept = hints.demanded | ends.keys() | plane.biased
            most, divided = finer_at_corners(stack.plan, self.plan.edges, known, plane.divisions, kept=kept)
        least = self.plan.least_counts(stack.plan, counts)
        hints = hints.on_plane(
            divisions=divided | self.plan.divisions(stack.plan),
            least_counts={e: n for e, n in least.items() if e not in hints.demanded},
        ).finer(most)
        return replace(hints, layer_sizes=hints.layer_sizes | self.sizes, gradings=hints.gradings | self.between)

    def walls(self, stack: Stack) -> Walls | None:
        """For the surface stage."""
        if not self.plan.edges:
            return None
        above = {side.face for side in stack.plan.linking_sides if {e for e, _ in side.bottom} & self.plan.edges.keys()}
        return Walls(layers=self.plan.edges, faces=frozenset(above))


def plan_stack_walls(part: Part, stack: Stack, sheets: Sheets, options: SweepOptions, size: float) -> StackWalls:
    """Find what wall layers ask of a stack.

    Raises
    ------
    InputError
        A name that no face has, walls that contradict each other, or layers for which there is no height.
    """
    found = StackWalls()
    for word, own, (_, f) in walls_asked(part, part, options):
        if f in sheets.caps:
            _at_cap(stack, sheets, f, own, size, found)
            continue
        edges = set(stack.solid.faces[f].edges)
        below = [e for e, over in stack.arrangement.over.items() if edges & set(over)]
        for e in below:
            if found.plan.edges.setdefault(e, own) != own:
                label = stack.solid.faces[f].label()
                raise InputError(f"{label}: wall layers of '{word}' and of another name over or under it differ")
    found.plan.end_rows(stack.plan)
    return found


def _at_cap(  # noqa: PLR0917
    stack: Stack, sheets: Sheets, face: int, own: WallLayers, size: float, found: StackWalls
) -> None:
    """Layers between the sheet of a cap and the nearest one with nothing but material between."""
    sheet, label = sheets.caps[face], stack.solid.faces[face].label()
    upward = face in stack.source
    pairs = [pair for pair in sheets.spans if pair[0 if upward else 1] == sheet]
    if not pairs:
        raise InputError(f"wall layers: {label} has no layers of its own beside it")
    pair = min(pairs, key=lambda pair: float(sheets.heights[pair[1]] - sheets.heights[pair[0]]))
    height = float(sheets.heights[pair[1]] - sheets.heights[pair[0]])
    sine = abs(float(stack.solid.faces[face].normal @ stack.direction))
    taken = float(found.at_caps.leave(pair, own, sine=sine, at_start=upward)[-1])
    if taken > MOST_OF_EDGE * height:
        scale = stack.solid.units.scale
        raise InputError(
            f"wall layers: {own.n} layers at {label} take {taken * scale:.3g} of the {height * scale:.3g} to "
            "the next cap: ask for fewer or thinner ones"
        )
    if sum(float(d[-1]) for d in found.at_caps.ends[pair].values()) >= height:
        raise InputError(f"wall layers at {label} and at the cap across take more than there is between them")
    found.sizes[pair] = height / found.at_caps.needed(pair, height, size)
    found.between[pair] = found.at_caps.division(pair, height, f"the height at {label}")
