"""From a sweep to its factors: intervals, surfaces, target cap, layers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..blocks.block import FactoredMesh, factor_mesh
from ..blocks.naming import find_colors, name_sweep
from ..brep import ModelSolid, Part, volume_doubt
from ..estimate import estimate_made
from ..mesh import SurfaceMesh
from ..options import SweepOptions
from ..projection import project_layers
from ..sweep import Intervals, Sweep
from .nearness.accuracy import accurate_boundary, check_coarse
from .run import Run
from .wishes.periodic_sides import cap_motion, of_sweep
from .wishes.wall_heights import between_caps, on_caps, row_tolerance


class Factored(NamedTuple):
    """The factors of a sweep, its caps and sides, and how many times farther off the CAD these are than allowed."""

    mesh: FactoredMesh
    surfaces: SurfaceMesh
    shortfall: float


def factor_sweep(part: Part, sweep: Sweep, options: SweepOptions, run: Run, *, streamed: bool = False) -> Factored:
    """Everything up to the factors: the whole mesh, before it is multiplied out."""
    boundary = accurate_boundary(part, sweep, options, run, streamed=streamed)
    made = estimate_made(sweep, boundary.counts, boundary.surfaces, scale=part.scale, streamed=streamed)
    run.expects(made, settled=True)
    check_coarse(boundary.deviation, options, doubt=volume_doubt(sweep.solid) / sweep.solid.volume)
    counts, surfaces, target = boundary.counts, boundary.surfaces, boundary.target
    with run.stage("projection"):
        if surfaces.source.walls:
            surfaces, target = on_caps(sweep, surfaces, target)
            motion = cap_motion(sweep, of_sweep(part, sweep, options))
            if motion is not None:
                target = replace(target, points=motion(surfaces.source.points))
        place = partial(
            project_layers,
            surfaces.source.points,
            surfaces.source.quads,
            surfaces.rings,
            loops=surfaces.source.loops,
            functional=options.functional,
            strategy=options.strategy,
            target_points=target.points,
            residual=options.residual,
        )
        placed = place()
        known = between_caps(sweep, surfaces, placed) if surfaces.source.walls else None
        if known is not None:
            placed = place(known=known, residual_tolerance=row_tolerance(surfaces))
    name = sweep.solid.name or part.name
    model = ModelSolid(name=name, volume=sweep.solid.volume, color=sweep.solid.color)
    alone = Part(solids=(sweep.solid,), models=(model,))
    factored = factor_mesh(
        sweep,
        surfaces,
        placed,
        target.faces,
        periodic=sweep.closed,
        part=name,
        scale=part.scale,
        offset=part.offset,
        info={
            "part": part.name,
            "material": sweep.solid.material,
            "cad_volume": sweep.solid.volume * part.scale**3,
            "cad_volume_doubt": volume_doubt(sweep.solid) * part.scale**3,
            "sweeps": [_describe(sweep, counts) | {"solid": name}],
            "names": dict(part.names),
            "colors": find_colors(alone, name_sweep(sweep)),
            "distance": boundary.deviation.distance * part.scale,
            "notes": [*part.notes, *sweep.notes, *boundary.notes, *surfaces.notes, *target.notes],
            "seconds": run.seconds,
        },
    )
    kept = [rows.nodes.ravel() for rows in surfaces.source.walls]
    if kept:
        factored = replace(factored, kept_nodes=np.concatenate(kept))
    return Factored(factored, surfaces, boundary.shortfall)


def _describe(sweep: Sweep, counts: Intervals) -> dict[str, Any]:
    """What a report says of a sweep: faces by name, or by id where they have none; layers in all, and by span."""
    faces = sweep.solid.faces
    return {
        "source": [faces[i].shown for i in sweep.source],
        "target": [faces[i].shown for i in sweep.target],
        "layers": counts.n_layers,
        "span_layers": list(counts.span_layers[0]),
    }
