"""The boundary representation as ids and numbers: what every stage after ``cad`` sees.

Place in the flow: ``cad`` makes these objects; ``recognition``, ``intervals`` and ``surface`` read
them. No OpenCASCADE type appears here; geometry is met only through the small protocols
:class:`Curve` and :class:`Surface`.

Lengths are *working* lengths: ``cad`` scales and shifts a part so that its size suits OpenCASCADE
and gmsh. :meth:`Part.to_model` brings points back to model units, bit for bit where nothing was
scaled.

Not handled here: geometry that is not a solid, and non-manifold solids; ``cad`` refuses them.
"""

from .entities import RIGHT_TURN, Edge, Face, FormerFace, GainedTip, Loop, lie_in, quarter_turns
from .geometry import Curve, Surface, Units
from .part import Cut, ModelSolid, Part
from .solid import Solid, volume_doubt

__all__ = [
    "RIGHT_TURN",
    "Curve",
    "Cut",
    "Edge",
    "Face",
    "FormerFace",
    "GainedTip",
    "Loop",
    "ModelSolid",
    "Part",
    "Solid",
    "Surface",
    "Units",
    "lie_in",
    "quarter_turns",
    "volume_doubt",
]
