"""What users call: a part goes in, a checked mesh comes out, in memory, in a file, or as factors."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

from ..blocks.block import FactoredMesh
from ..blocks.files import load_factors, save_factors
from ..blocks.reference import make_reference
from ..blocks.stream import check_boundary, make_slab_report, write_slabs
from ..brep import Part
from ..errors import InputError
from ..io.atomic import check_place, replaced_file
from ..mesh import HexMesh
from ..options import SweepOptions
from ..quality import CadReference, QualityReport, check_mesh
from ..sweep import Sweep
from .factoring import factor_sweep
from .making import Made, figures, first_good, make_mesh, may_gain, smoothed
from .parts import find_candidates
from .refinement import refined
from .refusing import refusal
from .routes import mesh_part
from .run import Progress, Run, silent


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
        One solid, or several: those that touch are meshed conformally, unless the option ``part`` chooses one.
    isolated : bool
        Work in a child process: a crash, a hang or too much memory there is a ``WorkerError`` here.
    timeout : float or None
        Wall time of the child process, seconds.
    on_progress : callable or None
        Called with the stage and the done fraction of it.
    **options
        The fields of :class:`cadsweep.options.SweepOptions`: ``size``, ``tolerance``, ``layers``, ``bias``,
        ``fractions``, ``functional``, ``strategy``, ``residual``, ``smoothing``, ``source``, ``target``,
        ``sizes``, ``counts``, ``rail_layers``, ``params``, ``part``, ``order``, ``nodes``, ``allow_inverted``,
        ``allow_coarse``, ``max_hexes``, ``max_memory``, ``refine``.

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
        from ..cad.read.handover import make_portable
        from ..isolation import run_isolated

        result: HexMesh = run_isolated(
            "cadsweep.pipeline:sweep_mesh",
            (make_portable(source),),
            options,
            timeout=timeout,
            max_memory=chosen.max_memory,
            on_progress=on_progress,
        )
        return result
    if timeout is not None:
        raise InputError("timeout goes with isolated=True: work in this process cannot be stopped")
    run = Run(on_progress=on_progress or silent)
    return refined(mesh_part(source, chosen, run), chosen, run)


def make_options(options: dict[str, Any]) -> SweepOptions:
    """Check keyword options; an unknown one is an error that lists those there are."""
    known = SweepOptions.__dataclass_fields__
    for name in options:
        if name not in known:
            raise InputError(f"there is no option '{name}'; there are {', '.join(known)}")
    return SweepOptions(**options)


def _not_refined(options: SweepOptions, what: str) -> None:
    if options.refine:
        raise InputError(f"{what} from one sweep, without refine: ask for a smaller size and more layers")


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
    _not_refined(chosen, "factors are written")
    run = Run(on_progress=on_progress or silent)
    part, sweeps = find_candidates(source, chosen, run)
    made = first_good(part, sweeps, chosen, run, make_mesh)
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
    _not_refined(chosen, "a mesh is streamed")
    if Path(path).suffix != ".vtkhdf":
        raise InputError(f"{path}: a mesh is streamed to a .vtkhdf file")
    place = check_place(Path(path))
    run = Run(on_progress=on_progress or silent)
    part, sweeps = find_candidates(source, chosen, run)

    def make(part: Part, sweep: Sweep, options: SweepOptions, run: Run, reached: float) -> Made:
        factored, _ = factor_sweep(part, sweep, options, run, streamed=True)
        reference = make_reference(part, sweep)
        with replaced_file(place) as stream:
            with run.stage("write"):
                report = _write_checked(stream, factored, reference, run)
            if options.smoothing and may_gain(report, options, reached):
                with run.stage("smoothing"):
                    factored = smoothed(factored)
                if factored.is_changed:
                    stream.seek(0)
                    stream.truncate()
                    with run.stage("write"):
                        report = _write_checked(stream, factored, reference, run)
            if not report.valid and not options.allow_inverted:
                raise refusal(report, part, sweep)
        return Made(factored=factored, report=report)

    made = first_good(part, sweeps, chosen, run, make)
    return figures(made.factored, made.report)


def _write_checked(stream: BinaryIO, factored: FactoredMesh, reference: CadReference, run: Run) -> QualityReport:
    seen = write_slabs(stream, factored, on_slab=lambda fraction: run.on_progress("write", fraction))
    return make_slab_report(factored, seen, check_boundary(factored, reference))
