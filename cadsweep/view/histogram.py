"""The histogram of a quality report, over the range of its data.

Place in the flow: called by ``QualityReport.plot``; matplotlib draws it.
"""

from __future__ import annotations

import io
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import CadSweepError, InputError
from ..quality import QualityReport
from .display import can_open_window, in_notebook, write_whole

_SIZE = (6, 3.2)


def plot_report(
    report: QualityReport, *, metric: str = "scaled_jacobian", screenshot: str | PathLike[str] | None = None
) -> Any:
    """Draw how a metric is spread over the hexahedra.

    Parameters
    ----------
    report : QualityReport
    metric : str
        One of ``report.metrics``.
    screenshot : path, optional
        Write a PNG instead of showing a figure; needs no display.

    Returns
    -------
    Path, PIL.Image.Image or None
        Where the picture was written; in a notebook the picture itself, which the cell shows; None after a window was
        closed.

    Raises
    ------
    InputError
        There is no such metric, or the file is no PNG.
    CadSweepError
        matplotlib is not installed, or there is no display to open a window on.
    """
    if metric not in report.metrics:
        raise InputError(f"there is no metric '{metric}'; there are {', '.join(report.metrics)}")
    if screenshot is not None and Path(screenshot).suffix.lower() != ".png":
        raise InputError(f"screenshot must end in .png, not '{screenshot}'")
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise CadSweepError(f'histograms need the extra "view": pip install "cadsweep[view]" ({error})') from error
    if screenshot is None and not in_notebook():
        if not can_open_window():
            raise CadSweepError("there is no display to open a window on; ask for a picture with screenshot='mesh.png'")
        from matplotlib import pyplot

        _draw(pyplot.figure(figsize=_SIZE, layout="constrained"), report, metric)
        pyplot.show()
        return None
    figure = Figure(figsize=_SIZE, layout="constrained")
    _draw(figure, report, metric)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=150 if screenshot is not None else 100)
    if screenshot is not None:
        return write_whole(Path(screenshot), data.getvalue())
    from PIL import Image

    return Image.open(data)


def _draw(figure: Any, report: QualityReport, metric: str) -> None:
    """Bars of a metric, from the first hexahedron to the last, and a line at the worst one."""
    summary = report.metrics[metric]
    used = np.flatnonzero(summary.counts)
    axes = figure.add_subplot()
    axes.bar(summary.edges[:-1], summary.counts, width=np.diff(summary.edges), align="edge", color="#1f5fa8")
    if len(used):  # from the first hexahedron to the last, not over all that the metric could be
        first, last = summary.edges[used[0]], summary.edges[used[-1] + 1]
        margin = 0.03 * (last - first)
        axes.set_xlim(first - margin, last + margin)
    axes.axvline(summary.min if metric == "scaled_jacobian" else summary.max, color="#b3261e", linewidth=1)
    axes.set_xlabel(metric.replace("_", " "))
    axes.set_ylabel("hexahedra")
    axes.set_title(f"{report.n_hexes:,} hexahedra, from {summary.min:.3g} to {summary.max:.3g}", fontsize="medium")
