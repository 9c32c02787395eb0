"""The skeleton of a page: style, viewer, and the data that it draws, in one file.

Place in the flow: below :mod:`.meshes` and :mod:`.refused`, which say what stands on their pages.

Method: the page holds everything it needs, the drawing library plotly.js included, and loads nothing from the network.
The library and the traces are packed (zlib, then five printable characters for four bytes) and the browser unpacks
them, so that the page of a small mesh has less than 2 MB.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import CadSweepError
from ..view import write_whole

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;/=>?@^_`{|}~"
"""Of base 85, as Python's ``b85encode`` has them, but for ``<``, which begins an end of the element."""

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; color: #1d2733 }
h1 { font-size: 1.5rem; margin: 0 } h2 { font-size: 1.1rem; margin: 1.6rem 0 .4rem }
table { border-collapse: collapse } td, th { padding: .15rem .8rem .15rem 0; text-align: left; vertical-align: top }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums }
#view { height: 36rem; border: 1px solid #ccd3db; border-radius: 6px }
.bar button { font: inherit; padding: .3rem .8rem; margin: 0 .4rem .5rem 0; border: 1px solid #9aa6b2;
  border-radius: 5px; background: #fff; cursor: pointer } .bar button.on { background: #1f5fa8; color: #fff }
.valid { color: #1b7a3d } .invalid { color: #b3261e } code { background: #eef1f4; padding: .1rem .35rem }
.swatch { display: inline-block; width: .8em; height: .8em; border: 1px solid #9aa6b2 }
.columns { display: flex; flex-wrap: wrap; gap: 0 4rem }
"""
_SCRIPT = """
const scene = JSON.parse(document.getElementById("scene").textContent);
const view = document.getElementById("view");
const bar = document.getElementById("bar");
function show(name) {
  for (const b of bar.children) b.classList.toggle("on", b.textContent === name);
  return Plotly.restyle(view, {visible: scene.traces.map((t, i) => scene.views[name].includes(i))});
}
for (const name of Object.keys(scene.views)) {
  const button = document.createElement("button");
  button.textContent = name;
  button.onclick = () => show(name);
  bar.append(button);
}
const buttons = [["toImage", "orbitRotation", "tableRotation", "resetCameraDefault3d"]];
bar.firstChild.classList.add("on");
async function unpacked(name) {
  // Browsers do this since 2023; five megabytes of text become one and a half.
  const text = document.getElementById(name).textContent, bytes = new Uint8Array(text.length / 5 * 4);
  const digits = new Map(Array.from(scene.digits, (c, i) => [c, i]));
  for (let i = 0, k = 0; i < text.length; i += 5, k += 4) {
    let value = 0;
    for (let j = 0; j < 5; j++) value = value * 85 + digits.get(text[i + j]);
    for (let j = 3; j >= 0; j--) { bytes[k + j] = value & 255; value = Math.floor(value / 256); }
  }
  const flow = new Blob([bytes.slice(0, scene.packed[name])]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(flow).text();
}
async function draw() {
  const code = document.createElement("script");
  code.textContent = await unpacked("library");
  document.head.append(code);
  scene.traces = JSON.parse(await unpacked("traces"));
  return Plotly.newPlot(view, scene.traces, scene.layout, looks);
}
const looks = {responsive: true, modeBarButtons: buttons, displaylogo: false};
draw().then(() => { document.body.dataset.drawn = "yes"; })
  .catch((error) => { view.textContent = "This browser cannot draw the view: " + error; });
"""


def write_page(path: Path, title: str, sections: Sequence[str], scene: dict[str, Any]) -> Path:
    """Write a page: sections are HTML, `title` is plain text, `scene` has ``traces``, ``views`` and ``layout``."""
    library, n_library = _library()
    traces, n_traces = _packed(_compact(scene["traces"]))
    known = {"views": scene["views"], "layout": scene["layout"], "digits": DIGITS}
    known["packed"] = {"library": n_library, "traces": n_traces}
    page = "\n".join(
        [
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>',
            f'<link rel="icon" href="data:,"><style>{_STYLE}</style></head><body>',
            *sections,
            f'<script type="application/json" id="scene">{_embedded(known)}</script>',
            f'<script type="text/plain" id="traces">{traces}</script>',
            f'<script type="text/plain" id="library">{library}</script>',
            f"<script>{_SCRIPT}</script></body></html>",
        ]
    )
    return write_whole(path, page.encode())


def _library() -> tuple[str, int]:
    """The drawing library, packed, and the bytes of that before they became characters."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise CadSweepError(f'reports need the extra "view": pip install "cadsweep[view]" ({error})') from error
    return _packed_library(str(get_plotlyjs()))


@cache
def _packed_library(code: str) -> tuple[str, int]:
    return _packed(code)


def _packed(code: str) -> tuple[str, int]:
    packed = zlib.compress(code.encode(), 9)
    padded = packed + bytes(-len(packed) % 4)
    return base64.b85encode(padded).decode().replace("<", "/"), len(packed)


def _compact(data: Any) -> str:
    return json.dumps(data, separators=(",", ":"), allow_nan=False)


def _embedded(data: Any) -> str:
    """JSON that cannot end the element it stands in."""
    return _compact(data).replace("<", "\\u003c")


def make_layout(points: FloatArray) -> dict[str, Any]:
    """Axes and camera for a view of points (n, 3)."""
    # With the aspect "data" a length of the view is one of the model over the geometric mean of the box's sides; a cube
    # fills the view from plotly's own 1.25.
    sides = np.maximum(np.ptp(points, axis=0), 1e-9 * np.ptp(points))
    eye = 1.25 * float(np.linalg.norm(sides) / np.sqrt(3) / np.prod(sides) ** (1 / 3))
    axes = {"showbackground": False, "showspikes": False}
    return {
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "scene": {
            "aspectmode": "data",
            "camera": {"eye": dict.fromkeys("xyz", eye)},
            "xaxis": axes,
            "yaxis": axes,
            "zaxis": axes,
        },
        "legend": {"x": 0, "y": 1, "itemsizing": "constant"},
        "uirevision": "same",
    }


def table(rows: list[tuple[str, str]]) -> str:
    """Rows whose cells are HTML already."""
    body = "".join(f'<tr><td>{key}</td><td class="n">{value}</td></tr>' for key, value in rows)
    return f"<table>{body}</table>"


def listed(title: str, items: Any) -> str:
    rows = "".join(f"<li>{escape(str(item))}</li>" for item in items)
    return f"<h2>{title}</h2><ul>{rows}</ul>" if rows else ""
