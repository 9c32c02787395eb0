"""An assembly as a tree of plain values, under the names of CadQuery's: what readers make and what is pickled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, eq=False)
class Held:
    """A bare OpenCASCADE shape, held as CadQuery and build123d hold theirs."""

    wrapped: Any


@dataclass(frozen=True, kw_only=True, eq=False)
class AssemblyNode:
    """What :mod:`cadsweep.cad.read.objects` reads of a ``cq.Assembly``, under the same names."""

    name: str
    loc: Any = Held(None)
    obj: Any = None
    color: str | None = None
    material: Any = None
    _subshape_names: Mapping[Any, str] = field(default_factory=dict)
    _subshape_colors: Mapping[Any, str | None] = field(default_factory=dict)
    children: Sequence[AssemblyNode] = ()
