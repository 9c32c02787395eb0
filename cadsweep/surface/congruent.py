"""Quads of plane faces that are congruent to one that was filled before: floors of pits, ends of pins.

Place in the flow: ``quads`` asks here before it fills a face. A part may have hundreds of faces of one outline, and the
ways of ``filling`` take up to a second for each.

Method: an outline is described in a frame of its own, from its first node towards its second; two outlines with the
same counts, places, angles and wishes get the same quads.

Not handled: outlines that are mirror images of each other, or begin at another vertex; curved faces.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import FloatArray, cross_product
from .outline import FaceQuads, Outline

_SAME = 1e-9
"""Difference, as a share of the outline's extent (of a radian where angles are meant), that rounding explains."""


@dataclass(frozen=True, kw_only=True)
class _Described:
    """An outline in its own frame.

    Attributes
    ----------
    origin : (3,) float64
    axes : (2, 3) float64
    places : (b, 2) float64
        Its nodes, loop by loop.
    wishes : (k,) float64
        Angles of its vertices, of its nodes on the other cap, and the size over the extent.
    extent : float
    """

    origin: FloatArray
    axes: FloatArray
    places: FloatArray
    wishes: FloatArray
    extent: float

    def is_like(self, other: _Described) -> bool:
        """Whether quads of the one are quads of the other."""
        near = np.abs(self.places - other.places) <= _SAME * self.extent
        return bool(near.all()) and np.allclose(self.wishes, other.wishes, rtol=0.0, atol=_SAME, equal_nan=True)


@dataclass(frozen=True, eq=False)
class Congruent:
    """Plane faces that were filled, by the counts of their outlines."""

    _known: dict[object, list[tuple[_Described, FaceQuads]]] = field(default_factory=dict)

    def recall(self, outline: Outline) -> FaceQuads | None:
        """Quads of a congruent face, in the outline's numbers and its place; None where there are none."""
        if not _is_handled(outline):
            return None
        described = _describe(outline)
        for like, patch in self._known.get(_key(outline), ()):
            if described.is_like(like):
                boundary = np.concatenate(outline.nodes)
                n = len(boundary)
                inside = patch.quads >= n
                quads = np.where(
                    inside, patch.quads - n + len(outline.known), boundary[np.where(inside, 0, patch.quads)]
                )
                points = described.origin + patch.inner_points @ described.axes
                return replace(patch, inner_points=points, quads=quads)
        return None

    def keep(self, outline: Outline, patch: FaceQuads) -> None:
        """Remember a face: its quads in numbers of its own, its inner nodes in its frame."""
        if not _is_handled(outline):
            return
        described = _describe(outline)
        boundary = np.concatenate(outline.nodes)
        order = np.argsort(boundary, kind="stable")
        at = order[np.minimum(np.searchsorted(boundary[order], patch.quads), len(order) - 1)]
        quads = np.where(patch.quads < len(outline.known), at, patch.quads - len(outline.known) + len(boundary))
        points = (patch.inner_points - described.origin) @ described.axes.T
        own = replace(patch, inner_points=points, quads=quads)
        self._known.setdefault(_key(outline), []).append((described, own))


def _is_handled(outline: Outline) -> bool:
    return outline.face.kind == "plane" and outline.sizes is None and outline.walls is None


def _key(outline: Outline) -> object:
    return tuple(tuple(int(outline.counts[e]) for e, _ in loop) for loop in outline.loops), outline.smooth


def _describe(outline: Outline) -> _Described:
    points = outline.known[np.concatenate(outline.nodes)]
    normal = outline.face.normal
    x_axis = points[1] - points[0]
    x_axis = x_axis - (x_axis @ normal) * normal
    x_axis /= np.linalg.norm(x_axis)
    axes = np.stack([x_axis, cross_product(normal, x_axis)])
    places = (points - points[0]) @ axes.T
    extent = float(np.ptp(places, axis=0).max())
    angles = [angle for loop in outline.loops for angle in outline.angles(loop)]
    opposite = np.concatenate([outline.opposite_of(nodes) for nodes in outline.nodes])
    wishes = np.concatenate([angles, opposite, [outline.size / extent]])
    return _Described(origin=points[0], axes=axes, places=places, wishes=wishes, extent=extent)
