"""Our smoothing steps beside gmsh's and MFEM's, on patches of bad hexahedra cut from the same meshes.

Run ``python benchmarks/smoothers.py`` (all cases), or name some. Every patch is what :func:`cadsweep.smoothing.improve`
would work on first: the bad hexahedra and two rings of neighbours, of which only the inner nodes may move. Each
smoother runs in a process of its own and is ended after `LONGEST` seconds.

inverted   hexahedra whose Jacobian is not proven positive everywhere inside
worst      scaled Jacobian
reached    least share of what a hexahedron's fixed nodes allow it, of 0.3 at most; 1 is all that can be asked for
grading    root mean square of log(height / wanted height): 0 keeps graded layers as they are
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import queue
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import cadquery as cq
import numpy as np
import quality
from numpy.typing import NDArray

import cadsweep as cs
from cadsweep.cells import SweptStructure
from cadsweep.gmsh_session import gmsh_session
from cadsweep.quality import HEX_CORNERS
from cadsweep.smoothing import ladder
from cadsweep.smoothing.cutting import grown, hex_nodes, patches, touches_others
from cadsweep.smoothing.laplacian import relaxed
from cadsweep.smoothing.optimise import polished, untangled
from cadsweep.smoothing.patch import Patch, edge_lengths, proven_values

LONGEST = 60.0
Array = NDArray[Any]


def ours(patch: Patch) -> Array:
    """Relax, untangle, polish, each kept where it helps, as often as it helps."""
    points, score = patch.points, patch.score(patch.points)
    for _ in range(3):
        before = score
        for step in (relaxed, untangled) if score.worst <= 0 else (polished,):
            trial = step(patch, points)
            if patch.score(trial).beats(score):
                points, score = trial, patch.score(trial)
        if score.reached >= 1 or not score.beats(before):
            break
    return points


def gmsh_step(method: str) -> Callable[[Patch], Array]:
    """One of gmsh's optimisers, on a discrete volume in units of the mean edge length."""

    def step(patch: Patch) -> Array:
        unit = float(np.mean(edge_lengths(patch.points, patch.hexes)))
        with gmsh_session("patch") as gmsh:
            volume = gmsh.model.addDiscreteEntity(3)
            tags = np.arange(1, len(patch.points) + 1)
            # Fixed nodes are classified on a surface, which these optimisers leave alone.
            surface = gmsh.model.addDiscreteEntity(2)
            for dim, entity, chosen in ((2, surface, ~patch.free), (3, volume, patch.free)):
                gmsh.model.mesh.addNodes(dim, entity, tags[chosen], (patch.points[chosen] / unit).ravel())
            gmsh.model.mesh.addElementsByType(volume, 5, [], (patch.hexes + 1).ravel())
            gmsh.model.mesh.optimize(method, force=True, niter=10)
            # Nodes have other tags now; the hexahedra still come in their order.
            tags, xyz, _ = gmsh.model.mesh.getNodes()
            _, corners = gmsh.model.mesh.getElementsByType(5)
            places = np.empty((int(np.max(tags)) + 1, 3))
            places[np.asarray(tags, dtype=np.int64)] = np.reshape(xyz, (-1, 3)) * unit
            points = patch.points.copy()
            points[patch.hexes] = places[np.asarray(corners, dtype=np.int64).reshape(-1, 8)]
        points[~patch.free] = patch.points[~patch.free]
        return points

    return step


def tmop(patch: Patch) -> Array:  # noqa: PLR0915
    """MFEM's TMOP: metric 360 until nothing is inverted, then 303 for the hexahedra's given sizes."""
    import mfem.ser as mfem
    from mfem._ser import tmop as metrics
    from mfem._ser import tmop_tools

    unit, centre = float(np.mean(edge_lengths(patch.points, patch.hexes))), patch.points.mean(axis=0)
    start = (patch.points - centre) / unit
    mesh = mfem.Mesh(3, len(start), len(patch.hexes), 0, 3)
    for x, y, z in start.tolist():
        mesh.AddVertex(x, y, z)
    for row in patch.hexes.tolist():
        mesh.AddHex(row)
    mesh.FinalizeHexMesh(0, 0, False)
    collection = mfem.H1_FECollection(1, 3)
    space = mfem.FiniteElementSpace(mesh, collection, 3)
    mesh.SetNodalFESpace(space)
    nodes = mfem.GridFunction(space)
    mesh.SetNodalGridFunction(nodes)
    n = len(start)
    held = mfem.intArray([k * n + int(i) for k in range(3) for i in np.flatnonzero(~patch.free)])
    rules = mfem.IntegrationRules(0, mfem.Quadrature1D.GaussLobatto)
    rule = rules.Get(space.GetFE(0).GetGeomType(), 4)

    def places() -> Array:
        return np.array(nodes.GetDataArray()).reshape(3, -1).T

    def lowest() -> float:
        x = places()
        corners = (np.stack([x[patch.hexes[:, e]] - x[patch.hexes[:, o]] for e in ends], 1) for o, *ends in HEX_CORNERS)
        return min(float(np.min(np.linalg.det(J))) for J in corners)

    def solve(metric: Any, target: Any, least: Any) -> None:
        given = mfem.GridFunction(nodes)
        constructor = metrics.TargetConstructor(target)
        constructor.SetNodes(given)
        integrator = metrics.TMOP_Integrator(metric, constructor)
        integrator.SetIntegrationRules(rules, 4)
        form = mfem.NonlinearForm(space)
        form.AddDomainIntegrator(integrator)
        integrator.thisown = 0  # the form deletes it
        form.SetEssentialVDofs(held)
        solver = tmop_tools.TMOPNewtonSolver(rule, 1)  # L-BFGS: Newton takes minutes on 3,000 hexahedra
        solver.SetIntegrationRules(rules, 4)
        if least is not None:
            solver.SetMinDetPtr(least)
        solver.SetMaxIter(100)
        solver.SetRelTol(1e-6)
        solver.SetPrintLevel(-1)
        solver.SetOperator(form)
        nodes.SetTrueVector()
        solver.Mult(mfem.Vector(0), nodes.GetTrueVector())
        nodes.SetFromTrueVector()

    target = metrics.TargetConstructor
    least = mfem.Vector(1)
    for _ in range(6):
        if lowest() > 0:
            break
        least[0] = 1.1 * lowest() - 1e-3
        solve(metrics.TMOP_Metric_360(), target.IDEAL_SHAPE_UNIT_SIZE, least.GetData())
    best = places() * unit + centre
    best[~patch.free] = patch.points[~patch.free]
    if lowest() > 0:
        solve(metrics.TMOP_Metric_303(), target.IDEAL_SHAPE_GIVEN_SIZE, None)
        last = places() * unit + centre
        last[~patch.free] = patch.points[~patch.free]
        best = max(best, last, key=lambda x: patch.score(x).reached)
    return best


def ours_then_tmop(patch: Patch) -> Array:
    """TMOP as a last rung."""
    points = ours(patch)
    after = tmop(replace(patch, points=points))
    return after if patch.score(after).beats(patch.score(points)) else points


SMOOTHERS: dict[str, Callable[[Patch], Array]] = {
    "ours": ours,
    "Relocate3D": gmsh_step("Relocate3D"),
    "Untangle": gmsh_step("UntangleMeshGeometry"),
    "TMOP": tmop,
    "ours, TMOP": ours_then_tmop,
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Swept:
    """A mesh that has not been smoothed."""

    points: Array
    structure: SweptStructure
    fixed: Array


def swept(solid: Any, **options: Any) -> Swept:
    """Mesh without smoothing."""
    mesh = cs.sweep_mesh(solid, smoothing=False, allow_inverted=True, **options)
    structure = mesh.structure
    assert structure is not None
    fixed = np.zeros(mesh.n_nodes, dtype=bool)
    for quads in mesh.boundaries.values():
        fixed[quads] = True
    return Swept(points=mesh.points, structure=structure, fixed=fixed)


def disturbed(given: Swept, amount: float) -> Swept:
    """Displace the inner nodes at random."""
    points = given.points.copy()
    inner = ~given.fixed
    points[inner] += np.random.default_rng(0).normal(size=(np.count_nonzero(inner), 3)) * amount
    return replace(given, points=points)


def domed_block(rise: float) -> cq.Solid:
    """A block of 2 x 2 x 1 with a dome on its top, inward where the rise is negative."""
    block = cq.Workplane("XY").rect(2, 2).extrude(1.0).val()
    top = max(block.Faces(), key=lambda f: f.Center().z)
    kept = [f for f in block.Faces() if f.hashCode() != top.hashCode()]
    cap = quality.domed(top.outerWire(), top.Center() + top.normalAt() * rise)
    return cq.Solid.makeSolid(cq.Shell.makeShell([*kept, cap]))


def angle(first: float, last: float, length: float) -> cq.Solid:
    """An angle 1 thick whose arms grow."""

    def section(arm: float, z: float) -> cq.Wire:
        return quality.polygon([(0, 0), (arm, 0), (arm, 1), (1, 1), (1, arm), (0, arm)], z)

    return quality.loft(section(first, 0), section(last, length))


def flat_loft(offset: float, length: float, *, round_end: bool) -> cq.Solid:
    """From a flat rectangle to an upright rectangle or ellipse."""
    base = cq.Workplane().rect(3, 0.4).workplane(offset=length).center(offset, offset / 2)
    return (base.ellipse(0.2, 1.5) if round_end else base.rect(0.4, 3)).loft(combine=True).val()


def star(turn: float, scale: float, length: float) -> cq.Solid:
    """A star of five sharp tips that turns and shrinks."""

    def section(size: float, angle_: float, z: float) -> cq.Wire:
        radii = [2.0, 0.7] * 5
        angles = [math.pi * k / 5 + math.radians(angle_) for k in range(10)]
        return quality.polygon(
            [(size * r * math.cos(a), size * r * math.sin(a)) for r, a in zip(radii, angles, strict=True)], z
        )

    return quality.loft(section(1, 0, 0), section(scale, turn, length))


def bar(length: float, turn: float) -> cq.Solid:
    """A bar of 2 x 1, twisted."""
    return cq.Workplane().rect(2, 1).twistExtrude(length, turn).val()


def rounded_disc() -> cq.Solid:
    """A disc whose upper edge is rounded."""
    return cq.Workplane().circle(2).extrude(2).faces(">Z").edges().fillet(0.5).val()


CASES: dict[str, Callable[[], Swept]] = {
    "dome into a block": lambda: swept(domed_block(-0.8), size=0.2),
    "dome into a block, graded": lambda: swept(domed_block(-0.8), size=0.2, layers=10, bias=6.0),
    "angle, arm 1.3 to 9": lambda: swept(angle(1.3, 9, 6), size=0.25, layers=20),
    "angle, arm 1.5 to 6, graded": lambda: swept(angle(1.5, 6, 4), size=0.25, layers=16, bias=8.0),
    "bar, twisted by 90 in 0.5": lambda: swept(bar(0.5, 90), size=0.2, layers=6),
    "bar, twisted by 150 in 1": lambda: swept(bar(1, 150), size=0.2, layers=6),
    "flat to upright": lambda: swept(flat_loft(0, 1, round_end=True), size=0.15),
    "flat to upright, skewed": lambda: swept(flat_loft(-2, 1.5, round_end=False), size=0.15),
    "taper outward by 50": lambda: swept(cq.Workplane().rect(1, 1).extrude(2, taper=-50).val(), size=0.2),
    "all edges rounded": lambda: swept(cq.Workplane().box(4, 4, 2).edges().fillet(0.4).val(), size=0.15),
    "cap edge rounded": lambda: swept(rounded_disc(), size=0.3),
    "star that turns by 80": lambda: swept(star(80, 0.4, 1), size=0.2, layers=8),
    "box, disturbed": lambda: disturbed(swept(cq.Workplane().box(2, 2, 2).val(), size=0.15), 0.12),
    "box, graded, disturbed": lambda: disturbed(
        swept(cq.Workplane().box(2, 2, 2).val(), size=0.15, layers=12, bias=12.0), 0.06
    ),
    "bend, disturbed": lambda: disturbed(swept(quality.bend_with_domes(), size=0.2, layers=20), 0.1),
}


def cut(mesh: Swept, most: int = 3) -> Iterator[tuple[Patch, int]]:
    """The largest patches of bad hexahedra, and how many there are."""
    values = ladder.hex_values(mesh.points, mesh.structure)
    bad = ladder._below_goal(mesh.points, mesh.structure, values, mesh.fixed, ladder.GOAL)
    pieces = sorted(patches(grown(bad, mesh.structure, 2), mesh.structure), key=len, reverse=True)
    for hexes in pieces[:most]:
        nodes, local = np.unique(hex_nodes(mesh.structure, hexes), return_inverse=True)
        local = local.reshape(-1, 8)
        start = mesh.points[nodes]
        yield (
            Patch(
                points=start,
                hexes=local,
                free=~mesh.fixed[nodes] & ~touches_others(mesh.structure, hexes, nodes),
                lengths=ladder._wanted_lengths(mesh.points, mesh.structure, hexes, start[local]),
                goals=ladder._goals(start, local, mesh.fixed[nodes], ladder.GOAL),
            ),
            len(pieces),
        )


def _work(name: str, patch: Patch, answer: Any) -> None:
    SMOOTHERS[name](replace(patch, points=patch.points + 0.0)) if name == "ours" else None  # compile first
    start = time.perf_counter()
    try:
        points = SMOOTHERS[name](patch)
    except Exception as error:
        answer.put((None, str(error).strip().splitlines()[0][:60]))
        return
    answer.put((points, time.perf_counter() - start))


def run(name: str, patch: Patch) -> tuple[Array | None, Any]:
    """Points and seconds, or None and why not."""
    context = multiprocessing.get_context("fork")
    answer = context.Queue()
    worker = context.Process(target=_work, args=(name, patch, answer))
    worker.start()
    try:
        return answer.get(timeout=LONGEST)
    except queue.Empty:
        return None, "not finished" if worker.is_alive() else "crashed"
    finally:
        worker.kill()
        worker.join()


def figures(patch: Patch, points: Array) -> str:
    """What came out, in one line."""
    values = proven_values(points, patch.hexes)
    heights = edge_lengths(points, patch.hexes)[:, 2] / patch.lengths[:, 2]
    grading = float(np.sqrt(np.mean(np.log(np.maximum(heights, 1e-9)) ** 2)))
    return f"{np.count_nonzero(values <= 0):9}{values.min():8.3f}{patch.score(points).reached:9.2f}{grading:9.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help="parts of the names of cases; all where none is given")
    chosen = parser.parse_args()
    print(f"{'case':28}{'hexes':>7} {'smoother':12}{'inverted':>9}{'worst':>8}{'reached':>9}{'grading':>9}{'s':>8}")
    for name, build in CASES.items():
        if chosen.cases and not any(part in name for part in chosen.cases):
            continue
        for patch, _ in cut(build(), 1):
            print(f"{name:28}{len(patch.hexes):7} {'-':12}{figures(patch, patch.points)}", flush=True)
            for smoother in SMOOTHERS:
                points, seconds = run(smoother, patch)
                if points is None:
                    print(f"{'':36}{smoother:12} {seconds}", flush=True)
                else:
                    print(f"{'':36}{smoother:12}{figures(patch, points)}{seconds:8.1f}", flush=True)


if __name__ == "__main__":
    main()
