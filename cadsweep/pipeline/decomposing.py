"""A solid that no sweep fits, cut into cells that all sweep and agree, and meshed cell by cell.

The search (:mod:`cadsweep.decompose`) gives one set of cells after the other, the likeliest first; the first whose
mesh does well is taken, and of several that do worse the best.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from math import pi

from .. import decompose, recognition
from ..brep import Part, Solid
from ..errors import CadSweepError, InputError, NotSweepableError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..plan import Plan, list_ways, make_plan
from ..sweep import Sweep
from .candidates import GOOD_ENOUGH
from .parts import only_solid
from .run import Run
from .several import Complex, mesh_complex
from .shared_hints import resolve_wishes

log = logging.getLogger(__name__)

MOST_MESHED = 4
"""Sets of cells that are meshed before the best of them is taken."""
_FEW = 2
"""Re-entrant edges of a cell up to which all readings of its faces are worth their time."""
_ONE_SWEEP = ("source", "target", "bias", "fractions", "rail_layers")


def recognise(solid: Solid) -> list[Sweep]:
    """Sweeps of a cell that a plan can use: the fast way, and thoroughly only for cells that are nearly convex."""
    for most_readings in (1, None):
        sweeps = recognition.search_sweeps(solid, folds=False, most_readings=most_readings).sweeps
        usable = [sweep for sweep in sweeps if list_ways([sweep])]
        if usable or sum(edge.dihedral > pi + 1e-6 for edge in solid.edges) > _FEW:
            return usable
    return []


def may_decompose(part: Part, options: SweepOptions) -> bool:
    """Whether cuts may be looked for: what the user asks of one sweep cannot be had of several."""
    return len(part.solids) == 1 and all(getattr(options, name) is None for name in _ONE_SWEEP)


def mesh_decomposed(part: Part, options: SweepOptions, run: Run, refused: CadSweepError | None) -> HexMesh:
    """Cut a solid into cells and mesh them.

    Raises
    ------
    NotSweepableError
        No cuts were found; names the cell and the edges in the way.
    SurfaceMeshError, ProjectionError, InvertedHexError
        Cells were found, and none of their meshes is valid.
    """
    assert refused is not None
    solid = only_solid(part)
    if not may_decompose(part, options) or not decompose.is_planar(solid):
        raise refused
    search = decompose.Search(model=solid, recognise=recognise, make_plan=make_plan)
    best: HexMesh | None = None
    failure: CadSweepError | None = None
    solutions = search.solutions()
    for _ in range(MOST_MESHED):
        with run.stage("decomposition"):
            state = next(solutions, None)
        if state is None:
            break
        cells = cells_of(part, search, state)
        assert isinstance(state.plan, Plan)
        found = Complex(part=cells, plan=state.plan)
        try:
            mesh = mesh_complex(found, options, run, resolve_wishes(cells, options))
        except InputError:
            raise
        except CadSweepError as error:
            log.info("%d cells given up: %s", len(cells.solids), error)
            failure = failure or error
            continue
        if best is None or _worst(mesh) > _worst(best):
            best = mesh
        if _worst(best) >= GOOD_ENOUGH:
            break
    if best is not None:
        return best
    if failure is not None or not isinstance(refused, NotSweepableError):
        raise failure or refused
    raise decompose.explain(search, refused)


def _worst(mesh: HexMesh) -> float:
    return float(mesh.info["quality"].min_scaled_jacobian)


def cells_of(part: Part, search: decompose.Search, state: decompose.State) -> Part:
    """The cells of a state as a part: all of them pieces of its one solid."""
    return replace(
        part,
        solids=tuple(search.look(cell).solid for cell in state.cells),
        owners=(0,) * len(state.cells),
        notes=(*part.notes, decompose.say(search, state)),
    )


__all__ = ["cells_of", "may_decompose", "mesh_decomposed", "recognise"]
