"""A fitted grid: hexahedra for a solid that no sweep, no columns and no cuts can fill.

Place in the flow: ``pipeline`` asks for it where all other ways refuse; it gives a mesh of one cell whose nodes know
their vertex, edge or face, to be untangled and checked like any other.

Method: faces that run smoothly into each other are one (:mod:`.grouping`, :mod:`.uniting`), and narrow rings are left
out (:mod:`.rings`). An overlay grid (:mod:`.grid`) along the part's axes (:mod:`.axes`) whose planes lie on the
part's own is kept where it is inside and made manifold; every quad of its skin is labelled with a face
(:mod:`.labels`); strips of faces that the grid is too coarse for are laid in (:mod:`.strips`); labels are changed
where few will do for the model's topology (:mod:`.mending`); borders of labels are matched with edges and their ends
with vertices (:mod:`.topology`); :mod:`.finding` does this. Sheets of hexahedra are laid under the skin and in the
rims of faces, and the rings with them (:mod:`.sheets`); nodes are put on vertices, edges and faces (:mod:`.placing`).
A topology that is not the CAD's is refused, never bent; where no grid has it, edges may be let go (:mod:`.letting`),
each of which is told, as few as will do. Faces end before tips that no quad fits into (:mod:`.tips`).

What it does not handle: holes, walls and faces smaller than a cell, but for rings and strips; there is no refinement of
a part of the grid.
"""

from .axes import choose_axes
from .facets import Facets, sampled
from .finding import Found, Labelled, farthest, find_on_grid, label_on_grid
from .grid import Grid, choose_planes, keep_inside
from .placing import place_on_model
from .sheets import lay_sheets
from .tips import Tip, end_before, find_tips
from .uniting import United, unite

__all__ = [
    "Facets",
    "Found",
    "Grid",
    "Labelled",
    "Tip",
    "United",
    "choose_axes",
    "choose_planes",
    "end_before",
    "farthest",
    "find_on_grid",
    "find_tips",
    "keep_inside",
    "label_on_grid",
    "lay_sheets",
    "place_on_model",
    "sampled",
    "unite",
]
