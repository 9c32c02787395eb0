"""A model as it was read: the shape, and the names that hang on its parts.

Place in the flow: what the readers (files, scripts, objects) hand to healing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple


class Named(NamedTuple):
    """A name for a sub-shape (face, edge or solid) where it lies in the model."""

    shape: Any
    name: str


class Colored(NamedTuple):
    """A colour (``cadsweep.cad.colors``) of a face or solid where it lies in the model."""

    shape: Any
    color: str


@dataclass(kw_only=True, eq=False)
class Model:
    """A shape and its names, before healing.

    Attributes
    ----------
    shape : TopoDS_Shape
    source : str
        How messages name the model: a path, or a type.
    name : str
        Name of the part; empty where nobody gave one.
    names : list of Named
        Names of faces, edges and solids as the user means them, part prefix included. A named face
        need not be a face of `shape` itself: a tag is set before later operations.
    paths : list of Named
        For solids of an assembly the names of the assemblies that each is in and its own, joined by ``/``; for
        bodies that hold none likewise.
    materials : list of Named
        Materials of solids.
    colors : list of Colored
        Colours of solids and faces; the first of a shape counts.
    scale : float
        Model units per unit of `shape`.
    notes : list of str
    """

    shape: Any
    source: str
    name: str = ""
    names: list[Named] = field(default_factory=list)
    paths: list[Named] = field(default_factory=list)
    materials: list[Named] = field(default_factory=list)
    colors: list[Colored] = field(default_factory=list)
    scale: float = 1.0
    notes: list[str] = field(default_factory=list)
