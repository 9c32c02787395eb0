"""A sweep as two small factors: any layer, any slab, any time.

Place in the flow: what :func:`project_layers` returns, and what the pipeline, the streaming writers and ``expand`` make
nodes from.

Method: ``points[k] = basis @ coefficients[k]``, written straight into the result (:mod:`.kernels`); the boundary nodes
are overwritten with the rings, bit for bit, while their layer is still in the cache. A layer has the same bits in every
slab.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike

import numpy as np

from ..arrays import FloatArray, IntArray, small_ints
from ..errors import InputError
from . import kernels, storage

_SLAB_BYTES = 1 << 20
"""Points that are made at a time: about what the second cache holds."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FactoredSweep:
    """All nodes of a sweep: ``points[k, i] = sum_j basis[i, j] * coefficients[k, j]``, boundary nodes from the rings.

    Attributes
    ----------
    basis : (n_nodes, r) float64
        Columns: position relative to the source centre (n), 1, position relative to the target centre (n, strategy
        "both" alone), residual modes.
    coefficients : (n_layers + 1, r, n) float64
    rings : (n_layers + 1, b, n) float64
    loops : tuple of int64 arrays
    quads : (q, 4) int64
    source_points : (n_nodes, n) float64
        Layer 0.
    target_points : (n_nodes, n) float64 or None
        Layer n_layers, where given.
    source_center, target_center : (n,) float64, or None
        Centres of the caps' rings that the basis refers to; the target's where the strategy uses it.
    ranks, conditions : (n_layers + 1,) arrays
        Of each layer's least-squares system; the worse of both caps' for "both". Entry 0 of "advancing" is of
        ring 0 on itself.
    weights : (n_layers + 1,) float64
        Share of the target cap in each layer.
    n_modes : int
        Residual modes among the columns of `basis`.
    remainder : float
        Greatest distance between a ring node and its image, modes included.
    functional, strategy : str

    Examples
    --------
    >>> import numpy as np
    >>> from cadsweep.projection import project_layers
    >>> source = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0.5]])  # the middle stands up
    >>> quads = [[0, 1, 4, 3], [1, 2, 3, 4]]
    >>> heights = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2]])
    >>> rings = source[:4] + heights[:, None]
    >>> sweep = project_layers(source, quads, rings, loops=[[0, 1, 2, 3]], strategy="source")
    >>> sweep.points().shape, sweep.n_layers
    ((3, 5, 3), 2)
    >>> bool((sweep.points(slice(1, 3))[1] == sweep.layer(2)).all())
    True
    """

    basis: FloatArray
    coefficients: FloatArray
    rings: FloatArray
    loops: tuple[IntArray, ...]
    quads: IntArray
    source_points: FloatArray
    source_center: FloatArray
    target_points: FloatArray | None = None
    target_center: FloatArray | None = None
    ranks: IntArray
    conditions: FloatArray
    weights: FloatArray
    n_modes: int = 0
    remainder: float = 0.0
    functional: str = "H"
    strategy: str = "source"
    ring_nodes: IntArray = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ring_nodes", np.concatenate(self.loops))

    @property
    def n_layers(self) -> int:
        """Number of hexahedra along the sweep; there is one layer of nodes more."""
        return len(self.rings) - 1

    @property
    def n_nodes(self) -> int:
        """Nodes of one layer."""
        return len(self.basis)

    def layer(self, k: int) -> FloatArray:
        """Return the nodes (n_nodes, n) of layer `k`, counted from the end where negative.

        Raises
        ------
        IndexError
            There is no such layer.
        """
        n_node_layers = len(self.rings)
        if not -n_node_layers <= k < n_node_layers:
            raise IndexError(f"layer {k} of {n_node_layers} node layers")
        k = int(k) % n_node_layers
        return self.points(slice(k, k + 1))[0]

    def points(self, layers: slice = slice(None), out: FloatArray | None = None) -> FloatArray:
        """Return the nodes of a run of layers.

        Parameters
        ----------
        layers : slice
            Node layers, as a slice of ``range(n_layers + 1)``.
        out : (len(layers), n_nodes, n) float64, optional
            Filled and returned where given.

        Returns
        -------
        (len(layers), n_nodes, n) float64

        Raises
        ------
        InputError
            `out` has another shape or type, or is read-only.
        """
        if not isinstance(layers, slice):
            raise InputError(f"`layers` is a slice of node layers, not {layers!r}; for a single layer call layer(k)")
        chosen = np.arange(len(self.rings))[layers]
        shape = (len(chosen), *self.source_points.shape)
        if out is None:
            out = np.empty(shape)
        elif not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != np.float64:
            found = f"{out.shape}, {out.dtype}" if isinstance(out, np.ndarray) else type(out).__name__
            raise InputError(f"`out` is {found}; wanted a float64 array of shape {shape}")
        elif not out.flags.writeable:
            raise InputError("`out` is read-only")
        if not len(chosen):
            return out
        if shape[2] == 3 and out.flags.c_contiguous:
            kernels.place(self._packed, self.coefficients[layers], self.ring_nodes, self.rings[layers], out)
        elif shape[2] == 3:
            # A view with gaps: through a few layers of contiguous memory, so that the bits stay the same.
            step = max(1, _SLAB_BYTES // self.source_points.nbytes)
            for start in range(0, len(chosen), step):
                ks = chosen[start : start + step]
                slab = np.empty((len(ks), *shape[1:]))
                kernels.place(self._packed, self.coefficients[ks], self.ring_nodes, self.rings[ks], slab)
                out[start : start + step] = slab
        else:
            np.matmul(self.basis, self.coefficients[layers], out=out)
            out[:, self.ring_nodes] = self.rings[layers]
        self._finish(out, chosen)
        return out

    @cached_property
    def _packed(self) -> FloatArray:
        return kernels.pack(self.basis)

    def _finish(self, slab: FloatArray, ks: IntArray) -> None:
        """Put on a slab what the product does not know: the caps."""
        for j in np.flatnonzero(ks == 0).tolist():
            slab[j] = self.source_points
        if self.target_points is not None:
            for j in np.flatnonzero(ks == self.n_layers).tolist():
                slab[j] = self.target_points

    def save(self, path: str | PathLike[str]) -> None:
        """Write a compressed ``.npz`` at exactly `path`, from which :func:`load` makes the same points, bit for bit.

        Of the basis only the residual modes and the caps' centres are written; the rest follows from the caps.
        """
        storage.write(self.to_arrays(), path)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> FactoredSweep:
        """Read what :meth:`save` wrote.

        Raises
        ------
        InputError
            The file is not one of ours, or is damaged.
        """
        try:
            return cls.of_arrays(storage.read(path))
        except KeyError as error:
            raise InputError(f"{path}: the array {error} is missing") from error

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays from which :meth:`of_arrays` makes the same sweep again."""
        n = self.source_points.shape[1]
        # The first columns of the basis are cap points minus a centre; the centre is the ring's own mean, kept as bits.
        arrays = {
            "format": np.array(storage.FORMAT),
            "source_points": self.source_points,
            "source_center": self.source_center,
            "quads": small_ints(self.quads),
            "ring_nodes": small_ints(self.ring_nodes),
            "loop_lengths": np.array([len(loop) for loop in self.loops]),
            "rings": self.rings,
            "coefficients": self.coefficients,
            "modes": self.basis[:, self.basis.shape[1] - self.n_modes :],
            "ranks": self.ranks,
            "conditions": self.conditions,
            "weights": self.weights,
            "remainder": np.array(self.remainder),
            "functional": np.array(self.functional),
            "strategy": np.array(self.strategy),
        }
        if self.target_points is not None:
            arrays["target_points"] = self.target_points
        if self.target_center is not None:
            arrays["target_center"] = self.target_center
        assert n in (2, 3)
        return arrays

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, np.ndarray]) -> FactoredSweep:
        """The sweep whose :meth:`to_arrays` these are; a KeyError names one that is missing."""
        ends = np.cumsum(arrays["loop_lengths"])
        target, target_center = arrays.get("target_points"), arrays.get("target_center")
        modes = arrays["modes"]
        return cls(
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


def make_basis(
    source_points: FloatArray,
    source_center: FloatArray,
    target_points: FloatArray | None,
    target_center: FloatArray | None,
    modes: FloatArray,
) -> FloatArray:
    """Join the columns of the basis; the one place where their order is written down."""
    columns = [source_points - source_center, np.ones((len(source_points), 1))]
    if target_points is not None and target_center is not None:
        columns.append(target_points - target_center)
    columns.append(modes)
    return np.ascontiguousarray(np.concatenate(columns, axis=1))
