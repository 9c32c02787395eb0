"""From a candidate sweep to a mesh that has passed its checks, and from several candidates to the best."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import cad, smoothing
from ..blocks.block import FactoredMesh
from ..blocks.reference import make_reference
from ..blocks.stream import check_boundary
from ..brep import Part
from ..errors import CadError, CadSweepError, InputError, NotSweepableError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..order2.curving import project_to_edges, project_to_faces
from ..order2.elevate import elevate
from ..quality import QualityReport, check_mesh
from ..quality.check import SurfaceFindings
from ..sweep import Sweep
from .factoring import factor_sweep
from .origin import Origin
from .parts import find_candidates
from .refusing import explain_crossings, refusal
from .run import Progress, Run, silent

log = logging.getLogger(__name__)

GOOD_ENOUGH = 0.1
"""Worst scaled Jacobian at which no other candidate sweep is tried."""

SMOOTH_BELOW = 0.3
"""Worst scaled Jacobian below which smoothing is tried."""

COARSE = 0.01
"""Part of the volume that a mesh may lose or gain without a note."""

DOUBTFUL_VOLUME = 1e-4
"""Part of the volume that gaps between faces may leave open without a note; what CAD kernels leave is far below."""

MOST_CANDIDATES = 3
"""Sweeps of one solid that are tried before the first one's error is raised."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Made:
    """One candidate sweep, made and checked."""

    factored: FactoredMesh
    report: QualityReport
    mesh: HexMesh | None = None


Make = Callable[[Part, Sweep, SweepOptions, Run, float], Made]
"""Makes one candidate; the last argument is the worst scaled Jacobian of the best one so far."""


def first_good(part: Part, sweeps: list[Sweep], options: SweepOptions, run: Run, make: Make) -> Made:
    """Make the first candidate that does well, or the best of those tried."""
    tried: list[Made] = []
    failures: list[CadSweepError] = []
    for sweep in sweeps[:MOST_CANDIDATES]:
        try:
            reached = max((one.report.min_scaled_jacobian for one in tried if one.report.valid), default=-np.inf)
            made = make(part, sweep, options, run, reached)
        except (InputError, NotSweepableError):
            raise  # what the user asked for cannot be had by another sweep either
        except CadSweepError as error:
            log.info("sweep from faces %s given up: %s", sweep.source, error)
            failures.append(error)
            continue
        tried.append(made)
        if made.report.valid and made.report.min_scaled_jacobian >= GOOD_ENOUGH:
            break
    if not tried:
        raise explained(sweeps[0], failures[0])
    best = max(tried, key=lambda made: (made.report.valid, made.report.min_scaled_jacobian))
    best.factored.info["notes"] += [f"a better ranked sweep was given up: {error}" for error in failures]
    return best


def make_mesh(part: Part, sweep: Sweep, options: SweepOptions, run: Run, reached: float) -> Made:
    """Mesh by one sweep; raises unless the mesh is valid or the user allows an invalid one."""
    factored, surfaces = factor_sweep(part, sweep, options, run)
    with run.stage("assembly"):
        mesh = factored.to_mesh()
    reference = make_reference(part, sweep)
    with run.stage("quality"):
        report = check_mesh(mesh, cad=reference)
    if options.smoothing and may_gain(report, options, reached):
        with run.stage("smoothing"):
            factored = smoothed(factored)
        if factored.is_changed:
            factored.points(out=mesh.points.reshape(-1, factored.structure.n_nodes, 3))
            with run.stage("quality"):
                report = check_mesh(mesh, cad=reference)
    if options.order == 2 and (report.valid or options.allow_inverted):
        with run.stage("order 2"):
            mesh = elevate(
                mesh,
                nodes=options.nodes,
                curves=project_to_edges(part, sweep, surfaces),
                surfaces=project_to_faces(part, sweep, factored),
                allow_inverted=options.allow_inverted,
            )
        with run.stage("quality"):
            report = check_mesh(mesh, cad=reference)
    mesh.info["quality"] = report
    if not report.valid and not options.allow_inverted:
        raise refusal(report, part, sweep)
    factored.info["notes"] += volume_notes(report, factored)
    origin = Origin(part=part, sweep=sweep, surfaces=surfaces, factored=factored, options=options)
    return Made(factored=factored, report=report, mesh=replace(mesh, origin=origin))


def may_gain(report: QualityReport, options: SweepOptions, reached: float) -> bool:
    """Whether smoothing is worth its while: the boundary allows a valid mesh, better than what others have reached."""
    if report.min_scaled_jacobian >= SMOOTH_BELOW and not report.n_inverted:
        return False
    least = reached if options.allow_inverted else max(reached, 0.0)
    return report.limit is None or report.limit.value > least


def smoothed(factored: FactoredMesh) -> FactoredMesh:
    """Mend the worst places; what was moved is kept beside the factors."""
    points = factored.points().reshape(-1, 3)
    structure = factored.structure
    fixed = np.zeros((factored.n_node_layers, structure.n_nodes), dtype=bool)
    fixed[:, np.concatenate(structure.loops)] = True
    if not structure.periodic:
        fixed[[0, -1]] = True
    better = smoothing.improve(points, structure, fixed=fixed.reshape(-1))
    factored.info["notes"] += better.steps
    return replace(
        factored, moved_nodes=better.nodes, moved_points=(better.positions - factored.offset) / factored.scale
    )


def explained(sweep: Sweep, failure: CadSweepError) -> CadSweepError:
    """Find out whether the model or the mesh is to blame: of a solid that runs into itself no mesh is valid."""
    if isinstance(failure, CadError):
        return failure
    solid = sweep.solid
    caps = (*sweep.source, *sweep.target) if sweep.closed else ()
    crossing = cad.find_crossing(solid, coincident=caps)
    if crossing is None:
        return failure
    first, second = (solid.faces[f].label() for f in crossing)
    error = CadError(
        f"{first} and {second} cross each other, so the model runs into itself and no mesh of it is valid. "
        "Repair it in its CAD program."
    )
    error.__cause__ = failure
    return error


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A mesh before any of its inner layers is made, and what its boundary is found to be."""

    factored: FactoredMesh
    surface: SurfaceFindings


def plan_mesh(source: Any, options: SweepOptions, *, on_progress: Progress | None = None) -> Plan:
    """Do all that needs CAD or gmsh, for a mesh that others will multiply out."""
    run = Run(on_progress=on_progress or silent)
    part, sweeps = find_candidates(source, options, run)
    failures: list[CadSweepError] = []
    for sweep in sweeps[:MOST_CANDIDATES]:
        try:
            factored, _ = factor_sweep(part, sweep, options, run, streamed=True)
            surface = check_boundary(factored, make_reference(part, sweep))
            if surface.crossings and not options.allow_inverted:
                raise explain_crossings(part, sweep, surface.crossings)
        except (InputError, NotSweepableError):
            raise
        except CadSweepError as error:
            failures.append(error)
            continue
        factored.info["notes"] += [f"a better ranked sweep was given up: {error}" for error in failures]
        return Plan(factored=factored, surface=surface)
    raise explained(sweeps[0], failures[0])


def volume_notes(report: QualityReport, factored: FactoredMesh) -> list[str]:
    """Say so where a valid mesh is too coarse to be the part: its facets cut off what is round."""
    known, doubt = factored.info["cad_volume"], factored.info["cad_volume_doubt"]
    notes = []
    if doubt > DOUBTFUL_VOLUME * known:
        notes.append(
            f"faces of the model miss each other, so that its volume is known to {doubt / known:.1g} of itself only; "
            "the checks allow for that"
        )
    off = report.volume / known - 1.0
    if abs(off) > COARSE + doubt / known:
        notes.append(
            f"the volume is {off:+.1%} off the CAD's, too coarse for its curves: take a smaller size or more layers"
        )
    return notes


def figures(factored: FactoredMesh, report: QualityReport) -> dict[str, Any]:
    """What is said of a mesh that is not in memory: the figures of ``cadsweep mesh --json``."""
    info = factored.info
    return {
        "n_nodes": report.n_nodes,
        "n_hexes": report.n_hexes,
        "min_scaled_jacobian": report.min_scaled_jacobian,
        "mean_scaled_jacobian": report.mean_scaled_jacobian,
        "n_inverted": report.n_inverted,
        "volume": report.volume,
        "cad_volume": info["cad_volume"],
        "seconds": info["seconds"],
        "sweeps": info["sweeps"],
        "material": info.get("material"),
        "notes": info["notes"] + volume_notes(report, factored),
    }
