"""One way to sweep a solid, as ids of its faces and edges.

Place in the flow: ``recognition`` makes a :class:`Sweep` of a :class:`~cadsweep.brep.Solid`; ``intervals`` adds
:class:`Intervals`; ``surface`` and ``projection`` work from both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from .arrays import IntArray
from .brep import Solid
from .verbs import do

DirectedEdge = tuple[int, bool]
"""An edge id, and whether the edge is run through from its start to its end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkingSide:
    """A linking face as a logical rectangle.

    ::

          target                  top[0] ... top[-1]
            ^              +-------->--------+
            |  layers      ^                 ^        left, right: along the sweep
            |         left |      face       | right  bottom, top: along the loop
            |              +-------->--------+
          source              bottom[0] ... bottom[-1]

    Every chain is a tuple of directed edges; ``bottom`` and ``top`` run in the direction of the
    source loop, ``left`` and ``right`` from source to target. Opposite chains get equal sums of
    segments; none is empty.
    """

    face: int
    bottom: tuple[DirectedEdge, ...]
    right: tuple[DirectedEdge, ...]
    top: tuple[DirectedEdge, ...]
    left: tuple[DirectedEdge, ...]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Sweep:
    """One way to sweep a solid.

    Attributes
    ----------
    solid : Solid
    source, target : tuple of int
        Face ids of the caps.
    linking_sides : tuple of LinkingSide
    source_loops : tuple of tuple of DirectedEdge
        Boundary of the source cap, outer loop first, each so directed that the cap lies on its
        left for one who walks along the loop with the sweep direction upwards: the outer loop turns
        counter-clockwise about the sweep direction (right-hand rule, pointing into the solid). This
        is the reverse of the cap face's own loop.
    target_loops : tuple of tuple of DirectedEdge
        Boundary of the target cap, loop j joined to source loop j by its linking sides, run in the
        same direction; it begins on the rail where source loop j begins.
    rails : tuple of int
        Ids of the edges along the sweep.
    stations : tuple of tuple of int
        Closed rings of edges between stacked linking sides, each a tuple of edge ids, in the
        order source to target.
    spans : tuple of tuple of tuple of int
        For every loop, for every span between its stations (one span where it has none), the rails
        of the span. Each span gets its own number of layers; the spans of every loop add up to the
        same total.
    span_lengths : tuple of tuple of float
        Mean length of each of these spans along the sweep, working units.
    target_faces : dict of int to int
        Source face to the target face its mesh lands on; empty where the caps' faces do not
        correspond one to one.
    target_edges : dict of int to (int, bool)
        For every edge of the source cap that corresponds to one edge of the target cap (all of
        them, inner ones too, where `target_faces` is given): that edge, and whether source start
        goes to target start.
    score : float
        Expected quality, best 1; candidates are listed best first.
    notes : tuple of str

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.find_sweeps(box, source=">Z")[0]
    Sweep: source face 5 (plane at 0, 0, 1)
      target face 4 (plane at 0, 0, -1)
      4 linking sides, 0 stations, score 0.98
    """

    solid: Solid
    source: tuple[int, ...]
    target: tuple[int, ...]
    linking_sides: tuple[LinkingSide, ...]
    source_loops: tuple[tuple[DirectedEdge, ...], ...]
    target_loops: tuple[tuple[DirectedEdge, ...], ...]
    rails: tuple[int, ...]
    stations: tuple[tuple[int, ...], ...] = ()
    spans: tuple[tuple[tuple[int, ...], ...], ...] = ()
    span_lengths: tuple[tuple[float, ...], ...] = ()
    target_faces: dict[int, int] = field(default_factory=dict)
    target_edges: dict[int, DirectedEdge] = field(default_factory=dict)
    score: float = 0.0
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        def caps(ids: tuple[int, ...]) -> str:
            return ", ".join(self.solid.faces[i].label() for i in ids[:2]) + (
                f", and {len(ids) - 2} more" * (len(ids) > 2)
            )

        return (
            f"Sweep: source {caps(self.source)}\n  target {caps(self.target)}\n"
            f"  {len(self.linking_sides)} linking sides, {len(self.stations)} stations, score {self.score:.2f}"
        )

    def _repr_html_(self) -> str:
        return str(do("sweep_card", self))

    @property
    def closed(self) -> bool:
        """Whether the caps are the two sides of the cut that opened a closed ring: its mesh closes on itself."""
        caps = {frozenset(self.source), frozenset(self.target)}
        return self.solid.opened is not None and caps == set(self.solid.opened)


@dataclass(frozen=True, kw_only=True, eq=False)
class Intervals:
    """How many segments each edge gets.

    Attributes
    ----------
    counts : (n_edges,) int64
        Segments of every edge of the solid.
    n_layers : int
    size : float
        Target edge length on the source cap, working units.
    span_layers : tuple of tuple of int
        For every loop, the layers of each of its spans; they add up to `n_layers`.
    """

    counts: IntArray
    n_layers: int
    size: float
    span_layers: tuple[tuple[int, ...], ...] = ()


def turned_chain(chain: Sequence[DirectedEdge]) -> tuple[DirectedEdge, ...]:
    """The same directed edges, run through the other way."""
    return tuple((edge, not forward) for edge, forward in reversed(chain))


def turned(sweep: Sweep) -> Sweep:
    """The same sweep from its target to its source; twice turned it is what it was."""
    return replace(
        sweep,
        source=sweep.target,
        target=sweep.source,
        # Run the other way round, a loop begins at the same rail and turns counter-clockwise about the new direction.
        source_loops=tuple(turned_chain(loop) for loop in sweep.target_loops),
        target_loops=tuple(turned_chain(loop) for loop in sweep.source_loops),
        linking_sides=tuple(
            LinkingSide(
                face=side.face,
                bottom=turned_chain(side.top),
                right=turned_chain(side.left),
                top=turned_chain(side.bottom),
                left=turned_chain(side.right),
            )
            for side in sweep.linking_sides
        ),
        stations=sweep.stations[::-1],
        spans=tuple(loop[::-1] for loop in sweep.spans),
        span_lengths=tuple(loop[::-1] for loop in sweep.span_lengths),
        target_faces={t: s for s, t in sweep.target_faces.items()},
        target_edges={t: (s, same) for s, (t, same) in sweep.target_edges.items()},
    )
