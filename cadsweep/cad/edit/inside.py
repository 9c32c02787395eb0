"""Whether a place lies in the material of a solid.

Place in the flow: the cutters ask it of places beside features.

Method: OpenCASCADE's classifier sends a line through every face of the solid, whether the line comes near it or not,
which takes some 0.1 ms for a face on a spline. Here a ray is asked only of those faces whose boxes it meets. Two rays
have to agree, as the line's meetings with a spline may be lost by pairs; where one touches a face or meets an edge
another is sent, and what they do not tell the classifier does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
from OCP.IntCurvesFace import IntCurvesFace_Intersector
from OCP.IntCurveSurface import IntCurveSurface_TransitionOnCurve
from OCP.TopAbs import TopAbs_State

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import shapes_of
from .central import SAME

IsInside = Callable[[FloatArray], bool]

_RAYS = ((0.3597, 0.4811, 0.7995), (-0.6113, 0.7287, 0.3088), (0.2671, -0.8533, 0.4478))
"""Directions that hardly any face of a part runs along."""


def inside_of(solid: Solid) -> IsInside:
    """Tell whether a point (3,) lies in the material."""
    return _Inside(solid)


class _Inside:
    """The faces of a solid with their boxes."""

    def __init__(self, solid: Solid) -> None:
        holder = shapes_of(solid)
        self.near = SAME * solid.size
        self.classifier = BRepClass3d_SolidClassifier(holder.shape)
        self.faces = [IntCurvesFace_Intersector(face, self.near) for face in holder.faces]
        self.low, self.high = np.array([_box(face) for face in holder.faces]).transpose(1, 0, 2)
        self.far = 3.0 * solid.size + float(np.abs([self.low, self.high]).max())

    def __call__(self, point: FloatArray) -> bool:
        place = gp_Pnt(*map(float, point))
        told: set[bool] = set()
        for ray in _RAYS:
            found = self._along(point, gp_Lin(place, gp_Dir(*ray)))
            if found in told:
                return found is True
            if found is not None:
                told.add(found)
        self.classifier.Perform(place, self.near)
        return bool(self.classifier.State() == TopAbs_State.TopAbs_IN)

    def _along(self, point: FloatArray, line: gp_Lin) -> bool | None:
        """What a ray tells: it leaves material where it first meets a face; None where its meetings are not clear."""
        direction = line.Direction()
        steps = np.array([direction.X(), direction.Y(), direction.Z()])
        ends = np.array([self.low - point, self.high - point]) / steps
        first, last = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
        meets: list[tuple[float, bool]] = []
        for j in np.flatnonzero((first <= last) & (last >= 0.0)).tolist():
            face = self.faces[j]
            face.Perform(line, -self.near, self.far)
            if not face.IsDone():
                return None
            for k in range(1, face.NbPnt() + 1):
                way = face.Transition(k)
                tangent = way == IntCurveSurface_TransitionOnCurve.IntCurveSurface_Tangent
                if tangent or face.State(k) != TopAbs_State.TopAbs_IN:
                    return None
                meets.append((face.WParameter(k), way == IntCurveSurface_TransitionOnCurve.IntCurveSurface_Out))
        meets.sort()
        if any(abs(at) <= self.near for at, _ in meets):
            return None
        # What goes in and out by turns, and ends outside, has missed no face.
        leaves = [out for _, out in meets]
        expected = [bool(k % 2) == (len(leaves) % 2 == 0) for k in range(len(leaves))]
        return len(leaves) % 2 == 1 if leaves == expected else None


def _box(face: object) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    box = Bnd_Box()
    BRepBndLib.Add_s(face, box, False)
    x0, y0, z0, x1, y1, z1 = box.Get()
    return (x0, y0, z0), (x1, y1, z1)
