"""A fitted grid: hexahedra for a solid that no sweep, no columns and no cuts can fill.

Place in the flow: ``pipeline`` asks for it where all other ways refuse; it gives a mesh of one cell whose nodes know
their vertex, edge or face, to be untangled and checked like any other.

Method: an overlay grid (:mod:`.grid`) whose planes lie on the part's own, kept where it is inside and made manifold;
every quad of its skin is labelled with a face (:mod:`.labels`); borders of labels are matched with edges and their
ends with vertices (:mod:`.topology`); sheets of hexahedra are laid under faces where quads would be flat
(:mod:`.sheets`); nodes are put on vertices, edges and faces (:mod:`.placing`).
A topology that is not the CAD's is refused, never bent.

What it does not handle: faces and edges smaller than a cell; inner edges that turn corners on the grid, as round ones
do; vertices with more than three faces.
"""

from .grid import Facets, Grid, choose_planes, keep_inside
from .labels import label_quads, name_pieces
from .merged import merge_seams
from .placing import place_on_model
from .sheets import Fitted, lay_sheets
from .topology import match_topology

__all__ = [
    "Facets",
    "Fitted",
    "Grid",
    "choose_planes",
    "keep_inside",
    "label_quads",
    "lay_sheets",
    "match_topology",
    "merge_seams",
    "name_pieces",
    "place_on_model",
]
