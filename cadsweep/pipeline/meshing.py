"""What users call: a part goes in, a checked mesh comes out, in memory, in a file, or as factors."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from ..blocks.block_mesh import BlockMesh
from ..errors import InputError, did_you_mean
from ..io.atomic import check_place, replaced_file
from ..mesh import HexMesh
from ..options import SweepOptions
from ..progress import Progress
from ..quality import QualityAccumulator, check_mesh
from .routes import LEAVING_OUT, mesh_in_blocks, mesh_in_memory
from .run import make_run


def sweep_mesh(
    source: Any,
    /,
    *,
    like: Any = None,
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
    like : HexMesh or path, optional
        A mesh from here, or a ``.sweep.npz`` file, of a part whose faces and edges correspond (the same script with
        other parameters): the mesh gets the same hexes, names and numbering, and nodes that move smoothly with the
        part. Sizes and counts are that mesh's.
    isolated : bool
        Work in a child process: a crash, a hang or too much memory there is a ``WorkerError`` here.
    timeout : float or None
        Wall time of the child process, seconds.
    on_progress : callable or None
        Called with the stage and the done fraction of it.
    **options
        The fields of :class:`cadsweep.options.SweepOptions`: ``size``, ``tolerance``, ``layers``, ``bias``,
        ``fractions``, ``functional``, ``strategy``, ``residual``, ``smoothing``, ``source``, ``target``,
        ``sizes``, ``counts``, ``rail_layers``, ``biases``, ``wall_layers``, ``periodic``, ``local_sizes``, ``names``,
        ``params``,
        ``part``, ``order``, ``nodes``, ``allow_inverted``, ``allow_coarse``, ``max_hexes``, ``max_memory``, ``refine``.

    Returns
    -------
    HexMesh
        Valid: every check of :func:`cadsweep.quality.check_mesh` has passed, and
        ``mesh.info["quality"]`` holds its report.

    Raises
    ------
    InputError, CadError, NotSweepableError, SurfaceMeshError, ProjectionError, InvertedHexError, WorkerError
        All of them ``CadSweepError``; no mesh is better than a wrong one.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> mesh = cs.sweep_mesh(box, size=1.0, layers=2)
    >>> mesh.n_hexes, mesh.quality().valid
    (24, True)
    >>> pipe = cs.sweep_mesh("models/elbow.step", size=4.0, rail_layers={"span 2": 8})
    >>> pipe.record.sweeps[0]["span_layers"][1]
    8
    >>> sorted(pipe.boundaries)
    ['bore', 'inlet', 'outlet', 'wall']
    """
    chosen = make_options(options)
    if like is not None:
        from .finished.like import as_template, mesh_like

        like = as_template(like)
    if isolated:
        from ..cad.read.handover import make_portable
        from ..isolation import run_isolated

        result: HexMesh = run_isolated(
            "cadsweep.pipeline:sweep_mesh",
            (make_portable(source),),
            {**options, "like": like},
            timeout=timeout,
            max_memory=chosen.max_memory,
            on_progress=on_progress,
        )
        return result
    if timeout is not None:
        raise InputError("timeout goes with isolated=True: work in this process cannot be stopped")
    run = make_run(on_progress, chosen.decompose_time)
    if like is not None:
        return mesh_like(source, like, chosen, run)
    mesh = mesh_in_memory(source, chosen, run)
    if chosen.refine:
        from .finished.refinement import refined

        mesh = refined(mesh, chosen, run)
    return mesh


def make_options(options: dict[str, Any]) -> SweepOptions:
    """Check keyword options; an unknown one is an error that lists those there are."""
    known = SweepOptions.__dataclass_fields__
    for name in options:
        if name not in known:
            raise InputError(
                f"there is no option '{name}'{did_you_mean(name, known)}", try_=f"one of {', '.join(known)}"
            )
    chosen = SweepOptions(**options)
    if chosen.without:
        from .tables import check_rows  # of tables that most parts do not need

        check_rows(chosen.without)
    return chosen


def _not_refined(options: SweepOptions, what: str) -> None:
    if options.refine:
        raise InputError(f"{what} from one sweep, without refine: ask for a smaller size and more layers")


def write_factors(
    source: Any, path: str | PathLike[str], /, *, on_progress: Progress | None = None, **options: Any
) -> HexMesh:
    """Mesh a part as :func:`sweep_mesh` does, and keep its factors: megabytes for any number of layers.

    What is neither one sweep nor blocks of such is kept as its arrays; of every kind others can be made like it.

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

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> from cadsweep.pipeline import write_factors
    >>> write_factors(box, "box.sweep.npz", size=1.0, layers=2).n_hexes
    24
    """
    chosen = make_options(options)
    if chosen.order != 1:
        raise InputError("factors are those of a mesh of order 1; raise the order when they are expanded")
    _not_refined(chosen, "factors are written")
    from .finished.template_files import save_template

    run = make_run(on_progress, chosen.decompose_time)
    place = check_place(Path(path))
    # Another part is to have this mesh.
    mesh = mesh_in_memory(source, replace(chosen, without=(*chosen.without, *LEAVING_OUT)), run)
    with replaced_file(place) as stream:
        save_template(mesh, stream)
    return mesh


def expand(path: str | PathLike[str]) -> HexMesh:
    """Multiply a file of factors out to its mesh; needs neither CAD nor gmsh.

    Raises
    ------
    InputError
        The file is missing, damaged, or something else.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> from cadsweep.pipeline import expand, write_factors
    >>> mesh = write_factors(box, "box.sweep.npz", size=1.0)
    >>> bool((expand("box.sweep.npz").points == mesh.points).all())
    True
    """
    from .finished.template_files import load_mesh

    mesh = load_mesh(path)
    return replace(mesh, info={**mesh.info, "quality": check_mesh(mesh)})


def stream_mesh(
    source: Any, path: str | PathLike[str], /, *, on_progress: Progress | None = None, **options: Any
) -> dict[str, Any]:
    """Mesh a part into a ``.vtkhdf`` file slab by slab, with flat memory, however large the mesh is.

    The file holds the mesh that :func:`sweep_mesh` makes, bit for bit, of one solid or of several. Every check is made
    on the way; the file appears only when the mesh is valid. What several sweeps share is in memory: faces between
    cells, and the surface. A mesh that needs smoothing is in memory at once while it is mended (of one sweep its nodes
    alone); so is one of columns between caps that lean, or whose outlines were laid together.

    Parameters
    ----------
    source, **options
        As for :func:`sweep_mesh`, of order 1.
    path : path

    Returns
    -------
    dict
        The figures that ``cadsweep mesh --json`` prints.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> figures = cs.stream_mesh(box, "box.vtkhdf", size=1.0, layers=2)
    >>> figures["n_hexes"], figures["valid"]
    (24, True)
    """
    chosen = make_options(options)
    if chosen.order != 1:
        raise InputError("a streamed mesh has order 1")
    _not_refined(chosen, "a mesh is streamed")
    if Path(path).suffix != ".vtkhdf":
        raise InputError(f"{path}: a mesh is streamed to a .vtkhdf file")
    from ..blocks.stream import write_slabs

    place = check_place(Path(path))
    with replaced_file(place) as stream:
        written: BlockMesh | None = None

        def write(mesh: BlockMesh) -> QualityAccumulator:
            nonlocal written
            stream.seek(0)
            stream.truncate()
            written = mesh
            with run.stage("write"):
                return write_slabs(stream, mesh, on_slab=lambda fraction: run.on_progress("write", fraction))

        run = make_run(on_progress, chosen.decompose_time, measure=write)
        mesh = mesh_in_blocks(source, chosen, run)
        if written is None or not mesh.is_same(written):
            write(mesh)  # another candidate was written last, or nothing under these names
    return figures(mesh)


def figures(mesh: BlockMesh) -> dict[str, Any]:
    """What is said of a mesh that is not in memory: the figures of ``cadsweep mesh --json``."""
    info, report = mesh.info, mesh.info["quality"]
    return {
        "way": info.get("way"),
        "n_nodes": report.n_nodes,
        "n_hexes": report.n_hexes,
        "min_scaled_jacobian": report.min_scaled_jacobian,
        "mean_scaled_jacobian": report.mean_scaled_jacobian,
        "n_inverted": report.n_inverted,
        "valid": report.valid,
        "boundaries": {name: len(own.quads) for name, own in mesh.boundaries.items()},
        "interfaces": {name: len(own.quads) for name, own in mesh.interfaces.items()},
        "parts": mesh.part_sizes(),
        "volume": report.volume,
        "cad_volume": info.get("cad_volume"),
        "distance": info.get("distance"),
        "seconds": info.get("seconds", {}),
        "sweeps": info.get("sweeps", []),
        "material": info.get("material"),
        "notes": info.get("notes", []),
    }
