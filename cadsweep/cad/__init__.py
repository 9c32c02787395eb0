"""CAD in, :class:`cadsweep.brep.Part` out: the only package that touches OpenCASCADE and CadQuery.

``load`` reads and cleans, ``select_faces`` and ``select_edges`` find what a user means, ``cut_ring`` and
``cut_closed`` open a full ring, ``find_mergeable`` and ``merge_faces`` undo divisions of one surface,
``divide_roundings`` divides the roundings of a cap's edges and ``divide_annuli`` plane faces around a hole,
``bridge_tips`` ends faces before their tips, ``flatten_marks`` takes low embossing off them, and ``find_crossing`` says
where a solid runs into itself.
"""

from math import inf
from typing import TYPE_CHECKING, Any

from .edit.notes import ANNULI_NOTE, TIPS_NOTE
from .imprinting.contacts import find_contacts
from .loading import load
from .names.selection import select_edges, select_edges_of, select_faces, select_faces_of_all, select_vertices

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    from ..arrays import BoolArray, FloatArray, IntArray
    from ..brep import Part, Solid
    from ..stack import Arrangement, Outline, Stack
    from .edit.collapsing import Rounding
    from .edit.cutters import Cutter
    from .edit.cutting import Parted
    from .edit.design import Design

__all__ = [
    "ANNULI_NOTE",
    "TIPS_NOTE",
    "apply_cuts",
    "arrange",
    "bridge_tips",
    "contains",
    "cut_along",
    "cut_by_image",
    "cut_closed",
    "cut_ring",
    "design_of",
    "divide_annuli",
    "divide_corners",
    "divide_edges",
    "divide_roundings",
    "find_contacts",
    "find_crossing",
    "find_cutters",
    "find_facets",
    "find_mergeable",
    "find_touching",
    "flatten_marks",
    "from_inside",
    "give_names",
    "hanging_together",
    "has_sharp_corners",
    "imprint",
    "join_halves",
    "load",
    "merge_faces",
    "name_of_cut",
    "part_apart",
    "rearrange",
    "select_edges",
    "select_edges_of",
    "select_faces",
    "select_faces_of_all",
    "select_vertices",
    "split_cell",
    "walls_between_columns",
    "write_step",
]


def part_apart(part: "Part") -> "Part | None":
    """One solid before others were imprinted on it (:func:`cadsweep.cad.imprinting.apart.part_apart`)."""
    from .imprinting.apart import part_apart as find

    return find(part)


def flatten_marks(part: "Part", length: float) -> "Part":
    """Take embossing off that is lower than a length (:func:`cadsweep.cad.edit.marks.flatten_marks`)."""
    from .edit.marks import flatten_marks as flatten

    return flatten(part, length)


def bridge_tips(part: "Part", length: float) -> "Part":
    """End faces before their tips (:func:`cadsweep.cad.edit.bridging.bridge_tips`)."""
    from .edit.bridging import bridge_tips as bridge

    return bridge(part, length)


def has_sharp_corners(solid: "Solid") -> bool:
    """Whether a face ends in a tip (:func:`cadsweep.cad.edit.corners.has_sharp_corners`)."""
    from .edit.corners import has_sharp_corners as has

    return has(solid)


def contains(part: "Part", faces: "Sequence[int]") -> "Callable[[FloatArray], BoolArray]":
    """Tell which points lie in some faces (:func:`cadsweep.cad.imprinting.apart.contains`)."""
    from .imprinting.apart import contains as tell

    return tell(part, faces)


def arrange(
    solid: "Solid", direction: "FloatArray", sides: "Mapping[int, int]", lines: "Sequence[int]"
) -> "Arrangement":
    """Carry outlines on one plane and find its cells (:func:`cadsweep.cad.edit.arrangement.arrange`)."""
    from .edit.arrangement import arrange as make

    return make(solid, direction, sides, lines)


def rearrange(  # noqa: PLR0917
    solid: "Solid",
    direction: "FloatArray",
    sides: "Mapping[int, int]",
    arrangement: "Arrangement",
    vertices: "FloatArray",
    outlines: "Sequence[Outline]",
) -> "Arrangement":
    """Make the cells again of outlines laid together (:func:`cadsweep.cad.edit.rearranging.rearrange`)."""
    from .edit.rearranging import rearrange as make

    return make(solid, direction, sides, arrangement, vertices, outlines)


def apply_cuts(part: "Part", cuts: "Sequence[Any]") -> "Part":
    """Cut by what a user asks for (:func:`cadsweep.cad.edit.user_cuts.apply_cuts`)."""
    from .edit.user_cuts import apply_cuts as cut

    return cut(part, cuts)


def name_of_cut(cut: "Any") -> str:
    """What a message calls a user's cut (:func:`cadsweep.cad.edit.user_cuts.name_of_cut`)."""
    from .edit.user_cuts import name_of_cut as name

    return name(cut)


def cut_along(part: "Part", polygons: "Sequence[Any]") -> "Part | None":
    """Cut a planar solid along polygons (:func:`cadsweep.cad.edit.polygons.cut_along`)."""
    from .edit.polygons import cut_along as cut

    return cut(part, polygons)


def walls_between_columns(stack: "Stack", walls: "Sequence[tuple[int, float, float]]") -> "Cutter":
    """What parts the columns of a stack (:func:`cadsweep.cad.edit.columns.walls_between_columns`)."""
    from .edit.columns import walls_between_columns as find

    return find(stack, walls)


def cut_ring(part: "Part") -> "Part | None":
    """Cut a full ring of revolution open (:func:`cadsweep.cad.rings.cut_ring`)."""
    # OpenCASCADE takes 1.6 s to import, and `import cadsweep.cad` should not.
    from .edit.rings import cut_ring as cut

    return cut(part)


def cut_closed(part: "Part") -> "Iterator[Part]":
    """Cut a closed sweep along any curve open (:func:`cadsweep.cad.closed.cut_closed`)."""
    from .edit.closed import cut_closed as cut

    return cut(part)


def design_of(part: "Part", blends: "Sequence[Rounding]") -> "Design | None":
    """Take blends away in a copy (:func:`cadsweep.cad.edit.design.design_of`)."""
    from .edit.design import design_of as find

    return find(part, blends)


def divide_annuli(part: "Part") -> "Part | None":
    """Divide plane faces with one hole across (:func:`cadsweep.cad.annuli.divide_annuli`)."""
    from .edit.annuli import divide_annuli as divide

    return divide(part)


def divide_edges(part: "Part", places: "Mapping[int, Mapping[int, Sequence[float]]]") -> "Part | None":
    """Divide edges of a part (:func:`cadsweep.cad.edit.splitting.divide_edges`)."""
    from .edit.splitting import divide_edges as divide

    return divide(part, places)


def divide_corners(part: "Part") -> "Part | None":
    """Divide the roundings all around a block (:func:`cadsweep.cad.fillets.divide_corners`)."""
    from .edit.fillets import divide_corners as divide

    return divide(part)


def divide_roundings(part: "Part", caps: "Sequence[tuple[int, Sequence[int]]]") -> "Part | None":
    """Divide faces that round the edges of caps (:func:`cadsweep.cad.fillets.divide_roundings`)."""
    from .edit.fillets import divide_roundings as divide

    return divide(part, caps)


def find_mergeable(part: "Part", *, across_kinks: bool = False) -> list[tuple[int, ...]]:
    """Groups of edges that divide one surface (:func:`cadsweep.cad.merging.find_mergeable`)."""
    from .edit.merging import find_mergeable as find

    return find(part, across_kinks=across_kinks)


def give_names(part: "Part", names: "Mapping[str, Any]") -> "Part":
    """Name faces and edges of a loaded part (:func:`cadsweep.cad.names.giving.give_names`)."""
    from .names.giving import give_names as give

    return give(part, names)


def hanging_together(solid: "Solid", faces: "Collection[int]") -> list[list[int]]:
    """Faces in groups that hang together (:func:`cadsweep.cad.edit.features.hanging_together`)."""
    from .edit.features import hanging_together as group

    return group(solid, faces)


def imprint(shapes: "Sequence[Any]", **how: "Any") -> "Part":
    """Make one part of separate solids (:func:`cadsweep.cad.imprinting.joining.imprint`)."""
    from .imprinting.joining import imprint as join

    return join(shapes, **how)


def join_halves(part: "Part", caps: "Sequence[Sequence[int]]") -> "Part | None":
    """Join plane caps to the halves of divided roundings (:func:`cadsweep.cad.fillets.join_halves`)."""
    from .edit.fillets import join_halves as join

    return join(part, caps)


def merge_faces(part: "Part", groups: "Sequence[Sequence[int]]") -> "Part | None":
    """Merge faces across such edges (:func:`cadsweep.cad.merging.merge_faces`)."""
    from .edit.merging import merge_faces as merge

    return merge(part, groups)


def find_crossing(solid: "Solid", *, coincident: "Collection[int]" = ()) -> tuple[int, int] | None:
    """Find two faces that cross each other (:func:`cadsweep.cad.crossing.find_crossing`)."""
    from .geometry.crossing import find_crossing as find

    return find(solid, coincident=coincident)


def find_touching(solid: "Solid") -> "tuple[int, int, FloatArray] | None":
    """Find two faces that touch without a vertex in common (:func:`cadsweep.cad.crossing.find_touching`)."""
    from .geometry.crossing import find_touching as find

    return find(solid)


def from_inside(solid: "Solid") -> "list[Cutter]":
    """Triangles from all edges to a point inside (:func:`cadsweep.cad.edit.stars.from_inside`)."""
    from .edit.stars import from_inside as find

    return find(solid)


def find_cutters(part: "Part", cell: int, faces: "Collection[int]" = ()) -> "Iterator[Cutter]":
    """Surfaces that may part a cell (:func:`cadsweep.cad.edit.cutters.find_cutters`)."""
    from .edit.cutters import find_cutters as find

    return find(part, cell, faces)


def find_facets(solid: "Solid") -> "list[tuple[FloatArray, IntArray]]":
    """Facet every face, for pictures (:func:`cadsweep.cad.geometry.facets.find_facets`)."""
    from .geometry.facets import find_facets as find

    return find(solid)


def cut_by_image(
    part: "Part", cell: int, of: "tuple[int, int]", matrix: "FloatArray", shift: "FloatArray"
) -> "Part | None":
    """Cut a cell along a face that is carried to it (:func:`cadsweep.cad.edit.images.cut_by_image`)."""
    from .edit.images import cut_by_image as cut

    return cut(part, cell, of, matrix, shift)


def split_cell(part: "Part", cell: int, cutter: "Cutter", others: "Sequence[int]" = ()) -> "Parted | None":
    """Part one cell, and others with it (:func:`cadsweep.cad.edit.cutting.split_cell`)."""
    from .edit.cutting import split_cell as split

    return split(part, cell, cutter.tools, others if cutter.everywhere else ())


def suppress(part: "Part", words: "Sequence[str]", *, seconds: float = inf) -> "Part":
    """Remove features that a user names (:func:`cadsweep.cad.edit.defeaturing.suppress`)."""
    from .edit.defeaturing import suppress as remove

    return remove(part, words, seconds=seconds)


def small_features(part: "Part") -> list[str]:
    """The words for what small features a part has (:func:`cadsweep.cad.edit.defeaturing.small_features`)."""
    from .edit.defeaturing import small_features as say

    return say(part)


def write_step(part: "Part", path: "Path") -> list[str]:
    """Write the cells of a part as named solids (:func:`cadsweep.cad.write.write_step`)."""
    from .write import write_step as write

    return write(part, path)
