"""Cylinders between lines along them and arcs across them, all of a solid's at once.

Place in the flow: called by ``solids``, as :mod:`.flat` is for planes; other curved faces are read one by one.

Method: such a face is bounded by its edges themselves, dropped on it, so no curve in its parameters is asked for.
Normals are radial. Areas and moments are line integrals by Green's theorem, with arcs alone in them: along a line the
angle stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...brep import Loop
from ..geometry.angles import MIDDLE
from ..geometry.curves import EdgeCurve
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure
from ..geometry.parametric import Ellipse, Line
from ..geometry.surfaces import Cone
from .sampling import EdgeSamples, FaceSamples, arc_frames, is_arc

_ALONG = 1e-9
"""Sine of the angle up to which a line runs along the axis, or an arc across it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cylinders:
    """Faces of a solid that are cylinders between lines along them and arcs across them.

    Attributes
    ----------
    faces : (n,) int64
    origins, axes : (n, 3) float64
        A point of the axis, half way up the face, and its direction.
    radii : (n,) float64
    hands : (n,) float64
        1 where the surface's normal points away from the axis, -1 where it points to it.
    outward : (n,) float64
        1 where that normal points out of the solid, else -1.
    """

    faces: IntArray
    origins: FloatArray
    axes: FloatArray
    radii: FloatArray
    hands: FloatArray
    outward: FloatArray

    def samples(self, surfaces: Sequence[FaceSurface], edges: EdgeSamples) -> dict[int, FaceSamples]:
        """Normals along the edges of each face, and how far these are off it."""
        if not len(self.faces):
            return {}
        numbers = [list(surfaces[f].curves) for f in self.faces]
        row = np.repeat(np.arange(len(numbers)), [len(own) for own in numbers])
        points = edges.points[np.concatenate(numbers)]
        arms = points - self.origins[row, None]
        arms -= (arms @ self.axes[row, :, None]) * self.axes[row, None]
        away = np.linalg.norm(arms, axis=2)
        gaps = np.abs(away - self.radii[row, None])
        side = (self.hands * self.outward)[row]
        normals = side[:, None, None] * arms / np.maximum(away, 1e-300)[..., None]
        found = {}
        starts = np.cumsum([0] + [len(own) for own in numbers])
        for j, (f, own) in enumerate(zip(self.faces.tolist(), numbers, strict=True)):
            here = slice(starts[j], starts[j + 1])
            worst, at = divmod(int(gaps[here].argmax()), 3)
            by_edge = dict(zip(own, normals[here], strict=True))
            by_edge[MIDDLE] = surfaces[f].normals(surfaces[f].box.mean(axis=0)[None])
            found[f] = FaceSamples(
                by_edge, float(gaps[here][worst, at]), own[worst], points[here][worst, at], gaps[here].max(axis=1)
            )
        return found

    def measures(self, loops: Sequence[Sequence[Loop]], curves: Sequence[EdgeCurve]) -> dict[int, Measure]:
        """Area, centroid and volume share of each face; of those whose loops give none, nothing."""
        uses = [
            (j, curves[e], forward)
            for j, f in enumerate(self.faces.tolist())
            for loop in loops[f]
            for e, forward in loop.directed
            if is_arc(curves[e])
        ]
        if not uses:
            return {}
        n = len(self.faces)
        row = np.array([j for j, _, _ in uses])
        (center, x_axis, y_axis), first, last = arc_frames([curve for _, curve, _ in uses])
        axis = self.axes[row]
        radius = np.linalg.norm(x_axis, axis=1)
        turning = np.sign(np.einsum("md,md->m", np.cross(x_axis, y_axis), axis)) * self.hands[row]
        sense = turning * np.where([forward for _, _, forward in uses], 1.0, -1.0)
        height = np.einsum("md,md->m", center - self.origins[row], axis)
        turn = sense * (last - first)
        radial = (np.sin(last) - np.sin(first))[:, None] * x_axis - (np.cos(last) - np.cos(first))[:, None] * y_axis
        radial *= (sense / radius)[:, None]
        area = -self.outward * self.radii * np.bincount(row, height * turn, n)
        across = -np.stack([np.bincount(row, height * column, n) for column in radial.T], axis=1)
        along = -np.bincount(row, height**2 * turn, n) / 2.0
        moments = (self.outward * self.radii)[:, None] * (self.radii[:, None] * across + along[:, None] * self.axes)
        vectors = (self.hands * self.radii)[:, None] * across
        volumes = np.einsum("md,md->m", self.origins, vectors) + self.outward * self.hands * self.radii * area
        return {
            int(f): Measure(float(area[j]), self.origins[j] + moments[j] / area[j], float(volumes[j]) / 3.0, vectors[j])
            for j, f in enumerate(self.faces)
            if area[j] > 0.0
        }


def find_cylinders(surfaces: Sequence[FaceSurface]) -> Cylinders:
    """The plain cylinders among the faces of a solid."""
    own = [f for f, surface in enumerate(surfaces) if _is_plain(surface)]
    geometries = [surfaces[f].geometry for f in own]
    frames = [geometry.frame for geometry in geometries if isinstance(geometry, Cone)]
    middles = np.array([surfaces[f].box[:, 1].mean() for f in own])
    axes = np.array([frame.z for frame in frames]).reshape(-1, 3)
    return Cylinders(
        faces=np.array(own, dtype=np.int64),
        origins=np.array([frame.origin for frame in frames]).reshape(-1, 3) + middles[:, None] * axes,
        axes=axes,
        radii=np.array([geometry.radius for geometry in geometries if isinstance(geometry, Cone)]),
        hands=np.array([frame.handedness for frame in frames]),
        outward=np.array([surfaces[f].outward for f in own]),
    )


def _is_plain(surface: FaceSurface) -> bool:
    geometry = surface.geometry
    if not isinstance(geometry, Cone) or geometry.half_angle != 0.0 or not surface.curves:
        return False
    x, y, z = geometry.frame.z.tolist()
    for on_face in surface.curves.values():
        curve = on_face.curve
        if isinstance(curve.geometry, Line):
            # Written out: numpy takes ten times as long for two vectors.
            a, b, c = curve.geometry.direction.tolist()
            sine = ((y * c - z * b) ** 2 + (z * a - x * c) ** 2 + (x * b - y * a) ** 2) / (a * a + b * b + c * c)
            if sine > _ALONG**2:
                return False
        elif isinstance(curve.geometry, Ellipse) and curve.constant_speed:
            for axis in (curve.geometry.x_axis, curve.geometry.y_axis):
                a, b, c = axis.tolist()
                if abs(a * x + b * y + c * z) > _ALONG * geometry.radius:
                    return False
        else:
            return False
    return True


__all__ = ["Cylinders", "find_cylinders"]
