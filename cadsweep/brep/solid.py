"""One solid: vertices, edges and faces by id, and what of it others share."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..arrays import FloatArray, IntArray
from .entities import Edge, Face
from .geometry import Units


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Solid:
    """One solid: vertices, edges and faces by id, every edge shared by exactly two faces.

    Attributes
    ----------
    vertices : (n_vertices, 3) float64
    edges : tuple of Edge
    faces : tuple of Face
    volume : float
    size : float
        Diagonal of the bounding box.
    tolerance : float
        Largest gap that the model allows between a vertex or an edge and its faces.
    closed : float
        Width of gaps that were closed, to solids that it touches or at bridged tips: faces are as far off their edges.
    kernel : object
        What ``cad`` has to find again of the solid, its shape in the CAD kernel; None, or whatever else, to everybody
        else.
    vertex_keys, edge_keys, face_keys : int64 arrays
        Ids within the whole part: equal keys in two solids mean the same, shared entity.
    name : str or None
    material : str or None
    color : str or None
        The part's colour in the CAD model, as in ``Face.color``.
    units : Units
        What messages give places in.
    opened : pair of frozenset of int, or None
        Of a closed ring that was cut open, the faces on either side of the cut: two caps in one place.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> solid = cs.load(box).solids[0]
    >>> len(solid.faces), len(solid.edges), solid.vertices.shape
    (6, 12, (8, 3))
    >>> all(len(edge.faces) == 2 for edge in solid.edges)
    True
    """

    vertices: FloatArray
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]
    volume: float
    size: float
    tolerance: float = 0.0
    closed: float = 0.0
    kernel: object = None
    vertex_keys: IntArray
    edge_keys: IntArray
    face_keys: IntArray
    name: str | None = None
    material: str | None = None
    color: str | None = None
    units: Units = field(default_factory=Units)
    opened: tuple[frozenset[int], frozenset[int]] | None = None

    def first_vertex(self, directed: tuple[int, bool]) -> int:
        """Vertex where a directed edge ``(edge id, forward)`` begins."""
        edge = self.edges[directed[0]]
        return edge.start if directed[1] else edge.end

    def last_vertex(self, directed: tuple[int, bool]) -> int:
        """Vertex where a directed edge ``(edge id, forward)`` ends."""
        edge = self.edges[directed[0]]
        return edge.end if directed[1] else edge.start

    def __repr__(self) -> str:
        names = [face.name for face in self.faces if face.name]
        known = f", named: {', '.join(names[:6])}" + (", ..." if len(names) > 6 else "") if names else ""
        return (
            f"Solid {self.name or ''}".rstrip()
            + f": {len(self.faces)} faces, {len(self.edges)} edges, {len(self.vertices)} vertices{known}"
        )


def volume_doubt(solid: Solid) -> float:
    """How uncertain the volume is, working units: nothing says what lies in the gaps between the faces.

    A face that is off by a gap at all of its border changes the volume by the gap times its area. Where only short
    edges are off, it is the area of the open strips times half of the solid's size at most.
    """
    gaps = [edge.gap for edge in solid.edges]
    found = 0.0
    for face in solid.faces:
        strips = sum(gaps[e] * solid.edges[e].length for e in face.edges)
        found += min(max((gaps[e] for e in face.edges), default=0.0) * face.area, strips * solid.size / 2)
    return found
