"""A part of several cells: from a plan (:mod:`.complexes`) to a mesh that has passed its checks.

Cells that share nothing with others are swept by themselves, with everything that a single solid gets (rings cut
open, faces merged); those that touch are planned and meshed together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...blocks.block_mesh import BlockMesh
from ...blocks.cells import CellBlocks
from ...blocks.finish import to_hex_mesh
from ...blocks.joined import JoinedMesh
from ...blocks.naming import find_colors, name_faces
from ...brep import Part, Solid, volume_doubt
from ...corner_blocks import CornerBlocks
from ...errors import InvertedHexError
from ...estimate import estimate_counted
from ...intervals import Wishes
from ...mesh import HexMesh
from ...options import SweepOptions
from ...plan import Fill
from ...quality import QualityReport
from ...quality.thickness import single_share
from ...sweep import Intervals
from ..finished.pairs import with_pairs
from ..nearness.cells_accuracy import accurate_cells
from ..nearness.crossing_facets import FINER, MOST_ROUNDS, finer_where_crossing
from ..nearness.measured import Found, boundary_distance, check_coarse_solids
from ..nearness.nearer import COARSE, coarse
from ..origin import made_of
from ..refusing import refusal
from ..run import Run
from .cells import expected_cells
from .checking import checked_blocks, checked_cells, find_slides, kept_rows
from .complex import Complex

if TYPE_CHECKING:  # hardly any mesh needs it
    from ...smoothing import Slides

_THIN_SHARE = 0.2
"""Part of the boundary's area with one hexahedron to the other side from which on the mesh's notes say so."""

_NOTED = 0.01
"""Part of the volume that a mesh may lose or gain without a note."""

_DOUBTFUL = 1e-4
"""Part of the volume that gaps between faces may leave open without a note; what CAD kernels leave is far below."""

_MOST_OPENED = 10**6
"""Hexahedra of a mesh in blocks up to which it is opened to see how thick it is; memory is what blocks are to save."""


def mesh_complex(
    found: Complex, options: SweepOptions, run: Run, wishes: Wishes, *, slide: bool = True
) -> HexMesh | BlockMesh:
    """The mesh of :func:`mesh_judged`."""
    return mesh_judged(found, options, run, wishes, slide=slide)[0]


def mesh_judged(
    found: Complex, options: SweepOptions, run: Run, wishes: Wishes, *, slide: bool = True
) -> tuple[HexMesh | BlockMesh, float]:
    """Mesh a planned part, check every solid of it, and smooth where that is needed.

    Without `slide` nodes on faces that are no contacts stay: so poor cells are seen to be poor while others may be had.
    Besides the mesh: how many times as far it is off the CAD as it may be.

    Raises
    ------
    InvertedHexError
        The mesh is not valid, and the user does not allow that.
    SurfaceMeshError, ProjectionError
        A face or a layer cannot be meshed.
    """
    finer: list[str] = []
    rounds = 0 if options.size is not None and options.tolerance is None else MOST_ROUNDS  # a size that is named stays
    for tried in range(1 + rounds):
        made, off = accurate_cells(found.part, found.plan, options, run, wishes, found.model)
        cells, counts, notes = made
        expected = expected_cells(found.part, found.plan, wishes)
        n_quads = cells.n_hexes // expected.n_layers
        run.expects(estimate_counted(expected, n_quads, cells.n_hexes), settled=True)
        try:
            mesh = _finished(found, cells, counts, options, run, [*finer, *notes], off, slide=slide)
            break
        except InvertedHexError as error:
            divided = finer_where_crossing(found.part, cells, counts, error, wishes) if tried < rounds else None
            if divided is None:
                raise
            wishes, finer = divided, [FINER]
    mesh = replace(mesh, info={**mesh.info, "way": _way(found)})
    shortfall = 0.0 if off is None or (options.tolerance is None and options.size is not None) else off.shortfall
    mesh = mesh if isinstance(mesh, BlockMesh) else with_pairs(made_of(mesh, found.model, found.sweep))
    return mesh, shortfall


def _way(found: Complex) -> str | dict[str, str]:
    """How the solid was filled; of several by name."""
    part, filled = found.part, dict[str, str]()
    for owner, way in zip(part.owners, found.plan.ways, strict=True):
        name = part.models[owner].name
        is_one = name not in filled and not isinstance(way.fill, CornerBlocks)
        filled[name] = "sweep" if is_one else "cells"
    return filled if len(part.models) > 1 else filled[part.models[0].name]


def _finished(  # noqa: PLR0917
    found: Complex,
    cells: CellBlocks,
    counts: Sequence[Intervals],
    options: SweepOptions,
    run: Run,
    notes: list[str],
    off: Found | None,
    *,
    slide: bool,
) -> HexMesh | BlockMesh:
    """The mesh of a planned part's cells, checked."""
    part, plan = found.part, found.plan
    return finish(
        part,
        cells,
        options,
        run,
        notes=notes,
        found=off,
        slide=slide,
        sweeps=[
            _described(solid, way.fill, own) | {"cell": cell, "solid": part.models[owner].name}
            for cell, (solid, way, own, owner) in enumerate(
                zip(part.solids, plan.ways, counts, part.owners, strict=True)
            )
        ],
    )


def _described(solid: Solid, fill: Fill, counts: Intervals) -> dict[str, Any]:
    """What a mesh's record says of one cell."""
    if isinstance(fill, CornerBlocks):
        return {"source": [], "target": [], "layers": 0, "corners": len(fill.corners)}
    caps = {"source": fill.source, "target": fill.target}
    shown = {name: [solid.faces[f].shown for f in own] for name, own in caps.items()}
    return shown | {"layers": counts.n_layers, "span_layers": list(counts.span_layers[0])}


def finish(
    part: Part,
    cells: JoinedMesh | CellBlocks,
    options: SweepOptions,
    run: Run,
    *,
    notes: Sequence[str] = (),
    sweeps: Sequence[dict[str, Any]] = (),
    slides: Callable[[], Slides] | None = None,
    found: Found | None = None,
    slide: bool = True,
) -> HexMesh | BlockMesh:
    """Name, check, smooth and check again a mesh of the cells of a part; of blocks in memory, or as blocks.

    `found`: how far it is off its faces, where that is known.

    Raises
    ------
    InvertedHexError
        The mesh is not valid, and the user does not allow that.
    """
    names = name_faces(part, cells.roles)
    volume = sum(model.volume for j, model in enumerate(part.models) if j in part.owners) * part.scale**3
    info: dict[str, Any] = {
        "part": part.name,
        "material": next((m.material for m in part.models if m.material), None) if len(part.models) == 1 else None,
        "materials": {m.name: m.material for m in part.models if m.material},
        "cad_volume": volume,
        "sweeps": list(sweeps),
        "blocks": _block_sizes(cells),
        "names": dict(part.names),
        "colors": find_colors(part, names),
        "distance": boundary_distance(part, cells, names, found) * part.scale,
        "notes": [*part.notes, *notes],
        "seconds": run.seconds,
    }
    check_coarse_solids(part, cells, names, options)
    mesh: HexMesh | BlockMesh
    if isinstance(cells, CellBlocks) and run.in_blocks:
        mesh = checked_blocks(part, cells, names, options, run, info=info, slides=slides, slide=slide)
    else:
        with run.stage("assembly"):
            joined = cells.joined() if isinstance(cells, CellBlocks) else cells
        slides = slides or find_slides(part, joined, names, options, outside=slide)
        mesh = checked_cells(
            part, joined, names, options, run, make=lambda own, info: to_hex_mesh(part, own, names, info), info=info,
            kept=kept_rows(cells), slides=slides,
        )  # fmt: skip
        if isinstance(cells, CellBlocks):
            mesh = replace(mesh, origin=replace(mesh.origin, cells=cells))
    report = mesh.info["quality"]
    doubt = sum(volume_doubt(solid) for solid in part.solids) * part.scale**3
    more = _volume_notes(report.volume, volume, doubt)
    mesh = replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], *more]}) if more else mesh
    if not report.valid and not options.allow_inverted:
        error = refusal(report, part, names)
        error.solids = _at_fault(mesh, report)
        raise error
    if options.order > 1 and not (options.allow_coarse or options.allow_inverted or options.refine):
        off = report.volume / volume - 1.0
        if abs(off) > COARSE:
            raise coarse(f"its volume is {off:+.1%} off the CAD's")
    if options.refine:
        return mesh
    if isinstance(mesh, HexMesh):
        return _with_thickness(mesh, mesh)
    assert isinstance(cells, CellBlocks), "what is in blocks was made of them"
    if cells.n_hexes > _MOST_OPENED:
        return mesh
    return _with_thickness(mesh, to_hex_mesh(part, cells.joined(), names, {}))


def _volume_notes(volume: float, known: float, doubt: float) -> list[str]:
    """Say where the model leaves its volume open, and where a valid mesh is too coarse to be the part."""
    notes = []
    if doubt > _DOUBTFUL * known:
        notes.append(
            f"faces of the model miss each other, so that its volume is known to {doubt / known:.1g} of itself only; "
            "the checks allow for that"
        )
    off = volume / known - 1.0
    if abs(off) > _NOTED + doubt / known:
        notes.append(f"the volume is {off:+.1%} off the CAD's, too coarse for its curves: take a smaller size")
    return notes


def _block_sizes(cells: JoinedMesh | CellBlocks) -> list[int] | None:
    """Hexahedra of every block, where there are several."""
    sizes = [own.n_hexes for own in cells.cells] if isinstance(cells, CellBlocks) else list(cells.columns)
    return sizes if len(sizes) > 1 else None


def _with_thickness(mesh: HexMesh | BlockMesh, placed: HexMesh) -> HexMesh | BlockMesh:
    """The mesh, with a note where much of it, `placed` in memory, is one hexahedron thick."""
    share = single_share(placed.points, placed.hexes, placed.boundaries.values())
    if share <= _THIN_SHARE:
        return mesh
    note = (
        f"between {share:.0%} of the boundary there is one hexahedron from side to side: too stiff to bend, "
        "take a smaller size or more layers"
    )
    return replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], note]})


def _at_fault(mesh: HexMesh | BlockMesh, report: QualityReport) -> tuple[str, ...]:
    """The parts of a mesh that its problems are about."""
    said = [name for name in mesh.parts if any(problem.startswith(f"part '{name}'") for problem in report.problems)]
    inverted = [bad.id for bad in report.worst if bad.scaled_jacobian <= 0]
    if isinstance(mesh, BlockMesh):
        there = {mesh.part_of(number) for number in inverted}
        return tuple(said) or tuple(name for name in mesh.parts if name in there)
    return tuple(said) or tuple(name for name, ids in mesh.parts.items() if np.isin(inverted, ids).any())
