"""Edges of a face in the parameters of its surface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from ...arrays import FloatArray, IntArray
from .curves import EdgeCurve
from .parametric import Parametric
from .records import curve_record


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeOnFace:
    """An edge of a face, in space and in the parameters of the surface.

    Attributes
    ----------
    curve : EdgeCurve
    read : callable
        Returns the curve in the parameters (None: not known), in the parameter of `curve`, and the shift (2,) that
        brings it into the face's branch. Called when it is first asked for: OpenCASCADE has to make it for a plane,
        and hardly anybody wants to know it there.
    """

    curve: EdgeCurve
    read: Callable[[], tuple[Parametric | None, FloatArray]]

    @cached_property
    def in_parameters(self) -> tuple[Parametric | None, FloatArray]:
        """What `read` returns."""
        return self.read()

    @cached_property
    def record(self) -> FloatArray | None:
        """The curve in the parameters as compiled loops take it; None where it has no record, or is not known."""
        known = self.in_parameters[0]
        return None if known is None else curve_record(known)


class EdgeRecords(NamedTuple):
    """The parameter curves of all edges of a face, as compiled loops take them.

    Attributes
    ----------
    row : mapping of int to int
        By edge id, its row in `starts` and `shifts`.
    values : float64 array
        All records.
    starts : (n,) int64
        Where each begins.
    shifts : (n, 2) float64
        Into the branch of the face.
    """

    row: Mapping[int, int]
    values: FloatArray
    starts: IntArray
    shifts: FloatArray
