"""Areas, centroids and the volume of a solid that is read: ours where there are integrals, else OpenCASCADE's.

Place in the flow: within :mod:`.solids`, once loops are chained.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from ...arrays import FloatArray
from ...brep import Loop
from ..geometry.angles import MIDDLE
from ..geometry.curves import EdgeCurve
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure, measure_face
from ..geometry.surfaces import Plane
from .cylinders import Cylinders
from .flat import is_exact, measure_flat
from .sampling import EdgeSamples

_OPEN = 1e-4
"""Sum of the vector areas, as a share of the area, up to which a surface counts as closed."""


def measure_faces(  # noqa: PLR0917
    surfaces: Sequence[FaceSurface],
    loops: Sequence[tuple[Loop, ...]],
    frames: Sequence[Mapping[int, FloatArray]],
    samples: EdgeSamples,
    curves: Sequence[EdgeCurve],
    cylinders: Cylinders,
) -> list[Measure | None]:
    """Area, centroid and volume share of every face; None where our integrals give none."""
    exact = [is_exact(curve) for curve in curves]
    flat = [
        f
        for f, surface in enumerate(surfaces)
        if isinstance(surface.geometry, Plane) and all(exact[e] for e in surface.curves)
    ]
    normals = np.array([frames[f][MIDDLE][0] for f in flat]).reshape(-1, 3)
    known = dict(zip(flat, measure_flat([loops[f] for f in flat], normals, curves, samples), strict=True))
    known |= cylinders.measures(loops, curves)
    return [known.get(f) or measure_face(surface, loops[f]) for f, surface in enumerate(surfaces)]


def measured_by_opencascade(shape: Any, surface: FaceSurface) -> Measure:
    """The measure of a face whose loops or parameter curves give none.

    Its share of the volume is NaN where it is curved.
    """
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    area, center = float(properties.Mass()), _point(properties.CentreOfMass())
    if not isinstance(surface.geometry, Plane):
        return Measure(area, center, float("nan"), np.full(3, np.nan))
    vector = area * surface.normals(surface.project(center[None]))[0]
    return Measure(area, center, float(center @ vector) / 3.0, vector)


def volume_inside(shape: Any, measures: Sequence[Measure], *, open_area: float) -> float:
    """Volume inside the faces; `open_area` is what the gaps between them leave open at most."""
    area = sum(m.area for m in measures)
    vector = np.sum([m.vector for m in measures], axis=0)
    if np.linalg.norm(vector) <= max(_OPEN * area, open_area):
        # About the middle of the faces: what a gap lets out goes with its distance from the origin.
        middle = np.sum([m.area * m.center for m in measures], axis=0) / area
        return float(sum(m.volume for m in measures) - middle @ vector / 3.0)
    # Our quadrature does not see a closed surface (or has none of a face): OpenCASCADE's stands in.
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def _point(p: Any) -> FloatArray:
    return np.array([p.X(), p.Y(), p.Z()])
