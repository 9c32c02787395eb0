"""OpenCASCADE's general fuse of separate solids, and what became of every solid, face and edge.

Place in the flow: called by :mod:`.joining`. Solids are arguments of their own, since an argument must not interfere
with itself; nothing is glued, since gluing does not check that it may. Solids whose boxes are apart are not fused, nor
are those of which :mod:`.whole_faces` finds that they touch in whole faces.

Not handled: whether the result is right. OpenCASCADE's own word says little; :mod:`.checking` looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy
from OCP.BOPAlgo import BOPAlgo_Builder

from ...arrays import FloatArray, IntArray
from ...errors import CadError
from ..shapes import EDGE, FACE, SOLID, bounds, compound, index_map, listed, near_boxes, subshapes, typed
from ..trial import attempted
from .whole_faces import WholeFaces, share_whole_faces

_SECONDS = 60.0
"""How long a fuse may take: one of a thousand solids takes some."""


class Fused:
    """Solids that share what they touch in.

    Attributes
    ----------
    pieces : list of list of TopoDS_Solid
        Entry i: what solid i has become.
    whole : set of int
        Solids that have the faces that they had, some of them together with others.
    """

    def __init__(self, shapes: Sequence[Any], fuzzy: float) -> None:
        self.pieces: list[list[Any]] = [[shape] for shape in shapes]
        self.whole: set[int] = set()
        self._builders: list[tuple[tuple[Any, Any], Any]] = []
        self._shared: list[WholeFaces] = []
        boxes = np.array([bounds(shape) for shape in shapes])
        for group in neighbours(boxes, fuzzy):
            if len(group) > 1:
                own = [shapes[i] for i in group]
                shared = share_whole_faces(own, boxes[group], fuzzy)
                if shared is None:
                    self._fuse(own, group, fuzzy)
                    continue
                self._shared.append(shared)
                for i, piece in zip(group.tolist(), shared.pieces, strict=True):
                    self.pieces[i] = [piece]
                    self.whole.add(i)

    def _fuse(self, shapes: Sequence[Any], numbers: IntArray, fuzzy: float) -> None:
        builder = BOPAlgo_Builder()
        for shape in shapes:
            builder.AddArgument(shape)
        builder.SetNonDestructive(True)
        builder.SetRunParallel(False)
        builder.SetUseOBB(True)
        builder.SetFuzzyValue(fuzzy)
        if not attempted(builder.Perform, "finding what solids touch in", seconds=_SECONDS):
            raise CadError(f"OpenCASCADE fails where {len(shapes)} solids touch: mesh them with interfaces='separate'")
        if builder.HasErrors():
            raise CadError(f"OpenCASCADE cannot find what {len(shapes)} solids touch in")
        for i, shape in zip(numbers, shapes, strict=True):
            became = listed(builder.Modified(shape)) or ([] if builder.IsDeleted(shape) else [shape])
            self.pieces[i] = [typed(solid, SOLID) for piece in became for solid in subshapes(piece, SOLID)]
        both = compound(shapes)
        self._builders.append(((index_map(both, FACE), index_map(both, EDGE)), builder))

    def image(self, sub: Any) -> Any:
        """What a face or an edge has become: itself, a compound, or None where it is gone."""
        for shared in self._shared:
            found = shared.image(sub)
            if found is not None:
                return found
        kind = int(sub.ShapeType() == EDGE)
        for maps, builder in self._builders:
            if maps[kind].Contains(sub):
                if builder.IsDeleted(sub):
                    return None
                became = listed(builder.Modified(sub))
                return compound(became) if became else sub
        return sub


def neighbours(boxes: FloatArray, reach: float) -> list[IntArray]:
    """Groups of boxes (n, 2, 3) that hang together, where boxes less than `reach` apart count as touching."""
    near = near_boxes(boxes, boxes, reach)
    n_groups, group = scipy.sparse.csgraph.connected_components(near, directed=False)
    order = np.argsort(group, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[order])) + 1) if n_groups else []
