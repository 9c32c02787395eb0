"""A factored sweep as a file of a few megabytes: arrays in a compressed ``.npz``, nothing that follows from the rest.

Place in the flow: :meth:`FactoredSweep.save` and :meth:`FactoredSweep.load`.
"""

from __future__ import annotations

import zipfile
from os import PathLike

import numpy as np

from ..arrays import small_ints
from ..errors import InputError
from .factored import FactoredSweep, make_basis

FORMAT = "cadsweep factored sweep 2"


def save_sweep(sweep: FactoredSweep, path: str | PathLike[str]) -> None:
    """Write `sweep` at exactly `path`."""
    with open(path, "wb") as file:
        np.savez_compressed(file, **sweep_arrays(sweep))  # type: ignore[arg-type]


def sweep_arrays(sweep: FactoredSweep) -> dict[str, np.ndarray]:
    """Arrays from which :func:`sweep_of_arrays` makes the same sweep again."""
    n = sweep.source_points.shape[1]
    # The first columns of the basis are cap points minus a centre; the centre is the ring's own mean, kept as bits.
    arrays = {
        "format": np.array(FORMAT),
        "source_points": sweep.source_points,
        "source_center": sweep.source_center,
        "quads": small_ints(sweep.quads),
        "ring_nodes": small_ints(sweep.ring_nodes),
        "loop_lengths": np.array([len(loop) for loop in sweep.loops]),
        "rings": sweep.rings,
        "coefficients": sweep.coefficients,
        "modes": sweep.basis[:, sweep.basis.shape[1] - sweep.n_modes :],
        "ranks": sweep.ranks,
        "conditions": sweep.conditions,
        "weights": sweep.weights,
        "remainder": np.array(sweep.remainder),
        "functional": np.array(sweep.functional),
        "strategy": np.array(sweep.strategy),
    }
    if sweep.target_points is not None:
        arrays["target_points"] = sweep.target_points
    if sweep.target_center is not None:
        arrays["target_center"] = sweep.target_center
    assert n in (2, 3)
    return arrays


def load_sweep(path: str | PathLike[str]) -> FactoredSweep:
    """Read what :func:`save_sweep` wrote."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as a factored sweep ({error})") from error
    if str(arrays.get("format")) != FORMAT:
        raise InputError(f"{path}: not a factored sweep of this version (wanted {FORMAT!r})")
    try:
        return sweep_of_arrays(arrays)
    except KeyError as error:
        raise InputError(f"{path}: the array {error} is missing") from error


def sweep_of_arrays(arrays: dict[str, np.ndarray]) -> FactoredSweep:
    ends = np.cumsum(arrays["loop_lengths"])
    target, target_center = arrays.get("target_points"), arrays.get("target_center")
    modes = arrays["modes"]
    return FactoredSweep(
        basis=make_basis(arrays["source_points"], arrays["source_center"], target, target_center, modes),
        coefficients=arrays["coefficients"],
        rings=arrays["rings"],
        loops=tuple(np.split(arrays["ring_nodes"].astype(np.int64), ends[:-1])),
        quads=arrays["quads"].astype(np.int64),
        source_points=arrays["source_points"],
        source_center=arrays["source_center"],
        target_points=target,
        target_center=target_center,
        ranks=arrays["ranks"],
        conditions=arrays["conditions"],
        weights=arrays["weights"],
        n_modes=modes.shape[1],
        remainder=float(arrays["remainder"]),
        functional=str(arrays["functional"]),
        strategy=str(arrays["strategy"]),
    )
