"""What a mesh is expected to be and to cost, before anything of it is made.

Place in the flow: beside meshing; for those who want to see the figures first.

Method: of one sweep the intervals are assigned, and counted; sizes where accuracy may ask for finer edges are not
looked at. Of anything else (columns, cells, solids that touch) the volume is filled with cubes of the size.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from .. import estimate, intervals
from ..brep import Part
from ..errors import InputError, NotSweepableError
from ..estimate import Estimate
from ..options import SweepOptions
from .hints import resolve_hints
from .meshing import make_options
from .run import make_run

_FIRST_DEFAULT = 12.0
"""Cubes along the cube root of the volume where no size is given: about what the defaults make of a compact part."""


def expect(source: Any, /, **options: Any) -> Estimate:
    """Say what :func:`sweep_mesh` is expected to make of these options.

    Parameters
    ----------
    source, **options
        As for :func:`sweep_mesh`.

    Returns
    -------
    Estimate

    Raises
    ------
    InputError
        A wish means nothing of this part, contradicts another, or asks for more hexahedra than may be made.
    CadError
        The part cannot be read.

    Examples
    --------
    >>> import cadquery as cq
    >>> from cadsweep.pipeline.expecting import expect
    >>> expect(cq.Workplane().box(4, 3, 2), size=1.0, layers=2).n_hexes
    24
    """
    from .attempts import find_candidates
    from .routes import open_part

    chosen = make_options(options)
    run = make_run(None, chosen.decompose_time)
    part = open_part(source, chosen, run)
    chosen = replace(chosen, params=None, part=None, names=None, suppress=None)  # about the source, which is open now
    found = None
    if len(part.solids) == 1 and not chosen.cuts:
        try:
            opened, sweeps = find_candidates(part, chosen, run)
        except NotSweepableError:
            sweeps = []
        if sweeps:
            found = _of_sweep(opened, sweeps[0], chosen)
    if found is None:
        found = _of_volume(part, chosen)
    n_hexes = found.n_hexes * 8**chosen.refine
    if chosen.max_hexes is not None and n_hexes > chosen.max_hexes:
        raise InputError(f"about {n_hexes:,} hexahedra are expected, more than the {chosen.max_hexes:,.0f} allowed")
    return found


def _of_sweep(part: Part, sweep: Any, options: SweepOptions) -> Estimate:
    hints = resolve_hints(part, sweep, options)
    counts = intervals.assign_intervals(
        sweep,
        size=None if options.size is None else options.size / part.scale,
        layers=options.layers,
        edge_sizes=hints.sizes,
        edge_counts=hints.counts,
    )
    return estimate.estimate(sweep, counts, scale=part.scale)


def _of_volume(part: Part, options: SweepOptions) -> Estimate:
    volume = sum(model.volume for model in part.models) * part.scale**3
    size = options.size or volume ** (1 / 3) / _FIRST_DEFAULT
    n_hexes = max(1, math.ceil(volume / size**3))
    n_quads = max(1, round(n_hexes ** (2 / 3)))
    return Estimate(
        n_quads=n_quads,
        n_layers=max(1, round(n_hexes / n_quads)),
        n_hexes=n_hexes,
        n_bytes=int(estimate.BASE_BYTES + estimate.BYTES_PER_HEX * n_hexes + estimate.BYTES_PER_QUAD * n_quads),
        seconds=1.0 + estimate.SECONDS_PER_QUAD * n_quads + estimate.SECONDS_PER_HEX * n_hexes,
        size=size,
    )
