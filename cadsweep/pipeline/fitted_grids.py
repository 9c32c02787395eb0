"""A solid filled by a fitted grid, where no sweep, columns or cuts are to be had.

Place in the flow: the last row of the ways of :mod:`.routes`. Grids are tried from coarse to fine until the model's
topology is found on one, its mesh is valid and good enough, and it passes every check that other meshes pass.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from .. import cad
from ..arrays import FloatArray
from ..blocks.interface_slides import InterfaceSlides, find_interface_slides
from ..blocks.joined import JoinedMesh
from ..blocks.naming import name_faces
from ..brep import Part, Solid
from ..errors import CadSweepError, InputError, InvertedHexError, NotSweepableError, SurfaceMeshError
from ..fitted import (
    Facets,
    Fitted,
    United,
    choose_planes,
    keep_inside,
    label_quads,
    lay_sheets,
    lay_strips,
    match_topology,
    place_on_model,
    unite,
    without_rings,
)
from ..mesh import HexMesh
from ..options import SweepOptions
from ..smoothing.untangle import guards_outside, untangle
from .complexes.several import finish
from .origin import made_of
from .run import Run, spent

log = logging.getLogger(__name__)

LEAST = 0.1
"""Worst scaled Jacobian that a fitted grid must have: what is poorer than that is of little use."""
_GOAL = 0.25
"""What untangling tries to reach."""
_GUARD = 0.25
"""Height of the hexahedra outside over the size: little, so that they fit into a bore of one cell."""
_FINER = (1.0, 0.75, 0.55, 0.4)
"""Sizes that are tried, over the first."""
_TIME = 30.0
"""Seconds, of the processor, after which no finer grid is begun."""
_LAST = 60.0
"""The same after which one is given up where no size is asked for."""
_CELLS = 2500
"""Hexahedra about as many of which the first grid has where no size is asked for."""
_MOST = 45_000
"""Hexahedra beyond which no finer grid is begun where no size is asked for."""
_SENSELESS = (
    *("layers", "bias", "fractions", "source", "target", "rail_layers", "wall_layers", "periodic"),
    *("sizes", "counts", "biases", "local_sizes"),
)
"""Options that speak of what a fitted grid has not: layers, caps, faces that answer each other, edges with sizes."""


def asked_in_vain(options: SweepOptions) -> list[str]:
    """Options that are given, and that a fitted grid cannot do."""
    return [name for name in _SENSELESS if getattr(options, name) is not None]


def mesh_fitted(part: Part, options: SweepOptions, run: Run, refused: CadSweepError | None) -> HexMesh:
    """Mesh a part of one solid by a fitted grid; `refused` says why nothing else made a mesh.

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
    model = part.solids[0]
    facets = _facets(model)
    began, problem = spent(), "it would have too many hexahedra"

    def is_late() -> bool:
        return options.size is None and spent() - began > _LAST

    for size, united, planes in _grids(part, options, facets):
        if spent() - began > _TIME:
            break
        try:
            with run.stage("fitted grid"):
                whole = replace(part, solids=(united.solid,))
                joined, slides = _fitted(whole, united, facets, planes, size, run, is_late)
            notes = [_note(refused), *_bridges(model, united)]
            mesh = finish(whole, joined, options, run, notes=notes, slides=lambda slides=slides: slides)  # type: ignore[misc]
        except (SurfaceMeshError, InvertedHexError) as error:
            problem = error.what
            log.info("fitted grid of size %g: %s", size * part.scale, problem)
            continue
        assert isinstance(mesh, HexMesh), "it has no factors"
        worst = float(mesh.info["quality"].min_scaled_jacobian)
        if worst < LEAST:
            problem = f"its worst scaled Jacobian is {worst:.2f}"
        elif options.tolerance is not None and mesh.info["distance"] > options.tolerance:
            problem = f"it is {mesh.info['distance']:.3g} off the faces"
        else:
            return made_of(mesh, part)
    raise NotSweepableError(f"no fitted grid fits the solid: {problem}")


def _note(refused: CadSweepError | None) -> str:
    why = "it was asked for" if refused is None else refused.what
    return f"filled by a fitted grid, good for stiffness and not for layers along walls, because {why}"


def _grids(part: Part, options: SweepOptions, facets: Facets) -> Iterator[tuple[float, United, list[FloatArray]]]:
    """Sizes, faces united for them, and planes of a grid: even first, then closer where the part is narrow."""
    model = part.solids[0]
    for size in _sizes(part, options):
        even = choose_planes(model, facets, size)
        narrow = choose_planes(model, facets, size, narrow=True)
        closer = [narrow] if list(map(len, narrow)) != list(map(len, even)) else []
        united = unite(model, facets, size, ridges=True)
        without = unite(model, facets, size, ridges=False)
        ways = [united] if np.array_equal(united.of_face, without.of_face) else [united, without]
        for planes, way in itertools.product([even, *closer], ways):
            yield size, way, planes


def _sizes(part: Part, options: SweepOptions) -> Iterator[float]:
    solid = part.solids[0]
    first = (solid.volume / _CELLS) ** (1.0 / 3.0) if options.size is None else options.size / part.scale
    for share in _FINER:
        if options.size is None and solid.volume / (first * share) ** 3 > _MOST:
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


def _bridges(model: Solid, united: United) -> list[str]:
    """What of the model the mesh has no lines for."""
    faces = [model.faces[face].label() for face in united.bridged]
    if not faces:
        return []
    more = f" and {len(faces) - 3} more" if len(faces) > 3 else ""
    return [f"far narrower than a cell, and without lines of their own: {', '.join(faces[:3])}{more}"]


def _fitted(  # noqa: PLR0917
    part: Part,
    united: United,
    facets: Facets,
    planes: list[FloatArray],
    size: float,
    run: Run,
    is_late: Callable[[], bool],
) -> tuple[JoinedMesh, InterfaceSlides]:
    """The mesh on a grid of a size, its nodes on the model and untangled, and how they may move on.

    Parameters
    ----------
    part : Part
        Of the united solid.
    united : United
    facets : Facets
        Of the faces of the model.
    planes : list of (n,) float64
        Of the grid, along each axis.
    size : float
    run : Run
    is_late : callable
        Says when to leave hexahedra inverted.

    Raises
    ------
    SurfaceMeshError
        The grid has not the model's topology, or hexahedra stay inverted.
    """
    solid = part.solids[0]
    grid = keep_inside(planes, facets)
    reduced = without_rings(solid, size)
    covering = facets._replace(faces=reduced.of_face[united.of_face[facets.faces]])
    labels = label_quads(reduced.solid, covering, grid.points, grid.quads, size)
    skin = Fitted(points=grid.points, hexes=grid.hexes, quads=grid.quads, labels=labels, chains={})
    skin = lay_strips(reduced.solid, skin, size)
    chains = match_topology(reduced.solid, skin.points, skin.quads, skin.labels, size)
    skin = replace(
        skin,
        labels=reduced.faces[skin.labels],
        chains={int(reduced.edges[edge]): nodes for edge, nodes in chains.items()},
    )
    mesh = lay_sheets(solid, united.angles, reduced.rings, skin, size)
    joined = JoinedMesh(
        points=place_on_model(solid, mesh),
        hexes=mesh.hexes,
        hex_cells=np.zeros(len(mesh.hexes), dtype=np.int64),
        quads=mesh.quads,
        quad_cells=np.zeros(len(mesh.quads), dtype=np.int64),
        quad_faces=mesh.labels,
        edge_nodes={int(solid.edge_keys[edge]): nodes for edge, nodes in mesh.chains.items()},
    )
    slides = find_interface_slides(part, joined, name_faces(part, {}))
    free = np.ones(len(joined.points), dtype=bool)
    free[joined.quads] = False
    n_at_first = len(joined.hexes)

    def on_round(left: int) -> bool:
        run.on_progress("fitted grid", 1.0 - left / n_at_first)
        return is_late()

    found = untangle(
        joined.points,
        joined.hexes,
        free | slides.mask,
        np.full((len(joined.hexes), 3), size),
        slides,
        goal=_GOAL,
        guards=guards_outside(
            [face.surface for face in solid.faces], len(mesh.points), mesh.quads, mesh.labels, _GUARD * size
        ),
        on_round=on_round,
    )
    if found.worst <= 0:
        raise SurfaceMeshError("hexahedra stay inverted once the grid lies on the model")
    return replace(joined, points=found.points), slides
