"""The composition root: the only module that joins the stages.

``load`` -> ``find_sweeps`` -> intervals -> surface -> projection -> smoothing -> quality. A candidate
sweep that turns out not to mesh makes room for the next best one, and the mesh says so in its notes;
the user's own choice of caps is never replaced.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from . import cad, estimate, intervals, recognition, smoothing, surface
from .assembly import FactoredMesh, factor_mesh, is_ring, make_reference
from .curving import project_to_edges, project_to_faces
from .elevate import elevate
from .errors import CadError, CadSweepError, InputError, InvertedHexError, NotSweepableError
from .factors import load_factors, save_factors
from .io.atomic import check_place, replaced_file
from .mesh import HexMesh, SurfaceMesh
from .options import SweepOptions
from .projection import corrected, project_layers
from .projection.caps import place_target
from .quality import CadReference, QualityReport, check_mesh
from .quality.check import SurfaceFindings
from .streaming import check_boundary, make_slab_report, write_slabs
from .topology import Part, Solid, Sweep

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]
"""Called with the stage under way and how much of it is done (0 to 1, None where unknown)."""

GOOD_ENOUGH = 0.1
"""Worst scaled Jacobian at which no other candidate sweep is tried."""

SMOOTH_BELOW = 0.3
"""Worst scaled Jacobian below which smoothing is tried."""

MOST_CANDIDATES = 3
"""Sweeps of one solid that are tried before the first one's error is raised."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Run:
    """Seconds by stage, and the progress callback."""

    on_progress: Progress
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.on_progress(name, 0.0)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
        self.on_progress(name, 1.0)


def _silent(stage: str, fraction: float | None) -> None:
    """Progress for those who did not ask."""


def load(source: Any, *, params: dict[str, Any] | None = None) -> Part:
    """Read a part and make it clean for meshing.

    Parameters
    ----------
    source : path, CadQuery object, or anything with ``.wrapped``
        A ``.step``, ``.stp``, ``.brep``, ``.iges``, ``.igs`` or ``.py`` file; a ``cq.Workplane``,
        ``cq.Shape`` or ``cq.Assembly``. A CadQuery script is executed.
    params : dict or None
        Parameters of a script.

    Raises
    ------
    InputError
        No such file, an unknown format, or parameters that the script does not have.
    CadError
        The model cannot be read, or holds no usable solid.
    """
    if isinstance(source, Part):
        if params:
            raise InputError("params go with a script; this part is loaded already")
        return source
    return cad.load(source, params=params)


def find_sweeps(part: Any, *, source: Any = None, target: Any = None) -> list[Sweep]:
    """List the ways in which a part can be swept, best first.

    Parameters
    ----------
    part : Part, or whatever :func:`load` takes
    source, target : name, id, CadQuery selector string, sequence of them, or None
        Keep only sweeps with this cap.

    Raises
    ------
    NotSweepableError
        There is none; ``.reasons`` says why, a line for each candidate.
    """
    return _open_and_find(load(part), source, target)[1]


def _open_and_find(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]]:
    """Find the sweeps of a part; a full ring of revolution, which has none, is cut open first."""
    solid = _only_solid(part)
    try:
        return part, recognition.find_sweeps(solid, source=_resolve(part, source), target=_resolve(part, target))
    except NotSweepableError:
        ring = cad.cut_ring(part)
        if ring is None:
            raise
    sweeps = recognition.find_sweeps(_only_solid(ring), source=_resolve(ring, source), target=_resolve(ring, target))
    around = [sweep for sweep in sweeps if is_ring(sweep)]
    return ring, around or sweeps


def _only_solid(part: Part) -> Solid:
    if len(part.solids) != 1:
        raise CadError(
            f"'{part.name}' has {len(part.solids)} solids, and a sweep belongs to one: "
            "mesh them one by one, or fuse them first"
        )
    return part.solids[0]


def _resolve(part: Part, choice: Any) -> tuple[int, ...] | None:
    """Resolve the user's word for a cap to face ids."""
    if choice is None:
        return None
    choices = choice if isinstance(choice, list | tuple) else [choice]
    return tuple(dict.fromkeys(face for one in choices for face in cad.select_faces(part, one)))


def sweep_mesh(
    source: Any,
    /,
    *,
    isolated: bool = False,
    timeout: float | None = None,
    on_progress: Progress | None = None,
    **options: Any,
) -> HexMesh:
    """Mesh a part with hexahedra by sweeping.

    Parameters
    ----------
    source : Part, or whatever :func:`load` takes
        One solid.
    isolated : bool
        Work in a child process: a crash, a hang or too much memory there is a ``WorkerError`` here.
    timeout : float or None
        Wall time of the child process, seconds.
    on_progress : callable or None
        Called with the stage and the done fraction of it.
    **options
        The fields of :class:`cadsweep.options.SweepOptions`: ``size``, ``layers``, ``bias``,
        ``fractions``, ``functional``, ``strategy``, ``residual``, ``smoothing``, ``source``, ``target``,
        ``sizes``, ``params``, ``order``, ``nodes``, ``allow_inverted``, ``max_hexes``, ``max_memory``.

    Returns
    -------
    HexMesh
        Valid: every check of :func:`cadsweep.quality.check_mesh` has passed, and
        ``mesh.info["quality"]`` holds its report.

    Raises
    ------
    InputError, CadError, NotSweepableError, SurfaceMeshError, ProjectionError, InvertedHexError, WorkerError
        All of them ``CadSweepError``; no mesh is better than a wrong one.
    """
    chosen = make_options(options)
    if isolated:
        from .isolation import run_isolated

        result: HexMesh = run_isolated(
            "cadsweep.pipeline:sweep_mesh",
            (source,),
            options,
            timeout=timeout,
            max_memory=chosen.max_memory,
            on_progress=on_progress,
        )
        return result
    if timeout is not None:
        raise InputError("timeout goes with isolated=True: work in this process cannot be stopped")
    run = _Run(on_progress=on_progress or _silent)
    part, sweeps = _find(source, chosen, run)
    mesh = _first_good(part, sweeps, chosen, run, _make_mesh).mesh
    assert mesh is not None
    return mesh


def make_options(options: dict[str, Any]) -> SweepOptions:
    """Check keyword options; an unknown one is an error that lists those there are."""
    known = SweepOptions.__dataclass_fields__
    for name in options:
        if name not in known:
            raise InputError(f"there is no option '{name}'; there are {', '.join(known)}")
    return SweepOptions(**options)


def write_factors(
    source: Any, path: str | PathLike[str], /, *, on_progress: Progress | None = None, **options: Any
) -> HexMesh:
    """Mesh a part as :func:`sweep_mesh` does, and keep its factors: megabytes for any number of layers.

    Parameters
    ----------
    source, **options
        As for :func:`sweep_mesh`, of order 1.
    path : path
        A ``.sweep.npz`` file, for :func:`expand`.

    Returns
    -------
    HexMesh
        The mesh that the factors give back, bit for bit.
    """
    chosen = make_options(options)
    if chosen.order != 1:
        raise InputError("factors are those of a mesh of order 1; raise the order when they are expanded")
    run = _Run(on_progress=on_progress or _silent)
    part, sweeps = _find(source, chosen, run)
    made = _first_good(part, sweeps, chosen, run, _make_mesh)
    with replaced_file(check_place(Path(path))) as stream:
        save_factors(made.factored, stream)
    assert made.mesh is not None
    return made.mesh


def expand(path: str | PathLike[str]) -> HexMesh:
    """Multiply a file of factors out to its mesh; needs neither CAD nor gmsh.

    Raises
    ------
    InputError
        The file is missing, damaged, or something else.
    """
    mesh = load_factors(path).to_mesh()
    mesh.info["quality"] = check_mesh(mesh)
    return mesh


def stream_mesh(
    source: Any, path: str | PathLike[str], /, *, on_progress: Progress | None = None, **options: Any
) -> dict[str, Any]:
    """Mesh a part into a ``.vtkhdf`` file slab by slab, with flat memory, however large the mesh is.

    Every check is made on the way; the file appears only when the mesh is valid. A mesh that needs
    smoothing has its nodes, but not its hexahedra, in memory at once while it is mended.

    Parameters
    ----------
    source, **options
        As for :func:`sweep_mesh`, of order 1.
    path : path

    Returns
    -------
    dict
        The figures that ``cadsweep mesh --json`` prints.
    """
    chosen = make_options(options)
    if chosen.order != 1:
        raise InputError("a streamed mesh has order 1")
    if Path(path).suffix != ".vtkhdf":
        raise InputError(f"{path}: a mesh is streamed to a .vtkhdf file")
    place = check_place(Path(path))
    run = _Run(on_progress=on_progress or _silent)
    part, sweeps = _find(source, chosen, run)

    def make(part: Part, sweep: Sweep, options: SweepOptions, run: _Run) -> _Made:
        factored, _ = factor_sweep(part, sweep, options, run, streamed=True)
        reference = make_reference(part, sweep)
        with replaced_file(place) as stream:
            with run.stage("write"):
                report = _write_checked(stream, factored, reference, run)
            if options.smoothing and not report.min_scaled_jacobian >= SMOOTH_BELOW:
                with run.stage("smoothing"):
                    factored = smoothed(factored)
                if factored.is_changed:
                    stream.seek(0)
                    stream.truncate()
                    with run.stage("write"):
                        report = _write_checked(stream, factored, reference, run)
            if not report.valid and not options.allow_inverted:
                raise refusal(report)
        return _Made(factored=factored, report=report)

    made = _first_good(part, sweeps, chosen, run, make)
    return figures(made.factored, made.report)


def _write_checked(stream: BinaryIO, factored: FactoredMesh, reference: CadReference, run: _Run) -> QualityReport:
    seen = write_slabs(stream, factored, on_slab=lambda fraction: run.on_progress("write", fraction))
    return make_slab_report(factored, seen, check_boundary(factored, reference))


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
        "notes": info["notes"],
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """A mesh before any of its inner layers is made, and what its boundary is found to be."""

    factored: FactoredMesh
    surface: SurfaceFindings


def plan_mesh(source: Any, options: SweepOptions, *, on_progress: Progress | None = None) -> Plan:
    """Do all that needs CAD or gmsh, for a mesh that others will multiply out."""
    run = _Run(on_progress=on_progress or _silent)
    part, sweeps = _find(source, options, run)
    failures: list[CadSweepError] = []
    for sweep in sweeps[:MOST_CANDIDATES]:
        try:
            factored, _ = factor_sweep(part, sweep, options, run, streamed=True)
        except (InputError, NotSweepableError):
            raise
        except CadSweepError as error:
            failures.append(error)
            continue
        factored.info["notes"] += [f"a better ranked sweep was given up: {error}" for error in failures]
        return Plan(factored=factored, surface=check_boundary(factored, make_reference(part, sweep)))
    raise failures[0]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Made:
    """One candidate sweep, made and checked."""

    factored: FactoredMesh
    report: QualityReport
    mesh: HexMesh | None = None


def _find(source: Any, options: SweepOptions, run: _Run) -> tuple[Part, list[Sweep]]:
    with run.stage("cad"):
        part = load(source, params=None if options.params is None else dict(options.params))
    with run.stage("recognition"):
        return _open_and_find(part, options.source, options.target)


Make = Callable[[Part, Sweep, SweepOptions, _Run], _Made]


def _first_good(part: Part, sweeps: list[Sweep], options: SweepOptions, run: _Run, make: Make) -> _Made:
    """Make the first candidate that does well, or the best of those tried."""
    tried: list[_Made] = []
    failures: list[CadSweepError] = []
    for sweep in sweeps[:MOST_CANDIDATES]:
        try:
            made = make(part, sweep, options, run)
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
        raise failures[0]
    best = max(tried, key=lambda made: (made.report.valid, made.report.min_scaled_jacobian))
    best.factored.info["notes"] += [f"a better ranked sweep was given up: {error}" for error in failures]
    return best


def _make_mesh(part: Part, sweep: Sweep, options: SweepOptions, run: _Run) -> _Made:
    """Mesh by one sweep; raises unless the mesh is valid or the user allows an invalid one."""
    factored, surfaces = factor_sweep(part, sweep, options, run)
    with run.stage("assembly"):
        mesh = factored.to_mesh()
    reference = make_reference(part, sweep)
    with run.stage("quality"):
        report = check_mesh(mesh, cad=reference)
    if options.smoothing and not report.min_scaled_jacobian >= SMOOTH_BELOW:
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
                surfaces=project_to_faces(part, sweep, mesh),
                allow_inverted=options.allow_inverted,
            )
        with run.stage("quality"):
            report = check_mesh(mesh, cad=reference)
    mesh.info["quality"] = report
    if not report.valid and not options.allow_inverted:
        raise refusal(report)
    return _Made(factored=factored, report=report, mesh=mesh)


def smoothed(factored: FactoredMesh) -> FactoredMesh:
    """Mend the worst places; what was moved is kept beside the factors."""
    factored = replace(factored, sweep=corrected(factored.sweep))
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


def refusal(report: QualityReport) -> InvertedHexError:
    """Say what is wrong with a mesh that is not handed over."""
    return InvertedHexError(
        f"no valid mesh: {'; '.join(report.problems[:3])}; try another size, more layers, or another source face",
        hexes=[hexahedron.id for hexahedron in report.worst],
        min_scaled_jacobian=report.min_scaled_jacobian,
    )


def factor_sweep(
    part: Part, sweep: Sweep, options: SweepOptions, run: _Run, *, streamed: bool = False
) -> tuple[FactoredMesh, SurfaceMesh]:
    """Everything up to the factors: the whole mesh, before it is multiplied out."""
    size = None if options.size is None else options.size / part.scale
    layers = options.layers if options.fractions is None else len(options.fractions) - 1
    edge_sizes = _edge_sizes(part, sweep, options)
    with run.stage("intervals"):
        smallest = min(edge_sizes.values(), default=None)
        rough = estimate.estimate_size(
            sweep, size=size, layers=layers, smallest=smallest, scale=part.scale, streamed=streamed
        )
        if rough is not None:
            estimate.check_budget(rough, max_hexes=options.max_hexes, max_memory=options.max_memory)
        counts = intervals.assign_intervals(sweep, size=size, layers=layers, edge_sizes=edge_sizes or None)
        expected = estimate.estimate(sweep, counts, scale=part.scale, streamed=streamed)
        estimate.check_budget(expected, max_hexes=options.max_hexes, max_memory=options.max_memory)
    with run.stage("surface"):
        surfaces = surface.mesh_surfaces(sweep, counts, bias=options.bias, fractions=options.fractions)
    with run.stage("projection"):
        target = place_target(sweep, surfaces)
        if is_ring(sweep):
            surfaces.rings[-1] = surfaces.rings[0]
        placed = project_layers(
            surfaces.source.points,
            surfaces.source.quads,
            surfaces.rings,
            loops=surfaces.source.loops,
            functional=options.functional,
            strategy=options.strategy,
            target_points=target.points,
            residual=options.residual,
        )
    factored = factor_mesh(
        sweep,
        surfaces,
        placed,
        target.faces,
        periodic=is_ring(sweep),
        part=sweep.solid.name or part.name,
        scale=part.scale,
        offset=part.offset,
        info={
            "part": part.name,
            "cad_volume": sweep.solid.volume * part.scale**3,
            "sweeps": [_describe(sweep, len(surfaces.rings) - 1)],
            "names": dict(part.names),
            "notes": [*part.notes, *sweep.notes, *surfaces.notes, *target.notes],
            "seconds": run.seconds,
        },
    )
    return factored, surfaces


def _edge_sizes(part: Part, sweep: Sweep, options: SweepOptions) -> dict[int, float]:
    """Wanted sizes on the edges of named faces, working units."""
    wanted: dict[int, float] = {}
    for name, size in (options.sizes or {}).items():
        for face in cad.select_faces(part, name):
            for edge in sweep.solid.faces[face].edges:
                wanted[edge] = min(wanted.get(edge, np.inf), size / part.scale)
    return wanted


def _describe(sweep: Sweep, n_layers: int) -> dict[str, Any]:
    """What a report says of a sweep: faces by name, or by id where they have none."""
    faces = sweep.solid.faces
    return {
        "source": [faces[i].name or i for i in sweep.source],
        "target": [faces[i].name or i for i in sweep.target],
        "layers": n_layers,
    }
