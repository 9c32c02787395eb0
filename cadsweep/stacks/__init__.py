"""The stage of parts that are columns of material along one direction, with caps at any number of levels.

Place in the flow: beside ``recognition`` to ``projection``, for a solid that is no plain sweep. ``pipeline`` has
``cad`` make the arrangement of the caps' outlines, and ``intervals`` and ``surface`` mesh it as one source cap.

========== =====================================================================
module     what it does
========== =====================================================================
normals    of all faces, and the directions that they suggest
sides      faces along a direction, faces across it, and those that are neither
along      heights of faces and edges over places on a plane
columns    cells and caps put in order: the stack, and the sweep of its prism
limits     what sharp outlines and steep caps allow the worst hexahedron, and where
graph      the lines of an arrangement as a planar graph that can be changed
steps      where outlines nearly coincide in plan
merging    those outlines laid together, where `outline_crossings` finds no new crossing by it
sheets     caps that share a level, and which level must lie over which
apart      which sheets come near each other in plan
levels     one integer programme for all levels
widths     how wide the cells of the arrangement are
planar     how good the quads of the arrangement are
mending    quads that are poor on the part's own levels, by the loops of `mending_kernels`
nodes      heights of all nodes
rims       heights of free levels along the lines between cells, evened out
places     places of the nodes of every level
harmonic   values of some nodes carried to the others
slides     nodes that may move on the part's faces
lines      nodes along the edges of the part
blocks     hexahedra, and the face of every boundary quad
straight   columns as products, where all caps are flat: for meshes larger than memory
touching   where columns touch, for who wants them as solids
========== =====================================================================
"""

from .apart import sheets_apart
from .blocks import build_mesh
from .columns import make_stack
from .levels import assign_levels
from .limits import is_round_across
from .mending import mend_quads
from .merging import NEAR, merge_outlines
from .normals import Normals, count_fitting, find_directions
from .planar import Judged, divide_at_cusps, judge_plane, sizes_across
from .sheets import Sheets, find_sheets, told_heights
from .sides import Sides, find_stations, read_sides
from .slides import find_slides
from .straight import build_straight
from .touching import touching_columns
from .widths import Widths

__all__ = [
    "NEAR",
    "Judged",
    "Normals",
    "Sheets",
    "Sides",
    "Widths",
    "assign_levels",
    "build_mesh",
    "build_straight",
    "count_fitting",
    "divide_at_cusps",
    "find_directions",
    "find_sheets",
    "find_slides",
    "find_stations",
    "is_round_across",
    "judge_plane",
    "make_stack",
    "mend_quads",
    "merge_outlines",
    "read_sides",
    "sheets_apart",
    "sizes_across",
    "told_heights",
    "touching_columns",
]
