"""A part: cells of one compound, and the solids of the model that they are pieces of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..verbs import do
from .geometry import Units
from .solid import Solid


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelSolid:
    """A solid of the model, as its user knows it: one part of the mesh, of one cell or of several.

    Attributes
    ----------
    name : str
        Unique among the model's solids, also without regard to case, and made of ``[A-Za-z0-9_]``; of an only solid
        without one, what the part is called.
    path : str
        The names of the assemblies that it is in and its own as the user gave it, joined by ``/``.
    volume : float
        Of the solid before it was imprinted or cut, working units.
    material : str or None
    color : str or None
        As in ``Face.color``.
    kernel : object
        What ``cad`` must find again: the solid before it was imprinted.
    """

    name: str
    path: str = ""
    volume: float
    material: str | None = None
    color: str | None = None
    kernel: Any = field(default=None, repr=False, compare=False)


@dataclass(frozen=True, kw_only=True)
class Cut:
    """One division of a solid into cells.

    Attributes
    ----------
    kind : str
        ``"plane"``, ``"cylinder"``, ``"cone"``: one face or axis extended. ``"planes"``: several at once. ``"rims"``:
        outlines carried on. ``"cushion"``: cells under a circle. ``"boxes"``: boxes around all features. ``"columns"``:
        the columns of a stack. ``"asked"``: the user's own.
    reason : str
        In words, with the face that it comes from.
    place : tuple of three float, or None
        Where the cut is, model units: the middle of a plane's cut, else of the cell that was divided. None where it
        goes through all of the part.
    family : str
        The row of the table of families of cutters that it is from; empty of other cuts.
    """

    kind: str
    reason: str
    place: tuple[float, float, float] | None = None
    family: str = ""

    def __str__(self) -> str:
        return self.reason


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Part:
    """What ``load`` returns: the solids of a model, made clean for meshing.

    Attributes
    ----------
    solids : tuple of Solid
        The cells: entities that two of them share have equal keys in both.
    name : str
    scale : float
        Model units per working unit, a power of two.
    offset : (3,) float64
        Model coordinates of the working origin.
    notes : tuple of str
        What was done to the model on the way (faces divided, slivers merged, shells sewn, names
        changed): one readable line each.
    names : dict
        Declared (unique, ``[A-Za-z0-9_]``) name to the name the user gave.
    owners : tuple of int
        For every cell the index into `models` of the solid that it is a piece of; by default, each its own.
    models : tuple of ModelSolid
        The solids of the model; by default, those that the cells are.
    cuts : tuple of Cut
        Along what the solids were cut, in the order in which they were.
    touch : float
        Distance, working units, by which faces of solids may have been moved to one another where they touch.
    contacts : frozenset of str
        Names of faces that stand for contacts, where the solids share nothing.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> part = cs.load("models/flanges.step")
    >>> [solid.name for solid in part.solids]
    ['lower', 'gasket', 'upper']
    >>> shared = set(part.solids[0].face_keys) & set(part.solids[1].face_keys)
    >>> len(shared)  # the gasket lies on one face of the lower flange
    1
    """

    solids: tuple[Solid, ...]
    name: str = "part"
    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    notes: tuple[str, ...] = ()
    names: dict[str, str] = field(default_factory=dict)
    owners: tuple[int, ...] = ()
    models: tuple[ModelSolid, ...] = ()
    cuts: tuple[Cut, ...] = ()
    touch: float = 0.0
    contacts: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        if not self.owners:
            object.__setattr__(self, "owners", tuple(range(len(self.solids))))
        if not self.models:
            models = tuple(
                ModelSolid(
                    name=solid.name or (f"solid_{j + 1}" if len(self.solids) > 1 else self.name),
                    volume=solid.volume,
                    material=solid.material,
                    color=solid.color,
                )
                for j, solid in enumerate(self.solids)
            )
            object.__setattr__(self, "models", models)

    def __repr__(self) -> str:
        volume = sum(solid.volume for solid in self.solids) * self.scale**3
        n_faces = sum(len(solid.faces) for solid in self.solids)
        solids = ", ".join(model.name for model in self.models[:6]) + (", ..." if len(self.models) > 6 else "")
        cells = f" in {len(self.solids)} cells" if len(self.solids) > len(self.models) else ""
        count = f"{len(self.models)} solid{'s' * (len(self.models) > 1)}"
        return f"Part {self.name}: {n_faces} faces, volume {volume:.6g}\n  {count}{cells}: {solids}"

    def _repr_html_(self) -> str:
        return str(do("part_card", self))

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring points (..., 3) from working to model units; exact where nothing was shifted."""
        return Units(self.scale, self.offset).to_model(points)
