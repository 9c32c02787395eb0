"""A candidate sweep as a mesh: in memory, of any order, or in blocks."""

from __future__ import annotations

from dataclasses import replace

from ..blocks.block import FactoredMesh
from ..blocks.block_mesh import mesh_of_sweep
from ..blocks.reference import make_reference
from ..brep import Part
from ..entity.entities import Entities
from ..mesh import HexMesh
from ..options import SweepOptions
from ..orders.elevate import elevate
from ..quality import QualityReport, check_mesh
from ..sweep import Sweep
from .candidates import Made, checked, refuse
from .factoring import factor_sweep
from .finished.pairs import with_pairs
from .origin import Origin
from .run import Run, measured


def make_mesh(part: Part, sweep: Sweep, options: SweepOptions, run: Run, reached: float) -> Made:
    """Mesh by one sweep; raises unless the mesh is valid or the user allows an invalid one."""
    factored, surfaces, shortfall = factor_sweep(part, sweep, options, run)
    with run.stage("assembly"):
        mesh = factored.to_mesh()
    reference = make_reference(part, sweep)

    def check(present: FactoredMesh) -> QualityReport:
        if present.is_changed:
            present.points(out=mesh.points.reshape(-1, present.structure.n_nodes, 3))
        with run.stage("quality"):
            return check_mesh(mesh, cad=reference)

    factored, report = checked(factored, check, options, run, reached)
    mesh = replace(mesh, info=factored.info)
    origin = Origin(part=part, sweep=sweep, surfaces=surfaces, factored=factored, options=options)
    if options.order > 1 and (report.valid or options.allow_inverted):
        with run.stage(f"order {options.order}"):
            mesh = raised(mesh, origin.entities, options)
        with run.stage("quality"):
            report = check_mesh(mesh, cad=reference)
    refuse(report, options, part, sweep)
    mesh = replace(mesh, origin=origin, info={**mesh.info, "quality": report})
    return Made(factored=factored, report=report, mesh=with_pairs(mesh), shortfall=shortfall)


def make_blocks(part: Part, sweep: Sweep, options: SweepOptions, run: Run, reached: float) -> Made:
    """The same mesh as a block, measured as the run says; raises as :func:`make_mesh`."""
    factored, _, shortfall = factor_sweep(part, sweep, options, run, streamed=True)
    reference = make_reference(part, sweep)
    mesh = mesh_of_sweep(factored)

    def check(present: FactoredMesh) -> QualityReport:
        nonlocal mesh
        if present.is_changed:
            mesh = mesh_of_sweep(present)
        with run.stage("quality"):
            return measured(mesh, reference, run)

    factored, report = checked(factored, check, options, run, reached)
    refuse(report, options, part, sweep)
    mesh = replace(mesh, info={**factored.info, "quality": report})
    return Made(factored=factored, report=report, mesh=mesh, shortfall=shortfall)


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
