"""Looking at a mesh: clips, layers, blocks apart, colours, the histogram, the worst ones, boundaries.

Place in the flow: works at the desk; figures and quads come from :mod:`.skins`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..view import boundary_colors, mesh_colors, outline, part_colors
from .desk import Desk
from .scene import EDGE, colored, lines_of, rgb, surface_of
from .skins import Look, MeshView

MOST_EDGES = 200_000
"""Quads up to which edges are drawn: beyond they are all that one sees."""
_FIELDS = {"axis": "", "place": 0.5, "turned": False, "peel": 0, "apart": 0.0, "color": "quality"}
_BELOW = (224, 36, 27)
_PLAIN = (200, 207, 216)


class Looking:
    """Keeps how the mesh is looked at."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._range: tuple[float, float] | None = None
        self._only = -1
        self._hidden: set[str] = set()
        desk.state.update({f"l_{name}": value for name, value in _FIELDS.items()})
        desk.state.update(
            {
                "bars": [], "range": None, "worst": [], "only": -1, "figures": [], "groups": [], "legend": None,
                "n_levels": 0, "n_blocks": 0, "n_shown": "", "has_distance": False, "busy": False,
            }
        )  # fmt: skip
        self._wanted = self._under_way = False
        desk.on("mesh", self._new)
        desk.on("look", self._refresh)
        desk.trigger("look", self._look)
        desk.trigger("bar", self._bar)
        desk.trigger("range_none", self._range_none)
        desk.trigger("worst", self._worst)
        desk.trigger("group", self._group)

    def _new(self) -> None:
        desk = self._desk
        view = desk.view
        assert view is not None
        report = view.mesh.info.get("quality")
        self._range, self._only, self._hidden = None, -1, set()
        edges, counts = view.histogram()
        most = max(1, int(counts.max()))
        colors = [*mesh_colors(view.mesh), *boundary_colors(len(view.mesh.interfaces))]
        groups = [*view.mesh.boundaries.items(), *view.mesh.interfaces.items()]
        desk.state.update({f"l_{name}": value for name, value in _FIELDS.items()})
        desk.state.update(
            {
                "bars": [
                    {
                        "low": round(float(edges[j]), 4),
                        "high": round(float(edges[j + 1]), 4),
                        "n": int(n),
                        # Few are as much worth seeing as many: heights by logarithm.
                        "height": round(100 * float(np.log1p(n) / np.log1p(most)), 1),
                    }
                    for j, n in enumerate(counts)
                ],
                "range": None,
                "only": -1,
                "worst": [
                    {"id": int(h), "quality": f"{view.quality[h]:.4f}", "place": _place(view.centers[h])}
                    for h in view.worst()
                ],
                "figures": _figures(view, report),
                "groups": [
                    {"name": name, "n": f"{len(quads):,}", "color": color, "on": True}
                    for (name, quads), color in zip(groups, colors, strict=True)
                ],
                "n_shown": "",
                "n_levels": 0,
                "n_blocks": view.n_blocks,
                "has_distance": view.distances is not None,
            }
        )

    def _look(self, name: str, value: Any) -> None:
        if name not in _FIELDS:
            return
        known: Any = _FIELDS[name]
        kind = type(known)
        self._desk.state[f"l_{name}"] = kind(float(value)) if kind in (int, float) else kind(value)
        self._refresh()

    def _bar(self, j: int, more: bool) -> None:
        """Take a bar of the histogram as the range; with `more` as its other end."""
        bar = self._desk.state.bars[int(j)]
        low, high = bar["low"], bar["high"]
        if more and self._range is not None:
            low, high = min(low, self._range[0]), max(high, self._range[1])
        self._range = (low, high)
        self._desk.state.range = [low, high]
        self._refresh()

    def _range_none(self) -> None:
        self._range, self._only = None, -1
        self._desk.state.update({"range": None, "only": -1})
        self._refresh()

    def _worst(self, hexahedron: int) -> None:
        self._only = -1 if self._only == int(hexahedron) else int(hexahedron)
        self._desk.state.only = self._only
        self._refresh()

    def _group(self, name: str) -> None:
        self._hidden ^= {name}
        self._desk.state.groups = [{**row, "on": row["name"] not in self._hidden} for row in self._desk.state.groups]
        self._refresh()

    def _refresh(self) -> None:
        if self._desk.view is None or self._desk.state.showing != "mesh":
            self._desk.scene.set_surface("mesh", None)
            self._desk.scene.set_lines("rims", None, EDGE)
            return
        self._wanted = True
        if not self._under_way:
            self._under_way = True
            self._desk.start(self._draw())

    async def _draw(self) -> None:
        """Draw the look that is wanted last; what was wanted meanwhile is left out."""
        desk = self._desk
        try:
            while self._wanted:
                self._wanted = False
                view, state = desk.view, desk.state
                assert view is not None
                low, high = self._range or (-1.0, 1.0)
                look = Look(**{name: state[f"l_{name}"] for name in _FIELDS}, low=low, high=high, only=self._only)
                hidden = set(self._hidden)
                made = await desk.jobs.compute(lambda view=view, look=look, hidden=hidden: _drawn(view, look, hidden))  # type: ignore[misc]
                if desk.view is not view or state.showing != "mesh":
                    return
                surface, rims, legend, n_shown = made
                desk.scene.set_surface("mesh", surface, edges=surface.GetNumberOfCells() <= MOST_EDGES)
                desk.scene.set_lines("rims", rims, EDGE)
                state.update({"legend": legend, "n_shown": f"{n_shown:,}", "n_levels": _n_levels(view)})
                desk.push()
                state.flush()
        finally:
            self._under_way = False


def _n_levels(view: MeshView) -> int:
    return int(view.levels.max())


def _drawn(view: MeshView, look: Look, hidden: set[str]) -> tuple[Any, Any, dict[str, Any], int]:
    """The surface with its colours, the rims of boundaries, the legend, and how many hexahedra are shown."""
    seen = view.surface(look)
    owners = view.owners[seen.rows]
    off = np.array([*(name in hidden for name in view.names), False])
    left = ~off[owners]
    quads, behind, rows, owners = seen.quads[left], seen.behind[left], seen.rows[left], owners[left]
    colors, legend = _colors(view, look, behind, rows)
    surface = colored(surface_of(seen.points, quads), colors)
    rims = [seen.points[pair] for pair in outline_of(quads, owners)] if look.color == "boundary" else []
    return surface, lines_of(rims) if rims else None, legend, seen.n_shown


def outline_of(quads: IntArray, rows: IntArray) -> IntArray:
    """Edges (m, 2) at which boundaries end."""
    found = [outline(quads[rows == row]) for row in np.unique(rows)]
    return np.concatenate(found) if found else np.empty((0, 2), dtype=np.int64)


def _colors(view: MeshView, look: Look, behind: IntArray, rows: IntArray) -> tuple[np.ndarray, dict[str, Any]]:
    """A colour for every quad, and what the colours mean."""
    if look.color in ("solid", "cell", "boundary"):
        if look.color == "boundary":
            names = view.names
            tones = [*mesh_colors(view.mesh), *boundary_colors(len(view.mesh.interfaces))]
            which = view.owners[rows]
        elif look.color == "solid":
            names, tones, which = list(view.mesh.parts), part_colors(view.mesh), view.solid[behind]
        else:
            names = [f"cell {j + 1}" for j in range(view.n_blocks)]
            tones, which = boundary_colors(view.n_blocks), view.cell[behind]
        table = np.array([*map(rgb, tones), _PLAIN], dtype=np.uint8)
        which = np.where(which < 0, len(tones), which)
        rows_shown = [{"name": names[j], "color": tones[j]} for j in np.unique(which) if j < len(tones)]
        return table[which], {"rows": rows_shown[:24], "title": look.color}
    if look.color == "distance" and view.distances is not None:
        values, title = view.distances[rows], "distance from the CAD"
        low, high = 0.0, float(np.nanmax(view.distances))
    elif look.color == "size":
        values, title = view.size[behind], "size"
        low, high = float(view.size.min()), float(view.size.max())
    else:
        values, title, low, high = view.quality[behind], "scaled Jacobian", 0.0, 1.0
    return _mapped(values, low, high, below=title == "scaled Jacobian"), {
        "title": title,
        "low": f"{low:.3g}",
        "middle": f"{(low + high) / 2:.3g}",
        "high": f"{high:.3g}",
        "rows": [],
    }


def _mapped(values: FloatArray, low: float, high: float, *, below: bool) -> np.ndarray:
    from matplotlib import colormaps

    table = (255 * np.array(colormaps["viridis"](np.linspace(0, 1, 256)))[:, :3]).astype(np.uint8)
    with np.errstate(invalid="ignore"):
        at = np.clip((values - low) / max(high - low, 1e-300) * 255, 0, 255)
    colors = table[np.nan_to_num(at).astype(np.int64)]
    if below:
        colors[values <= 0] = _BELOW
    colors[~np.isfinite(values)] = _PLAIN
    return colors


def _figures(view: MeshView, report: Any) -> list[list[str]]:
    mesh = view.mesh
    rows = [["hexahedra", f"{mesh.n_hexes:,} of order {mesh.order}"], ["nodes", f"{mesh.n_nodes:,}"]]
    if report is not None:
        rows += [
            ["worst scaled Jacobian", f"{report.min_scaled_jacobian:.4f}"],
            ["mean", f"{report.mean_scaled_jacobian:.4f}"],
            ["inverted", f"{report.n_inverted:,}"],
        ]
    if mesh.info.get("distance") is not None:
        rows.append(["farthest from the CAD", f"{mesh.info['distance']:.3g}"])
    seconds = sum(mesh.info.get("seconds", {}).values())
    return [*rows, ["seconds", f"{seconds:.2f}"]]


def _place(point: FloatArray) -> str:
    return ", ".join(f"{c:.4g}" for c in point)
