"""Small meshes to look at."""

from dataclasses import replace

import numpy as np

from cadsweep.cells import SweptStructure, side_quads, sweep_hexes
from cadsweep.mesh import HexMesh


def twisted_block(n=4, n_layers=6, *, turn=0.8):
    """A square of n x n quads, swept upwards and turned on the way; its sides are named side_1 to side_4."""
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1))
    section = np.column_stack([x.ravel(), y.ravel()])
    ids = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    loop = np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])
    layers = []
    for k in range(n_layers + 1):
        sine, cosine = np.sin(turn * k / n_layers), np.cos(turn * k / n_layers)
        plane = section @ np.array([[cosine, sine], [-sine, cosine]])
        layers.append(np.column_stack([plane, np.full(len(plane), 4.0 * k / n_layers)]))
    sides = side_quads([loop], len(section), n_layers)
    boundaries = {"source": quads[:, ::-1], "target": quads + n_layers * len(section)}
    boundaries |= {f"side_{j + 1}": sides[:, j * n : (j + 1) * n].reshape(-1, 4) for j in range(4)}
    return HexMesh(
        points=np.concatenate(layers),
        hexes=sweep_hexes(quads, len(section), n_layers),
        boundaries=boundaries,
        parts={"block": np.arange(n_layers * len(quads))},
        structure=SweptStructure(quads=quads, loops=(loop,), n_nodes=len(section), n_layers=n_layers),
        info={"seconds": {"surface": 0.25}, "sweeps": [{"source": [0], "target": ["lid"], "layers": n_layers}]},
    )


def painted_block():
    """The twisted block with a red source and a green target, blue elsewhere; ``caps`` are the two together."""
    mesh = twisted_block()
    caps = np.concatenate([mesh.boundaries["source"], mesh.boundaries["target"]])
    colors = {"boundaries": {"source": "#ff0000", "target": "#00ff0080"}, "parts": {"block": "#0000ff"}}
    return replace(mesh, boundaries=mesh.boundaries | {"caps": caps}, info=mesh.info | {"colors": colors})


def unit_cube():
    """One hexahedron."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    return HexMesh(points=np.concatenate([corners, corners + [0, 0, 1]]), hexes=np.arange(8)[None], boundaries={})


def of_order_2(mesh, n_nodes):
    """The same mesh with 20 or 27 nodes a hexahedron, every new node in the middle of its corners; none is shared."""
    c = mesh.points[mesh.hexes]
    around = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
    if n_nodes == 27:
        around += [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7], list(range(8))]
    middles = np.stack([c[:, corners].mean(axis=1) for corners in around], axis=1)
    new = mesh.n_nodes + np.arange(len(around) * mesh.n_hexes).reshape(mesh.n_hexes, -1)
    return replace(
        mesh,
        points=np.concatenate([mesh.points, middles.reshape(-1, 3)]),
        hexes=np.concatenate([mesh.hexes, new], axis=1),
        structure=None,
    )
