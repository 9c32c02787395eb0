"""What a page's viewer draws: faces and lines as plotly's traces, arrays as bytes."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray


def array(values: FloatArray | IntArray) -> dict[str, str]:
    """A typed array the way plotly.js reads it: element type, and base64 of the bytes."""
    is_real = np.issubdtype(values.dtype, np.floating)
    data = np.ascontiguousarray(values, dtype="<f4" if is_real else "<i4")
    return {"dtype": "f4" if is_real else "i4", "bdata": base64.b64encode(data.tobytes()).decode()}


def faces(
    points: FloatArray,
    quads: IntArray,
    *,
    intensity: FloatArray | None = None,
    color: str | None = None,
    name: str | None = None,
) -> dict[str, Any]:
    """Quads (q, 4) or triangles (q, 3), coloured by a number a quad or by one colour."""
    used, inverse = np.unique(quads, return_inverse=True)
    corners = inverse.reshape(quads.shape)
    triangles = corners if quads.shape[1] == 3 else corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    x, y, z = points[used].T
    trace: dict[str, Any] = {"type": "mesh3d", "x": array(x), "y": array(y), "z": array(z), "flatshading": True}
    trace |= {key: array(triangles[:, j]) for j, key in enumerate("ijk")}
    trace["lighting"] = {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05}
    trace["visible"] = False
    if intensity is not None:
        trace |= {"intensity": array(np.repeat(intensity, 2)), "intensitymode": "cell", "cmin": 0, "cmax": 1}
        trace |= {"colorscale": "Viridis", "colorbar": {"title": {"text": "scaled Jacobian"}, "len": 0.7}}
        trace["hovertemplate"] = "scaled Jacobian %{intensity:.3f}<extra></extra>"
    else:
        trace |= {"color": color, "name": name, "showlegend": True, "hovertemplate": f"{name}<extra></extra>"}
    return trace


def lines(points: FloatArray, edges: IntArray, *, color: str, width: int, name: str | None = None) -> dict[str, Any]:
    """Edges as one line with gaps."""
    places = np.full((len(edges), 3, 3), np.nan)
    places[:, :2] = points[edges]
    x, y, z = places.reshape(-1, 3).T
    trace: dict[str, Any] = {"type": "scatter3d", "mode": "lines", "x": array(x), "y": array(y), "z": array(z)}
    trace |= {"line": {"color": color, "width": width}, "hoverinfo": "skip", "showlegend": name is not None}
    return trace | {"name": name or "edges", "visible": False}


def unique_edges(quads: IntArray) -> IntArray:
    """Every edge (m, 2) of quads once."""
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0)
