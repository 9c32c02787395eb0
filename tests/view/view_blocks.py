"""Small meshes to look at."""

import numpy as np

from cadsweep.mesh import HexMesh, SweptStructure, side_quads, sweep_hexes


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
