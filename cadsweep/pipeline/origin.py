"""What a mesh was made from, kept beside it while the process lives: by it the mesh can be refined, or carried."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from ..blocks.block_mesh import BlockMesh
from ..blocks.cells import CellBlocks
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces
from ..blocks.reference import make_references
from ..brep import Part
from ..entity.entities import Entities
from ..errors import InputError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..quality import CadReference, QualityReport
from ..sweep import Sweep

if TYPE_CHECKING:
    from ..blends.borders import BorderChoice


class DesignChoice(NamedTuple):
    """How a mesh was made of a design: what another part needs to be meshed alike.

    `blends` are the numbers of those that the design has not, among all that the model has, `roles` what faces of the
    design are in its mesh, by their keys, `borders` the lines of it on borders of blends.
    """

    blends: tuple[int, ...]
    roles: dict[str, str]
    is_sheeted: bool
    borders: BorderChoice = ()


class FromDesign(NamedTuple):
    """The mesh of the design that a mesh was carried to its model from, and how that was.

    `last`: makes the mesh that is handed over of one that was compared with others, see :func:`with_last`.
    """

    mesh: HexMesh
    choice: DesignChoice
    last: Callable[[], HexMesh] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class CellsOrigin:
    """Of a mesh of several cells or of columns: the cells, and the mesh before its order was raised.

    Attributes
    ----------
    model : Part
        The solids as they were before they were cut; with nothing cut, the cells themselves.
    part : Part
        The cells.
    joined : JoinedMesh
        Its nodes are those of the mesh, working units.
    names : NamedFaces
    options : SweepOptions
    cells : CellBlocks or None
        The factors of which `joined` was multiplied out before its nodes were smoothed, where it was.
    is_swept : bool
        Whether the model is as it was made ready for one sweep.
    sweep : Sweep or None
        That sweep, of a mesh that was not carried from another part.
    design : FromDesign or None
        Of a mesh that was carried from a design.
    """

    model: Part
    part: Part
    joined: JoinedMesh
    names: NamedFaces
    options: SweepOptions
    cells: CellBlocks | None = None
    is_swept: bool = False
    sweep: Sweep | None = None
    design: FromDesign | None = None

    @cached_property
    def entities(self) -> Entities:
        """Where the nodes are."""
        return Entities(part=self.part, joined=self.joined, names=self.names)

    @property
    def references(self) -> Mapping[str, CadReference]:
        """What the CAD model says that the mesh must be, by solid."""
        return make_references(self.part, self.names)

    def of_joined(self, joined: JoinedMesh) -> CellsOrigin:
        """Of a mesh that was made of this one, and is no product of factors."""
        return replace(self, joined=joined, cells=None, design=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Solids that touch, or one that touches no other, and their mesh.

    Attributes
    ----------
    solids : tuple of str
    given : frozenset of str
        Boundary names that the user gave; the others of a solid by itself are called after it.
    mesh : HexMesh
        As if it were the whole part.
    part : Part
        The solids, with a face a contact, whether the mesh follows its outline or not.
    """

    solids: tuple[str, ...]
    given: frozenset[str]
    mesh: HexMesh
    part: Part


@dataclass(frozen=True, kw_only=True, eq=False)
class GroupsOrigin:
    """Of a mesh of solids that do not all touch: the meshes of those that do, each with an origin of its own.

    Attributes
    ----------
    part : Part
    groups : tuple of Group
    options : SweepOptions
    """

    part: Part
    groups: tuple[Group, ...]
    options: SweepOptions


AnyOrigin = CellsOrigin | GroupsOrigin

AnyMesh = HexMesh | BlockMesh
"""What the ways to a mesh make: one in memory, or one that stays in blocks."""


def quality_of(mesh: AnyMesh) -> QualityReport:
    """What the checks found of a mesh."""
    report: QualityReport = mesh.info["quality"]
    return report


def worst_of(mesh: AnyMesh) -> float:
    """Worst scaled Jacobian of a mesh that was judged."""
    return quality_of(mesh).min_scaled_jacobian


def origin_of(mesh: HexMesh, purpose: str) -> AnyOrigin:
    """The origin of a mesh.

    Raises
    ------
    InputError
        It has none.
    """
    if isinstance(mesh.origin, AnyOrigin):
        return mesh.origin
    raise InputError(
        f"{purpose} needs the CAD model that the mesh was made from, and this mesh comes from a file or from another "
        "process: make it with cadsweep.sweep_mesh(...), without isolated=True"
    )


def made_of(mesh: HexMesh, model: Part, sweep: Sweep | None = None) -> HexMesh:
    """The mesh, knowing the part that its cells were cut from, or that was made ready for one sweep."""
    if not isinstance(mesh.origin, CellsOrigin) or mesh.origin.is_swept:
        return mesh
    return replace(mesh, origin=replace(mesh.origin, model=model, is_swept=sweep is not None, sweep=sweep))


def to_be(mesh: HexMesh, last: Callable[[], HexMesh]) -> HexMesh:
    """A mesh of a design that is to be another one, once it is known to be the best."""
    assert isinstance(mesh.origin, CellsOrigin), "one solid"
    assert mesh.origin.design is not None, "of a design"
    return replace(mesh, origin=replace(mesh.origin, design=mesh.origin.design._replace(last=last)))


def with_last(mesh: HexMesh) -> HexMesh:
    """The mesh with what is done to it once it is known to be the best: lines of it laid on borders of blends."""
    design = mesh.origin.design if isinstance(mesh.origin, CellsOrigin) else None
    return mesh if design is None or design.last is None else design.last()


def first_order(mesh: HexMesh, n_nodes: int) -> HexMesh:
    """A mesh with so many corners as one of order 1: of a hex and a quad of any order they come first."""
    boundaries = {name: quads[:, :4] for name, quads in mesh.boundaries.items()}
    interfaces = {name: quads[:, :4] for name, quads in mesh.interfaces.items()}
    return replace(
        mesh, points=mesh.points[:n_nodes], hexes=mesh.hexes[:, :8], boundaries=boundaries, interfaces=interfaces
    )
