"""CAD in, :class:`cadsweep.topology.Part` out: the only package that touches OpenCASCADE and CadQuery.

``load`` reads and cleans, ``select_faces`` finds the faces a user means, ``cut_ring`` opens a full ring,
``merge_faces`` undoes divisions of one plane or cylinder.
"""

from typing import TYPE_CHECKING

from .loading import load
from .selection import select_faces

if TYPE_CHECKING:
    from ..topology import Part

__all__ = ["cut_ring", "load", "merge_faces", "select_faces"]


def cut_ring(part: "Part") -> "Part | None":
    """Cut a full ring of revolution open (:func:`cadsweep.cad.rings.cut_ring`)."""
    # OpenCASCADE takes 1.6 s to import, and `import cadsweep.cad` should not.
    from .rings import cut_ring as cut

    return cut(part)


def merge_faces(part: "Part") -> "Part | None":
    """Merge faces that divide one plane or cylinder (:func:`cadsweep.cad.merging.merge_faces`)."""
    from .merging import merge_faces as merge

    return merge(part)
