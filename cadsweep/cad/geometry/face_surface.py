"""The bounded, oriented surface of one face: what ``brep.Face.surface`` holds.

Place in the flow: ``extract`` makes one per face from a geometry of :mod:`cadsweep.cad.surfaces` and
the parameter curves of the face's edges; :mod:`.feet` looks for nearest points.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ...brep import GainedTip
from .edge_on_face import EdgeOnFace, EdgeRecords
from .feet import Feet
from .patch import Patch, rows_of
from .record_kernels import curve_points
from .surfaces import TWO_PI, Cone, Plane

_OPEN = 0.99
"""Share of a turn up to which a cylinder's border does not meet itself from the other side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FaceSurface(Patch):
    """A patch with its edges' parameter curves.

    Attributes
    ----------
    curves : mapping of int to EdgeOnFace
        By edge id.
    second_opinion : callable or None
        Distances (m,) of points (m, 3) from the surface over the face's box, by OpenCASCADE: slow.
    tips : tuple of GainedTip
        Places within these may lie on either surface.
    """

    curves: Mapping[int, EdgeOnFace] = field(default_factory=dict)
    second_opinion: Callable[[FloatArray], FloatArray] | None = None
    tips: tuple[GainedTip, ...] = ()

    @cached_property
    def _feet(self) -> Feet:
        return Feet(self)

    @cached_property
    def edge_records(self) -> EdgeRecords | None:
        """The parameter curves of all edges; None where one has no record."""
        records = [on_face.record for on_face in self.curves.values()]
        found = [record for record in records if record is not None]
        if len(found) < len(records) or not found:
            return None
        return EdgeRecords(
            row={edge: j for j, edge in enumerate(self.curves)},
            values=np.concatenate(found),
            starts=np.cumsum([0] + [len(record) for record in found[:-1]]),
            shifts=np.array([on_face.in_parameters[1] for on_face in self.curves.values()]),
        )

    def project(self, points: FloatArray) -> FloatArray:
        """Parameters (m, 2) of the points of the surface nearest to `points` (m, 3)."""
        return self._feet.nearest(rows_of(points, 3))[0]

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the surface.

        What is farther than `close` from the foot that is found is left to OpenCASCADE. The least distance counts.
        """
        points = rows_of(points, 3)
        found = self._own_distance(points, close)
        for tip in self.tips:
            near = np.flatnonzero(np.linalg.norm(points - tip.corner, axis=1) <= tip.radius)
            if len(near):
                found[near] = np.minimum(found[near], tip.surface.distance(points[near], close=close))
        return found

    def _own_distance(self, points: FloatArray, close: float) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the surface, whatever tips the face got."""
        found = self._feet.nearest(points, close=close)[1]
        if self._feet.is_exact:
            return found
        far = np.flatnonzero(found > close)
        if len(far) and self.second_opinion is not None:
            found[far] = np.minimum(found[far], self.second_opinion(points[far]))
        return found

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Parameters (m, 2) of an edge of this face at arc-length fractions (m,).

        Raises
        ------
        KeyError
            The edge does not bound the face.
        """
        curve = self.curves[edge].curve
        parameters = curve.parameters(np.atleast_1d(np.asarray(fractions, dtype=float)))
        points = curve.geometry.derivatives(parameters)[0]
        return self.edges_uv([edge], parameters[None], points[None])

    def edges_uv(self, edges: Sequence[int], parameters: FloatArray, points: FloatArray) -> FloatArray:
        """Parameters of several edges of this face, one after the other.

        Parameters
        ----------
        edges : sequence of n int
        parameters : (n, m) float64
            Each edge's own.
        points : (n, m, 3) float64
            The edge at these.

        Returns
        -------
        (n m, 2) float64
        """
        flat = points.reshape(-1, 3)
        if isinstance(self.geometry, Plane):
            return self.geometry.project(flat)
        if self._is_open_cylinder:
            return self._feet.near(flat, self.box.mean(axis=0)[None])
        records = self.edge_records
        if records is not None:
            rows = np.array([records.row[edge] for edge in edges])
            places = np.empty((*parameters.shape, 2))
            curve_points(
                records.values, records.starts[rows], records.shifts[rows], np.ascontiguousarray(parameters), places
            )
            return self._feet.near(flat, places.reshape(-1, 2))
        known = [self.curves[edge].in_parameters for edge in edges]
        if any(curve is None for curve, _ in known):
            return np.concatenate(
                [
                    self._unrolled(self.in_branch(self.project(own)))
                    if curve is None
                    else self._feet.near(own, curve.derivatives(at)[0] + shift)
                    for (curve, shift), at, own in zip(known, parameters, points, strict=True)
                ]
            )
        guess = np.concatenate(
            [
                curve.derivatives(at)[0] + shift
                for (curve, shift), at in zip(known, parameters, strict=True)
                if curve is not None
            ]
        )
        return self._feet.near(flat, guess)

    @cached_property
    def _is_open_cylinder(self) -> bool:
        """Whether a place alone tells its parameters: nobody has to ask OpenCASCADE for the curves in these."""
        straight = isinstance(self.geometry, Cone) and self.geometry.half_angle == 0.0
        return straight and bool(self.box[1, 0] - self.box[0, 0] < _OPEN * TWO_PI)

    def _unrolled(self, uv: FloatArray) -> FloatArray:
        for j, period in enumerate(self.periods):
            if period is not None:
                uv[:, j] = np.unwrap(uv[:, j], period=period)
        return uv
