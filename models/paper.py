"""The paper's four examples: why functional H, in numbers and pictures.

Run ``python models/paper.py [--figures DIR] [--json]``. The parts are those of ``c_shape.py``,
``square_semicircle.py``, ``skewed_ellipses.py`` and ``square_to_arcs.py`` (section 5, figures 8 to 11). Each goes
through CAD, recognition and surface meshing, and its layers are placed with F, G and H the way the paper does: always
from the source, without residual, without smoothing. Then the same parts with this package's defaults.

Definitions. Ring k holds the boundary nodes of layer k, ring 0 those of the source. ``n_k`` is the pseudo-normal of
ring k (the unit vector area of its loops; the normal, where the ring is plane), ``c_k`` the mean of its nodes, ``A_k``
the matrix of the affine map that takes ring 0 to ring k.

``flatness``
    ``v . n_k`` with ``v = A_k n_0``: 1 where the height of the dome is kept, 0 where it is flattened, negative where it
    is turned inside out.
``skewness``
    ``|v - (v . n_k) n_k|``: how far the top of the dome is pushed aside, over its height; 0 where it stays upright.
``mesh_flatness``
    The same seen in the mesh: the greatest distance of an interior node of layer k from the mean plane of ring k
    (through ``c_k``, normal ``n_k``), divided by the same for the source.
``mesh_skewness``
    Let p be the highest source node, h its distance from the plane of ring 0, f its foot there. The part along
    the mean plane of ring k of (image of p - image of f), divided by h. The image of the foot is where F puts p: F
    maps ring k best within its plane, and nothing out of it.
``worst``, ``mean``, ``n_inverted``
    Least and mean scaled Jacobian of the hexahedra between layers k - 1 and k (of each the least over its eight
    corners), and how many are not positive.
``rank``, ``condition``
    Of the matrix of the least-squares system, 3 where the map is unique.
``residual``
    Root mean square over ring k of the distance between node and image: what no affine map can do, and what the
    boundary hexahedra take up as a slope.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import cadsweep as cs
from cadsweep.arrays import FloatArray
from cadsweep.brep import Solid
from cadsweep.cells import sweep_hexes
from cadsweep.intervals import CellSweep, Wishes, assign_shared_intervals
from cadsweep.mesh import SurfaceMesh
from cadsweep.projection import FactoredSweep, fit_affine, project_layers, pseudo_normal
from cadsweep.quality import scaled_jacobians
from cadsweep.surface import mesh_boundary
from cadsweep.view import add_mesh, check_drawing, quiet_vtk, to_pyvista

EXAMPLES = {"c_shape": 8, "square_semicircle": 9, "skewed_ellipses": 10, "square_to_arcs": 11}
"""Name of the model, and the figure of the paper that shows it."""

FUNCTIONALS = ("F", "G", "H")
N_LAYERS = 9
SIZE = 0.22  # of the quads; the sections are about 2 wide
PICTURE_SCALE = {"vertical": False, "position_x": 0.1, "position_y": 0.02, "width": 0.8, "height": 0.1}


@dataclass(frozen=True, kw_only=True)
class LayerFigures:
    """What the docstring of the module defines, for one layer."""

    layer: int  # of nodes; the hexahedra meant lie between it and the one before
    flatness: float
    skewness: float
    mesh_flatness: float
    mesh_skewness: float
    worst: float
    mean: float
    n_inverted: int
    rank: int
    condition: float | None  # None where the map is not unique
    residual: float


def is_domed(solid: Solid, face: int) -> bool:
    """Whether a face has a plane boundary and an inside that leaves the plane: the paper's source."""
    edges = [solid.edges[e] for e in solid.faces[face].edges]
    boundary = np.concatenate([edge.curve.evaluate(np.linspace(0, 1, 9)) for edge in edges])
    center = boundary.mean(axis=0)
    _, spread, axes = np.linalg.svd(boundary - center, full_matrices=False)
    plane = spread[2] < 1e-4 * spread[0]
    return plane and abs(axes[2] @ (solid.faces[face].center - center)) > 1e-2 * np.sqrt(solid.faces[face].area)


def find_sweep(name: str) -> tuple[cs.Part, cs.Sweep]:
    """Load an example, and find the sweep that begins at its domed cap."""
    part = cs.load(Path(__file__).with_name(f"{name}.py"))
    return part, next(s for s in cs.find_sweeps(part) if is_domed(s.solid, s.source[0]))


def mesh_sides(sweep: cs.Sweep, *, size: float = SIZE, n_layers: int = N_LAYERS) -> SurfaceMesh:
    """Mesh the source and the linking sides of an example."""
    cell = CellSweep(fill=sweep, grids=tuple(sweep.linking_sides), free=sweep.source, by_itself=True)
    (counts,) = assign_shared_intervals([cell], Wishes(size=size, layers=n_layers))
    return mesh_boundary(sweep, counts)


def place_layers(sides: SurfaceMesh, functional: str) -> FactoredSweep:
    """Place the layers as the paper does: each from the source, by the affine map alone."""
    source = sides.source
    return project_layers(
        source.points,
        source.quads,
        sides.rings,
        loops=source.loops,
        functional=functional,
        strategy="source",
        residual=False,
    )


def measure_layers(sides: SurfaceMesh, functional: str) -> list[LayerFigures]:
    """Measure layers 1 to the last of an example."""
    source, rings = sides.source, sides.rings
    placed = place_layers(sides, functional)
    points = placed.points()
    hexes = sweep_hexes(source.quads, len(source.points), len(rings) - 1)
    quality = scaled_jacobians(points.reshape(-1, 3), hexes).reshape(len(rings) - 1, -1)

    # The rings hold the loops one after another; the normal wants to know where each begins.
    loops = np.split(np.arange(rings.shape[1]), np.cumsum([len(loop) for loop in source.loops])[:-1])
    inside = np.setdiff1d(np.arange(len(source.points)), np.concatenate(source.loops))
    normal = pseudo_normal(rings[0], loops)
    heights = (source.points[inside] - rings[0].mean(axis=0)) @ normal
    top = inside[np.argmax(np.abs(heights))]
    height = heights[np.argmax(np.abs(heights))]

    figures = []
    for k in range(1, len(rings)):
        fit = fit_affine(rings[0], rings[k], functional, loops=loops)
        foot = fit_affine(rings[0], rings[k], "F", loops=loops)(source.points[top])
        layer_normal = pseudo_normal(rings[k], loops)
        image = fit.matrix @ normal
        offsets = (points[k, inside] - rings[k].mean(axis=0)) @ layer_normal
        figures.append(
            LayerFigures(
                layer=k,
                flatness=float(image @ layer_normal),
                skewness=float(np.linalg.norm(off_axis(image, layer_normal))),
                mesh_flatness=float(np.abs(offsets).max() / abs(height)),
                mesh_skewness=float(np.linalg.norm(off_axis(points[k, top] - foot, layer_normal)) / abs(height)),
                worst=float(quality[k - 1].min()),
                mean=float(quality[k - 1].mean()),
                n_inverted=int((quality[k - 1] <= 0).sum()),
                rank=int(fit.rank),
                condition=float(fit.condition) if np.isfinite(fit.condition) else None,
                residual=float(np.sqrt(np.mean(np.sum((fit(rings[0]) - rings[k]) ** 2, axis=1)))),
            )
        )
    return figures


def off_axis(vector: FloatArray, axis: FloatArray) -> FloatArray:
    """The part of a vector across a unit vector."""
    return vector - (vector @ axis) * axis


def mesh_with_defaults(part: cs.Part, sweep: cs.Sweep, *, size: float = SIZE, n_layers: int = N_LAYERS) -> cs.HexMesh:
    """Mesh an example the way this package does when nothing else is asked of it."""
    return cs.sweep_mesh(part, source=sweep.source[0], size=size, layers=n_layers)


def summarise(mesh: cs.HexMesh) -> dict[str, Any]:
    """Worst, mean and number of inverted hexahedra of a mesh."""
    quality = scaled_jacobians(mesh.points, mesh.hexes)
    return {
        "n_hexes": mesh.n_hexes,
        "worst": float(quality.min()),
        "mean": float(quality.mean()),
        "n_inverted": int((quality <= 0).sum()),
    }


def print_tables(results: dict[str, Any]) -> None:
    """Print a row for every example and functional, then one for every example with the defaults."""
    print("Every layer straight from the source, no residual, no smoothing (section 5 of the paper).")
    print("Flatness and skewness: layer 1, the middle one, the last. Rank, condition, residual: the last layer.\n")
    print(f"{'example':18}   {'flatness':^20}  {'skewness':^20}   worst   mean  inverted  rank  condition  residual")
    for name, result in results.items():
        for functional in FUNCTIONALS:
            layers = result["layers"][functional]
            shown = [layers[0], layers[len(layers) // 2], layers[-1]]
            last = layers[-1]
            condition = "inf" if last["condition"] is None else f"{last['condition']:.2g}"
            print(
                f"{name if functional == 'F' else '':18} {functional} "
                + "".join(f"{round(layer['flatness'], 3) + 0.0:6.3f} " for layer in shown)
                + " "
                + "".join(f"{layer['skewness']:7.3f}" for layer in shown)
                + f" {min(layer['worst'] for layer in layers):7.3f} {np.mean([layer['mean'] for layer in layers]):6.3f}"
                + f" {sum(layer['n_inverted'] for layer in layers):9d} {last['rank']:5d} {condition:>10}"
                + f" {last['residual']:9.4f}"
            )
    print("\nThe same meshes with the defaults of this package: both caps, residual, smoothing.\n")
    print(f"{'example':18}   worst   mean  inverted")
    for name, result in results.items():
        figures = result["defaults"]
        print(f"{name:18} {figures['worst']:7.3f} {figures['mean']:6.3f} {figures['n_inverted']:9d}")


def draw_example(name: str, sides: SurfaceMesh, defaults: cs.HexMesh, folder: Path) -> None:
    """Draw an example: a column for each functional and one for the defaults, all on one scale.

    Above the whole mesh; below its fourth to sixth layer, cut along the plane of symmetry y = 0.
    """
    import pyvista as pv
    from PIL import Image

    hexes = sweep_hexes(sides.source.quads, len(sides.source.points), len(sides.rings) - 1)
    meshes = {
        f"minimising {f}": cs.HexMesh(points=place_layers(sides, f).points().reshape(-1, 3), hexes=hexes, boundaries={})
        for f in FUNCTIONALS
    }
    meshes["H, both caps, residual, smoothing"] = defaults
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=True, shape=(2, len(meshes)), window_size=(1480, 740), border=False)
        plotter.set_background("white")
        for column, (title, mesh) in enumerate(meshes.items()):
            scale = PICTURE_SCALE if column == len(meshes) - 1 else False
            plotter.subplot(0, column)
            plotter.add_text(title, font_size=10, color="black")
            add_mesh(plotter, mesh, show_boundaries=False, scale=scale)
            plotter.enable_parallel_projection()
            plotter.view_vector((0.35, 1.0, 0.3), viewup=(0, 0, 1))
            plotter.subplot(1, column)
            n_quads = mesh.n_hexes // (len(sides.rings) - 1)
            middle = to_pyvista(mesh).extract_cells(range(3 * n_quads, 6 * n_quads))
            cut = middle.slice(normal="y", origin=(0, 0, 0), generate_triangles=False)
            style = {"show_edges": True, "line_width": 1.5, "lighting": False, "show_scalar_bar": False}
            plotter.add_mesh(cut, scalars="scaled_jacobian", clim=(0, 1), below_color="red", **style)
            plotter.enable_parallel_projection()
            plotter.view_vector((0, 1, 0), viewup=(0, 0, 1))
            plotter.camera.zoom(1.1)
        image = Image.fromarray(plotter.screenshot(None))
        plotter.close()
    image.quantize(128, method=Image.Quantize.MAXCOVERAGE).save(folder / f"paper_{name}.png", optimize=True)


def draw_shapes(results: dict[str, Any], folder: Path) -> None:
    """Draw flatness and skewness over the layers of every example."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 5), layout="constrained")
    axes = figure.subplots(2, len(results), sharex=True, sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results.items()):
        for row, figure_name in enumerate(("flatness", "skewness")):
            for functional, marker in zip(FUNCTIONALS, "ov.", strict=True):
                # Where G has no solution of its own there is nothing to show.
                layers = [layer for layer in result["layers"][functional] if functional != "G" or layer["rank"] == 3]
                values = [layer[figure_name] for layer in layers]
                axes[row, column].plot([layer["layer"] for layer in layers], values, f"{marker}-", label=functional)
            axes[row, column].grid(alpha=0.3)
        axes[0, column].set_title(name)
        axes[1, column].set_xlabel("layer")
    axes[0, 0].set_ylabel("flatness")
    axes[1, 0].set_ylabel("skewness")
    axes[1, 0].set_ylim(-0.2, 3.2)  # G leaves the picture where it breaks down
    axes[0, 0].legend()
    figure.savefig(folder / "paper_shapes.png", dpi=90)


def main() -> None:
    """Run the four examples."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--figures", type=Path, metavar="DIR", help="write pictures to this folder")
    parser.add_argument("--json", action="store_true", help="print every figure of every layer as JSON")
    options = parser.parse_args()
    if options.figures:
        if not (find_spec("pyvista") and find_spec("matplotlib")):
            parser.error('--figures needs the extra "view": pip install "cadsweep[view]"')
        check_drawing()
        options.figures.mkdir(parents=True, exist_ok=True)

    start = time.perf_counter()
    results: dict[str, Any] = {}
    for name, number in EXAMPLES.items():
        part, sweep = find_sweep(name)
        sides = mesh_sides(sweep)
        mesh = mesh_with_defaults(part, sweep)
        results[name] = {
            "figure": number,
            "layers": {f: [asdict(layer) for layer in measure_layers(sides, f)] for f in FUNCTIONALS},
            "defaults": summarise(mesh),
        }
        if options.figures:
            draw_example(name, sides, mesh, options.figures)
    if options.figures:
        draw_shapes(results, options.figures)
    if options.json:
        print(json.dumps({"seconds": time.perf_counter() - start, "examples": results}, indent=1))
    else:
        print_tables(results)


if __name__ == "__main__":
    main()
