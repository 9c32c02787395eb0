"""Tables and lines for people, from the same plain data that ``--json`` prints."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any


def mesh_lines(summary: dict[str, Any], output: str) -> list[str]:
    """What a written mesh is, in a few lines."""
    seconds = summary["seconds"]
    lines = [
        f"{output}: {summary['n_hexes']:,} hexes, {summary['n_nodes']:,} nodes",
        f"scaled Jacobian: worst {_number(summary['min_scaled_jacobian'])}, "
        f"mean {_number(summary['mean_scaled_jacobian'])}, inverted {summary['n_inverted']}",
    ]
    if summary["cad_volume"]:
        off = summary["volume"] / summary["cad_volume"] - 1
        lines.append(f"volume: {summary['volume']:.6g}, CAD {summary['cad_volume']:.6g} ({off:+.2%})")
    for sweep in summary["sweeps"]:
        lines.append(f"sweep: {_names(sweep['source'])} to {_names(sweep['target'])}, {sweep['layers']} layers")
    lines += [f"note: {note}" for note in summary.get("notes", ())]
    if seconds:
        stages = ", ".join(f"{stage} {value:.2f}" for stage, value in seconds.items())
        lines.append(f"seconds: {stages}")
    return lines


def _names(caps: Any) -> str:
    return ", ".join(map(str, caps)) if isinstance(caps, list | tuple) else str(caps)


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4f}"


def print_info(data: dict[str, Any]) -> None:
    """Faces, sweeps found, and why the others are not."""
    console = _console()
    console.print(f"[bold]{_escape(data['name'])}[/]: {_solids(data['solids'])}", highlight=False)
    for note in data["notes"]:
        console.print(f"  {note}", markup=False, highlight=False)
    for solid in data["solids"]:
        console.print(
            _table(
                f"Faces of {solid['name']}" if len(data["solids"]) > 1 else "Faces",
                ("id", "name", "type", "area", "role", "center"),
                (
                    (f["id"], f["name"] or "", f["type"], f"{f['area']:.6g}", f["role"], _place(f["center"]))
                    for f in solid["faces"]
                ),
            )
        )
        if solid["sweeps"]:
            console.print(
                _table(
                    "Sweeps, best first",
                    ("", "source", "target", "sides", "score", "notes"),
                    (
                        (
                            n,
                            _names(s["source"]),
                            _names(s["target"]),
                            s["n_sides"],
                            f"{s['score']:.2f}",
                            "; ".join(s["notes"]),
                        )
                        for n, s in enumerate(solid["sweeps"], 1)
                    ),
                )
            )
        else:
            console.print(f"[bold]No sweep[/]: {_escape(solid['error'])}", highlight=False)
        if solid["rejected"]:
            console.print("\n[bold]Why the others are not[/]")
            for reason in solid["rejected"]:
                console.print(f"  {reason}", markup=False, highlight=False)


def _solids(solids: list[dict[str, Any]]) -> str:
    return ", ".join(f"{len(s['faces'])} faces, volume {s['volume']:.6g}" for s in solids) or "no solid"


def _place(center: Iterable[float]) -> str:
    return ", ".join(f"{float(f'{c:.4g}') + 0.0:g}" for c in center)


def _escape(text: str) -> str:
    from rich.markup import escape

    return escape(text)


def _console() -> Any:
    from rich.console import Console

    # In a pipe nothing is cut off: the width of a terminal means nothing there.
    return Console() if sys.stdout.isatty() else Console(width=200)


def _table(title: str, columns: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Any:
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", title_style="bold")
    for column in columns:
        table.add_column(column, justify="right" if column in ("id", "area", "score") else "left")
    for row in rows:
        table.add_row(*(Text(str(cell)) for cell in row))
    return table
