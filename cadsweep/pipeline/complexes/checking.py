"""Check a mesh of cells, smooth it where that is needed, raise its order, and check it again.

Place in the flow: :mod:`.several` has its meshes checked here, in memory or in blocks; so has what carries and refines.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arrays import IntArray
from ...blocks.block_mesh import BlockMesh
from ...blocks.cells import CellBlocks
from ...blocks.finish import by_face, to_block_mesh
from ...blocks.joined import JoinedMesh
from ...blocks.naming import NamedFaces
from ...blocks.reference import make_references
from ...brep import Part
from ...entity.entities import Entities
from ...mesh import HexMesh
from ...options import SweepOptions
from ...orders.elevate import elevate
from ...quality import CadReference, QualityReport, check_mesh
from ..candidates import SMOOTH_BELOW, PostponedError
from ..origin import CellsOrigin
from ..run import Run, measured

if TYPE_CHECKING:  # hardly any mesh needs it
    from ...smoothing import Slides, Smoothed


def checked_blocks(
    part: Part,
    cells: CellBlocks,
    names: NamedFaces,
    options: SweepOptions,
    run: Run,
    *,
    info: dict[str, Any],
    slides: Callable[[], Slides] | None = None,
    slide: bool = True,
) -> BlockMesh:
    """Check cells that stay in blocks, and smooth them where that is needed, as :func:`checked_cells` does.

    While it is smoothed the mesh is in memory: what is to be moved may be anywhere, and have any neighbours.
    """
    references = make_references(part, names)

    def checked(cells: CellBlocks) -> tuple[BlockMesh, QualityReport]:
        with run.stage("assembly"):
            mesh = to_block_mesh(part, cells, names, info)
        with run.stage("quality"):
            return mesh, measured(mesh, references, run)

    mesh, report = checked(cells)
    if _is_smoothed(report, options, run, SMOOTH_BELOW, lambda: cells.joined().hex_cells):
        joined = cells.joined()
        slides = slides or find_slides(part, joined, names, options, outside=slide)
        better = _smoothed(joined, names, run, asked=options.size is not None, kept=kept_rows(cells), slides=slides)
        info["notes"] += better.steps
        if len(better.nodes):
            mesh, report = checked(cells.moved(better.nodes, better.positions))
    return replace(mesh, info={**mesh.info, "quality": report})


def checked_cells(
    part: Part,
    joined: JoinedMesh,
    names: NamedFaces,
    options: SweepOptions,
    run: Run,
    *,
    make: Callable[[JoinedMesh, dict[str, Any]], HexMesh],
    info: dict[str, Any],
    smooth_below: float = SMOOTH_BELOW,
    goal: float | None = None,
    kept: np.ndarray | None = None,
    slides: Callable[[], Slides] | None = None,
    references: CadReference | Mapping[str, CadReference] | None = None,
) -> HexMesh:
    """Check a mesh of cells, smooth it where that is needed, raise its order and check it again.

    Parameters
    ----------
    make : callable
        Makes the mesh of `joined`, or of it with other points, with names and `info`.
    smooth_below : float
        Worst scaled Jacobian below which it is smoothed, valid or not.
    goal : float or None
        Scaled Jacobian that smoothing tries to reach; None for the usual one.
    kept : (n,) bool or None
        Nodes that smoothing must not move, besides those on the model's faces.
    slides : callable or None
        Gives the nodes on the model's faces that smoothing may move on these.
    references : optional
        What the CAD model says that the mesh must be, where that is not what its solids say by name.

    Returns
    -------
    HexMesh
        With its report as ``info["quality"]``, valid or not.
    """
    if references is None:
        references = make_references(part, names)

    def checked(joined: JoinedMesh) -> tuple[HexMesh, QualityReport]:
        with run.stage("assembly"):
            mesh = make(joined, info)
        with run.stage("quality"):
            return mesh, check_mesh(mesh, cad=references, blocks=joined.blocks)

    mesh, report = checked(joined)
    if _is_smoothed(report, options, run, smooth_below, lambda: joined.hex_cells):
        better = _smoothed(joined, names, run, asked=options.size is not None, goal=goal, kept=kept, slides=slides)
        info["notes"] += better.steps
        if len(better.nodes):
            points = joined.points.copy()
            points[better.nodes] = better.positions
            joined = joined.moved(points)
            mesh, report = checked(joined)
    origin = CellsOrigin(model=part, part=part, joined=joined, names=names, options=options)
    if options.order > 1 and (report.valid or options.allow_inverted):
        with run.stage(f"order {options.order}"):
            mesh = raised(mesh, origin.entities, options)
        with run.stage("quality"):
            report = check_mesh(mesh, cad=references)
    return replace(mesh, origin=origin, info={**mesh.info, "quality": report})


def _is_smoothed(
    report: QualityReport, options: SweepOptions, run: Run, smooth_below: float, hex_cells: Callable[[], IntArray]
) -> bool:
    """Whether a mesh is poor, and is to be smoothed.

    Raises
    ------
    PostponedError
        The run says that something else comes first.
    """
    if not (options.smoothing and (report.min_scaled_jacobian < smooth_below or report.n_inverted)):
        return False
    if run.postpones is not None and run.postpones(report, hex_cells):
        raise PostponedError("the mesh is poor, and something else is tried before it is smoothed")
    return True


def raised(mesh: HexMesh, entities: Entities, options: SweepOptions) -> HexMesh:
    """The mesh of the order asked for, its nodes on the CAD's edges and faces."""
    return elevate(
        mesh,
        order=options.order,
        nodes=options.nodes,
        curves=entities.on_curves(),
        surfaces=entities.on_surfaces(),
        allow_inverted=options.allow_inverted,
    )


def _smoothed(
    joined: JoinedMesh,
    names: NamedFaces,
    run: Run,
    *,
    asked: bool,
    goal: float | None = None,
    kept: np.ndarray | None = None,
    slides: Callable[[], Slides] | None = None,
) -> Smoothed:
    from ... import smoothing

    with run.stage("smoothing"):
        fixed = fixed_nodes(joined, names)
        # Of one sweep the heights of layers are known on its rings: graded ones stay so.
        known = joined.structure or smoothing.Blocks(joined.hexes, len(joined.points))
        return smoothing.improve(
            joined.points,
            known,
            fixed=fixed if kept is None else fixed | kept,
            goal=smoothing.GOAL if goal is None else goal,
            slides=None if slides is None else slides(),
            is_over=partial(run.ends_smoothing, asked=asked),
        )


def kept_rows(cells: JoinedMesh | CellBlocks) -> np.ndarray | None:
    """Which nodes are rows along walls."""
    if not isinstance(cells, CellBlocks):
        return None
    kept = np.zeros(cells.n_nodes, dtype=bool)
    kept[cells.kept_nodes] = True
    return kept


def find_slides(
    part: Part, joined: JoinedMesh, names: NamedFaces, options: SweepOptions, *, outside: bool
) -> Callable[[], Slides] | None:
    """What finds the nodes on faces and edges that smoothing may move; None where their places are asked for."""
    if options.wall_layers or not (outside or names.between):
        return None
    matched = bool(options.periodic)
    from ...blocks.interface_slides import find_interface_slides

    return lambda: find_interface_slides(
        part,
        joined,
        names,
        along_edges=not (options.biases or matched),
        outside=not matched,
        curved=options.tolerance is None,
    )


def fixed_nodes(joined: JoinedMesh, names: NamedFaces) -> np.ndarray:
    """Nodes (n,) on faces of the model; those on cuts alone are free."""
    fixed = np.zeros(len(joined.points), dtype=bool)
    for place, quads in by_face(joined):
        if names.of(place):
            fixed[quads] = True
    return fixed
