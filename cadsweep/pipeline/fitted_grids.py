"""A solid filled by a fitted grid, where no sweep, columns or cuts are to be had.

Place in the flow: the last row of the ways of :mod:`.routes`. Grids are tried from coarse to fine until the model's
topology is found on one, its mesh is valid and good enough, and it passes every check that other meshes pass. Where
there is none, those come that have it with the fewest edges let go.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from .. import cad, rows
from ..arrays import FloatArray
from ..blocks.interface_slides import InterfaceSlides, find_interface_slides
from ..blocks.joined import JoinedMesh
from ..blocks.naming import name_faces
from ..brep import Part, Solid
from ..errors import CoarseMeshError, InputError, InvertedHexError, NotSweepableError, SurfaceMeshError
from ..fitted import (
    Facets,
    Found,
    Grid,
    Labelled,
    Tip,
    United,
    choose_axes,
    choose_planes,
    end_before,
    farthest,
    find_on_grid,
    find_tips,
    keep_inside,
    label_on_grid,
    lay_sheets,
    place_on_model,
    unite,
)
from ..mesh import HexMesh
from ..options import SweepOptions
from ..smoothing.untangle import guards_outside, untangle
from .complexes.several import finish
from .judging import is_limited
from .origin import made_of, worst_of
from .run import Run, spent
from .wishes.grid_sizes import sizes_at_places

log = logging.getLogger(__name__)

Made = TypeVar("Made")

MENDING = "fitted: labels mended"
"""The row of grids on which the model is found once a few labels of their skin are changed."""
LETTING = "fitted: edges let go"
"""The row of grids on which the model is found without some of its edges."""
ENDING = "fitted: faces ended before tips"
"""The row of faces that end where two of their edges are apart enough for a quad."""
LEAST = 0.1
"""Worst scaled Jacobian that a fitted grid must have: what is poorer than that is of little use."""
_GOAL = 0.25
"""What untangling tries to reach, and another grid is tried for where there is time."""
_GUARD = 0.25
"""Height of the hexahedra outside over the size: little, so that they fit into a bore of one cell."""
_FINER = (1.0, 0.75, 0.55, 0.4, 0.3)
"""Sizes that are tried, over the first."""
_LAST = 60.0
"""Seconds, of the processor, after which a grid is given up where it is to end soon; none is begun after half of them.
"""
_HOPELESS = 0.02
"""Share of the hexahedra inverted still after the first round from which the time is better spent on other grids."""
_CELLS = 2500
"""Hexahedra about as many of which the first grid has where no size is asked for."""
_MOST = 45_000
"""Hexahedra beyond which a grid comes last of all where it is to end soon."""
_LARGEST = 120_000
"""Hexahedra beyond which no even grid is tried at all then."""
_SENSELESS = (
    *("layers", "bias", "fractions", "source", "target", "rail_layers", "wall_layers", "periodic"),
    *("counts", "biases"),
)
"""Options that speak of what a fitted grid has not: layers, caps, faces that answer each other, edges with counts."""


class _Clock(NamedTuple):
    """When grids were begun, and the seconds after which one is given up; `hurried`: where they are to end soon."""

    began: float
    last: float
    hurried: bool

    def is_half(self) -> bool:
        """Whether no finer grid is begun."""
        return spent() - self.began > 0.5 * self.last

    def is_over(self) -> bool:
        return spent() - self.began > self.last

    def is_late(self) -> bool:
        """Whether one is given up."""
        return self.hurried and self.is_over()


def asked_in_vain(options: SweepOptions) -> list[str]:
    """Options that are given, and that a fitted grid cannot do."""
    return [name for name in _SENSELESS if getattr(options, name) is not None]


def mesh_fitted(part: Part, options: SweepOptions, run: Run, why: str, *, least: float | None = None) -> HexMesh:
    """Mesh a part of one solid by a fitted grid; `why` goes into its notes.

    Where there is another mesh, `least` is the worst scaled Jacobian from which on this one is better. Then, and
    without a size, it is to end soon; with the run, where there is another.

    Raises
    ------
    InputError
        An option that makes no sense of a fitted grid.
    NotSweepableError
        No grid has the topology of the model, or none gives a good mesh; says of the finest what was wrong.
    """
    unknown = asked_in_vain(options)
    if unknown:
        raise InputError(f"fitted=True goes without {unknown[0]}: it has a size, and no layers or caps")
    ending = rows.is_on(ENDING) and options.tolerance is None
    last = _LAST if least is None else min(_LAST, run.left())
    clock = _Clock(spent(), last, hurried=least is not None or options.size is None)
    problem = "it would have too many hexahedra"

    def tell(found_wrong: str, size: float) -> None:
        nonlocal problem
        problem = found_wrong
        log.info("fitted grid of size %g: %s", size * part.scale, problem)

    best: HexMesh | None = None
    reached, shares = LEAST if least is None else least, list[str]()
    for found in _found(part, options, run, clock, tell):
        if clock.is_late() or (best is not None and (found.creases or clock.is_half())):
            break
        tips = find_tips(found.united.solid, found.united.angles, found.size) if ending else []
        whole = replace(part, solids=(end_before(found.united.solid, tips),))
        try:
            with run.stage("fitted grid"):
                joined, slides = _fitted(whole, found, tips, run, clock.is_late)
            told = [*_bridges(part.solids[0], found), *_let_go(found, joined, part.scale)]
            notes = [_note(why), *told, *_ended(part, found, tips)]
            mesh = finish(whole, joined, options, run, notes=notes, slides=lambda slides=slides: slides)  # type: ignore[misc]
        except (SurfaceMeshError, InvertedHexError, CoarseMeshError) as error:
            tell(error.what, found.size)
            continue
        assert isinstance(mesh, HexMesh), "it has no factors"
        worst = worst_of(mesh)
        if worst < reached:
            tell(f"its worst scaled Jacobian is {worst:.2f}", found.size)
        elif options.tolerance is not None and mesh.info["distance"] > options.tolerance:
            tell(f"it is {mesh.info['distance']:.3g} off the faces", found.size)
        else:
            best, reached = mesh, worst
            shared = {MENDING: found.is_mended, LETTING: bool(found.creases), ENDING: bool(tips)}
            shares = [row for row, had in shared.items() if had]
            if worst >= _GOAL or found.creases or not clock.hurried or is_limited(mesh, part.solids[0]):
                break
    if best is None:
        raise NotSweepableError(f"no fitted grid fits the solid: {problem}")
    rows.took(shares)
    return made_of(best, part)


def _found(
    part: Part, options: SweepOptions, run: Run, clock: _Clock, tell: Callable[[str, float], None]
) -> Iterator[Found]:
    """The model on grids: with all its edges, then without some, then on what has very many hexahedra unasked."""
    model = part.solids[0]
    facets = _facets(model)
    axes = choose_axes(facets)
    letting = rows.is_on(LETTING) and options.tolerance is None
    mending = rows.is_on(MENDING)
    misfits: list[Labelled] = []
    large: list[tuple[float, United, Grid]] = []

    def made(size: float, make: Callable[[], Made]) -> Made | None:
        try:
            with run.stage("fitted grid"):
                return make()
        except SurfaceMeshError as error:
            tell(error.what, size)
            return None

    def in_time() -> None:
        if clock.is_late():
            raise SurfaceMeshError("there is no time left to find the model on it")

    def on(size: float, united: United, grid: Grid) -> Iterator[Found]:
        labelled = made(size, lambda: label_on_grid(united, facets, grid, size, on_step=in_time))
        if labelled is None:
            return
        found = made(size, lambda: find_on_grid(model, facets, labelled, mending=mending, on_step=in_time))
        if found is None:
            misfits.append(labelled)
        else:
            yield found

    sizes = _sizes(part, options, hurried=clock.hurried)
    for waiting in _grids(model, sizes, facets, axes, tell, partial(sizes_at_places, part, facets, options)):
        if clock.is_half():
            break
        if clock.hurried and len(waiting[2].hexes) > _MOST:
            large.append(waiting)
        else:
            yield from on(*waiting)
    with_fewer: list[Found] = []
    for misfit in misfits if letting else ():
        # What is found later than that is too late to be filled.
        if clock.is_half() if with_fewer else clock.is_late():
            break
        found = made(misfit.size, partial(find_on_grid, model, facets, misfit, letting=True, on_step=in_time))
        with_fewer += [] if found is None else [found]
    yield from sorted(with_fewer, key=lambda found: found.lost)
    for waiting in sorted(large, key=lambda waiting: len(waiting[2].hexes)):
        if clock.is_over():
            break
        yield from on(*waiting)


def _note(why: str) -> str:
    return f"filled by a fitted grid, good for stiffness and not for layers along walls, because {why}"


def _grids(  # noqa: PLR0917
    model: Solid,
    sizes: Iterable[float],
    facets: Facets,
    axes: FloatArray,
    tell: Callable[[str, float], None],
    finer: Callable[[float], tuple[FloatArray, FloatArray]],
) -> Iterator[tuple[float, United, Grid]]:
    """Sizes, faces united for them, and grids, few hexahedra first: even ones, and closer where the part is narrow.

    `finer`: where less than a size is asked for, and how much.
    """
    waiting: list[tuple[float, Grid]] = []

    def until(n_most: float) -> Iterator[tuple[float, United, Grid]]:
        waiting.sort(key=lambda one: len(one[1].hexes))
        while waiting and len(waiting[0][1].hexes) <= n_most:
            size, grid = waiting.pop(0)
            united = unite(model, facets, axes, size, ridges=True)
            yield size, united, grid
            without = unite(model, facets, axes, size, ridges=False)
            if not np.array_equal(united.of_face, without.of_face):
                yield size, without, grid

    for size in sizes:
        yield from until(model.volume / size**3)
        asked = finer(size)
        even = choose_planes(model, facets, axes, size, finer=asked)
        narrow = choose_planes(model, facets, axes, size, narrow=True, finer=asked)
        closer = [narrow] if list(map(len, narrow)) != list(map(len, even)) else []
        for planes in (even, *closer):
            try:
                waiting.append((size, keep_inside(planes, facets, axes)))
            except SurfaceMeshError as error:
                tell(error.what, size)
    yield from until(np.inf)


def _sizes(part: Part, options: SweepOptions, *, hurried: bool) -> Iterator[float]:
    solid = part.solids[0]
    first = (solid.volume / _CELLS) ** (1.0 / 3.0) if options.size is None else options.size / part.scale
    for share in _FINER:
        if hurried and solid.volume / (first * share) ** 3 > _LARGEST:
            return
        yield first * share


def _facets(solid: Solid) -> Facets:
    points, triangles, faces, n = [], [], [], 0
    for face, (own, corners) in enumerate(cad.find_facets(solid)):
        points.append(own)
        triangles.append(corners + n)
        faces.append(np.full(len(corners), face, dtype=np.int64))
        n += len(own)
    return Facets(np.concatenate(points), np.concatenate(triangles), np.concatenate(faces))


def _bridges(model: Solid, found: Found) -> list[str]:
    """What of the model the mesh has no lines for, being narrow."""
    faces = [model.faces[face].label() for face in found.united.bridged]
    return [f"far narrower than a cell, and without lines of their own: {_some(faces)}"] if faces else []


def _let_go(found: Found, joined: JoinedMesh, scale: float) -> list[str]:
    """What the grid could not hold, and how far the mesh is off that."""
    if not found.creases:
        return []
    off = farthest(found.creases, joined.points, joined.quads) * scale
    edges = [crease.edge.label() for crease in found.creases]
    return [
        f"edges that the grid cannot hold have no lines of their own, and are up to {off:.3g} off the mesh: "
        f"{_some(edges)}; a smaller size may hold them"
    ]


def _ended(part: Part, found: Found, tips: list[Tip]) -> list[str]:
    """Which faces end before a tip, and how far."""
    if not tips:
        return []
    solid = found.united.solid
    far = max(float(np.linalg.norm(solid.vertices[tip.vertex] - tip.place)) for tip in tips) * part.scale
    faces = list(dict.fromkeys(solid.faces[tip.face].label() for tip in tips))
    return [f"with tips that no quad fits into, and ended up to {far:.3g} before these: {_some(faces)}"]


def _some(labels: list[str]) -> str:
    return ", ".join(labels[:3]) + (f" and {len(labels) - 3} more" if len(labels) > 3 else "")


def _fitted(
    part: Part, found: Found, tips: list[Tip], run: Run, is_late: Callable[[], bool]
) -> tuple[JoinedMesh, InterfaceSlides]:
    """The mesh on a grid, its nodes on the model and untangled, and how they may move on.

    Parameters
    ----------
    part : Part
        Of the united solid.
    found : Found
    tips : list of Tip
        Of faces that end before them.
    run : Run
    is_late : callable
        Says when to leave hexahedra inverted.

    Raises
    ------
    SurfaceMeshError
        Hexahedra stay inverted.
    """
    solid, size = part.solids[0], found.size
    mesh = lay_sheets(solid, found.united.angles, found.reduced.rings, found.skin, size)
    joined = JoinedMesh(
        points=place_on_model(solid, mesh, found.creases, tips),
        hexes=mesh.hexes,
        hex_cells=np.zeros(len(mesh.hexes), dtype=np.int64),
        quads=mesh.quads,
        quad_cells=np.zeros(len(mesh.quads), dtype=np.int64),
        quad_faces=mesh.labels,
        edge_nodes={int(solid.edge_keys[edge]): nodes for edge, nodes in mesh.chains.items()},
    )
    slides = find_interface_slides(part, joined, name_faces(part, {}))
    surfaces = [face.surface for face in solid.faces]
    free = np.ones(len(joined.points), dtype=bool)
    free[joined.quads] = False
    n_at_first = len(joined.hexes)

    rounds = itertools.count()

    def on_round(left: int) -> bool:
        run.on_progress("fitted grid", 1.0 - left / n_at_first)
        return is_late() or (next(rounds) > 0 and left > _HOPELESS * n_at_first)

    untangled = untangle(
        joined.points,
        joined.hexes,
        free | slides.mask,
        np.full((len(joined.hexes), 3), size),
        slides,
        goal=_GOAL,
        guards=guards_outside(surfaces, len(joined.points), joined.quads, joined.quad_faces, _GUARD * size),
        on_round=on_round,
    )
    if untangled.worst <= 0:
        raise SurfaceMeshError("hexahedra stay inverted once the grid lies on the model")
    return replace(joined, points=untangled.points), slides
