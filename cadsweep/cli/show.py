"""Tables and lines for people, from the same plain data that ``--json`` prints."""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import count
from typing import Any

import click

from .failure import in_command_words


def mesh_lines(summary: dict[str, Any], output: str, *, verbose: bool = False) -> list[str]:
    """What a written mesh is, in a few lines; `verbose`: with every note."""
    seconds = summary["seconds"]
    lines = [
        f"{output}: {summary['n_hexes']:,} hexes, {summary['n_nodes']:,} nodes",
        f"scaled Jacobian: worst {_number(summary['min_scaled_jacobian'])}, "
        f"mean {_number(summary['mean_scaled_jacobian'])}, inverted {summary['n_inverted']}",
    ]
    if summary["cad_volume"]:
        off = summary["volume"] / summary["cad_volume"] - 1
        lines.append(f"volume: {summary['volume']:.6g}, CAD {summary['cad_volume']:.6g} ({off:+.2%})")
    if summary.get("distance") is not None:
        lines.append(f"boundary: at most {summary['distance']:.3g} off the CAD faces")
    if summary.get("curved_distance") is not None:
        lines.append(f"bent: at most {summary['curved_distance']:.3g} off the curved ones")
    lines += _sweep_lines(summary["sweeps"])
    notes = summary.get("notes", ())
    lines += [f"note: {note}" for note in (notes if verbose else few_notes(notes))]
    for row in summary.get("family", ())[1:]:
        worst = _number(row["min_scaled_jacobian"])
        lines.append(f"{row['file']}: {row['n_hexes']:,} hexes, {row['n_nodes']:,} nodes, worst {worst}")
    if "convergence" in summary:
        lines += ["grid convergence:", *summary["convergence_lines"]]
    if seconds:
        stages = ", ".join(f"{stage} {value:.2f}" for stage, value in seconds.items())
        lines.append(f"seconds: {stages}")
    return lines


def _sweep_lines(sweeps: Sequence[dict[str, Any]]) -> list[str]:
    """How the cells were filled, in the part's own names and numbers; those that are filled alike are one line."""
    solids = {sweep.get("solid") for sweep in sweeps}
    cells = Counter(_filling(sweep, of_several=len(solids) > 1) for sweep in sweeps)
    return [line + (f", {n} cells" if n > 1 else "") for line, n in cells.items()]


def _filling(sweep: dict[str, Any], *, of_several: bool) -> str:
    solid = f"'{sweep['solid']}', " if of_several and "solid" in sweep else ""
    if "corners" in sweep:
        return f"{solid or 'cell: '}a block of hexahedra at each of {sweep['corners']} corners"
    if "columns" in sweep:
        along = f"{solid or 'stack '}along ({sweep['direction']})"
        caps = f"{_names(sweep['source'])} to {_names(sweep['target'])}"
        return f"{along}: {sweep['columns']} columns, {caps}, {sweep['layers']} layers"
    spans = sweep.get("span_layers", [])
    parts = f" ({' + '.join(map(str, spans))})" if len(spans) > 1 else ""
    return f"sweep: {solid}{_names(sweep['source'])} to {_names(sweep['target'])}, {sweep['layers']} layers{parts}"


def _names(caps: Any) -> str:
    return ", ".join(dict.fromkeys(map(str, caps))) if isinstance(caps, list | tuple) else str(caps)


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4f}"


_MENDED = re.compile(r"^(relax|untangle|polish) (.*): worst scaled Jacobian (\S+) to (\S+)$")
_ROLLED_BACK = re.compile(r"^(relax|untangle|polish) .*: rolled back")


def few_notes(notes: Iterable[str]) -> list[str]:
    """One line a kind of note: those that differ in names and numbers are one kind, smoothing another."""
    kinds: dict[str, list[str]] = {}
    before: dict[str, float] = {}
    after: dict[str, float] = {}  # the last step of each place
    for note in notes:
        step = _MENDED.match(note)
        if step is not None:
            before.setdefault(step[2], float(step[3]))
            after[step[2]] = float(step[4])
            kinds.setdefault("smoothing", [])
        elif not _ROLLED_BACK.match(note):
            kinds.setdefault(re.sub(r"'[^']*'|\([^)]*\)|[-+]?\d[\d.e+-]*", "#", note), []).append(note)
    lines = []
    for kind, same in kinds.items():
        if kind == "smoothing":
            places = f"{len(after)} place{'s' * (len(after) > 1)} mended"
            lines.append(f"smoothing: {places}, worst {min(before.values())} -> {min(after.values())}")
        else:
            lines.append(same[0] + (f" (and {len(same) - 1} more like it: -v)" if len(same) > 1 else ""))
    return lines


def print_info(data: dict[str, Any], *, edges: bool = False, verbose: bool = False) -> None:
    """Faces, edges where they are asked for, sweeps found, and why the others are not."""
    console = _console()
    several = len(data["solids"]) > 1
    for note in data["notes"] if verbose else few_notes(data["notes"]):
        console.print(f"note: {note}", markup=False, highlight=False)
    if several:
        rows = ((index, solid["name"], _what_it_can(data, index)) for index, solid in enumerate(data["solids"]))
        console.print(_table("What each solid can do by itself", ("number", "solid", "can"), rows))
    for index, solid in enumerate(data["solids"]):
        faces, sweeps, rejected = (
            [row for row in data[name] if row["solid"] == index] for name in ("faces", "sweeps", "rejected")
        )
        title = f"{solid['name']}{f' ({index + 1})' if several else ''}"
        known = "".join(f", {word} {solid[word]}" for word in ("material", "color") if solid[word])
        line = f"{title}: {len(faces)} faces, volume {solid['volume']:.6g}{known}"
        console.print(line, markup=False, highlight=False)
        colored = ("color",) if any(f["color"] for f in faces) else ()
        columns = ("id", "name", "type", "area", "center", "role", *colored)
        console.print(_table("Faces", columns, (_face_row(f)[: len(columns)] for f in faces)))
        if blends := [row for row in data["blends"] if row["solid"] == index]:
            columns = ("faces", "replaces", "form", "radius", "between")
            console.print(_table("Blends", columns, map(_blend_row, blends)))
        if edges:
            columns = ("id", "name", "type", "length", "middle", "faces", "role")
            rows = (_edge_row(row) for row in data["edges"] if row["solid"] == index)
            console.print(_table("Edges", columns, rows))
        if sweeps:
            columns = ("", "source", "target", "sides", "stations", "length", "score", "notes")
            console.print(_table("Sweeps, best first", columns, (_row(n, s) for n, s in enumerate(sweeps, 1))))
        else:
            console.print(f"No sweep: {in_command_words(solid['error'])}", markup=False, highlight=False)
        _print_stacks(console, data, index, swept=bool(sweeps))
        if not sweeps and not any(row["solid"] == index for row in data["stacks"]):
            line = "'cadsweep mesh' tries to cut it into cells that sweep; 'cadsweep cut' shows them"
            console.print(line, markup=False, highlight=False)
        if rejected and sweeps and not verbose:
            line = f"{len(rejected)} other faces are no caps: -v says why of each"
            console.print(line, markup=False, highlight=False)
        elif rejected:
            reasons = ((row["face"], row["reason"]) for row in rejected)
            console.print(_table("Why the others are no caps", ("face", "reason"), reasons))
    if several:
        touching = (_contact_row(contact) for contact in data["contacts"])
        console.print(
            _table("What touches what", ("solids", "in", "area", "face of the first = of the second"), touching)
        )
        _print_plan(console, data["plan"])


def _what_it_can(data: dict[str, Any], index: int) -> str:
    """What a solid of several can do, in a line."""
    sweeps, stacks = ([row for row in data[name] if row["solid"] == index] for name in ("sweeps", "stacks"))
    if sweeps:
        more = f", and {len(sweeps) - 1} other sweeps" if len(sweeps) > 1 else ""
        return f"sweep from {_names(sweeps[0]['source'])} to {_names(sweeps[0]['target'])}{more}"
    if stacks:
        return f"columns along {', '.join(f'{c:.3g}' for c in stacks[0]['direction'])}"
    return f"neither sweep nor columns, cuts are tried: {in_command_words(data['solids'][index]['error'])}"


def _print_plan(console: Any, plan: dict[str, Any]) -> None:
    """The sweeps of solids that touch, in the order in which they are meshed."""
    for reason in plan["refused"]:
        console.print(f"No plan: {reason}", markup=False, highlight=False)
    if plan["cells"]:
        columns = ("", "solid", "source", "target", "contacts")
        console.print(_table("Plan, in the order of meshing", columns, map(_plan_row, plan["cells"], count(1))))
    if plan["alone"]:
        console.print(f"By themselves: {', '.join(plan['alone'])}", markup=False, highlight=False)


def _plan_row(cell: dict[str, Any], number: int) -> tuple[Any, ...]:
    contacts = ", ".join(
        f"{role} on {'a cut' if other == cell['solid'] else other}" for other, role in cell["contacts"]
    )
    caps = [", ".join(cell[end]) or "blocks at corners" for end in ("source", "target")]
    return number, cell["solid"], *caps, contacts


def _contact_row(contact: dict[str, Any]) -> tuple[Any, ...]:
    what = {"face": "faces", "edge": "an edge alone", "vertex": "a point alone"}[contact["kind"]]
    faces = ", ".join(f"{first} = {second}" for first, second in contact["faces"])
    return " and ".join(contact["solids"]), what, f"{contact['area']:.6g}" if contact["faces"] else "", faces


def _print_stacks(console: Any, data: dict[str, Any], index: int, *, swept: bool) -> None:
    """The directions along which a solid is a stack of columns; where it has no sweep either, why the best is none."""
    stacks, reasons = ([row for row in data[name] if row["solid"] == index] for name in ("stacks", "no_stacks"))
    if stacks:
        columns = ("", "direction", "source", "target", "walls", "levels", "cells", "columns", "score")
        rows = (_stack_row(number, row) for number, row in enumerate(stacks, 1))
        console.print(_table("Stacks of columns between caps, best first", columns, rows))
    elif reasons and not swept:
        console.print(f"No stack of columns: {reasons[0]['reason']}", markup=False, highlight=False)


def _stack_row(number: int, row: dict[str, Any]) -> tuple[Any, ...]:
    return (
        number,
        ", ".join(f"{c:.3g}" for c in row["direction"]),
        _names(row["source"]),
        _names(row["target"]),
        row["n_walls"],
        ", ".join(f"{height:.4g}" for height in row["levels"]),
        row["n_cells"],
        row["n_columns"],
        f"{row['score']:.2f}",
    )


def _face_row(face: dict[str, Any]) -> tuple[Any, ...]:
    return (
        face["id"],
        ", ".join([face["name"], *face["groups"]]),
        face["type"],
        f"{face['area']:.6g}",
        _place(face["center"]),
        face["role"],
        face["color"] or "",
    )


def _row(number: int, sweep: dict[str, Any]) -> tuple[Any, ...]:
    return (
        number,
        _names(sweep["source"]),
        _names(sweep["target"]),
        sweep["n_linking_sides"],
        sweep["n_stations"],
        f"{sweep['length']:.6g}",
        f"{sweep['score']:.2f}",
        "; ".join(sweep["notes"]),
    )


def _blend_row(blend: dict[str, Any]) -> tuple[Any, ...]:
    low, high = (f"{radius:.4g}" for radius in blend["radii"])
    return (
        ", ".join(map(str, blend["faces"])),
        f"a{'n edge' if blend['kind'] == 'edge' else ' corner'}",
        "convex" if blend["convex"] else "concave",
        low if low == high else f"{low} to {high}",
        " and ".join(", ".join(map(str, side)) for side in blend["supports"]),
    )


def _edge_row(edge: dict[str, Any]) -> tuple[Any, ...]:
    length, middle = f"{edge['length']:.6g}", _place(edge["middle"])
    return edge["id"], edge["name"], edge["type"], length, middle, _names(edge["faces"]), edge["role"]


def _place(center: list[float]) -> str:
    """Coordinates to four digits; what is rounding beside the largest of them is zero."""
    noise = 1e-9 * max(map(abs, center))
    return ", ".join(f"{0.0 if abs(c) <= noise else c:.4g}" for c in center)


def _console() -> Any:
    from rich.console import Console

    # In a pipe nothing is cut off: the width of a terminal means nothing there.
    return Console() if sys.stdout.isatty() else Console(width=200)


def _table(title: str, columns: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Any:
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", title_style="bold")
    for column in columns:
        table.add_column(
            column,
            justify="right" if column in ("id", "face", "area", "length", "score", "sides", "stations") else "left",
        )
    for row in rows:
        table.add_row(*(Text(str(cell)) for cell in row))
    return table


def announce(summary: dict[str, Any], output: str, *, as_json: bool, quiet: bool, verbose: bool = False) -> None:
    """Print what was made, for people or for programs."""
    if as_json:
        click.echo(json.dumps({**{k: v for k, v in summary.items() if k != "convergence_lines"}, "file": output}))
    elif not quiet:
        click.echo("\n".join(mesh_lines(summary, output, verbose=verbose)))
