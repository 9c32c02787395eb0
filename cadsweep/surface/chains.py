"""Edges one after another that are one edge to the user: graded as one, whatever counts its pieces get.

Place in the flow: ``pipeline`` finds the pieces that cuts, contacts and columns make of an edge. :meth:`Chain.shares`
says how many of the segments each should get, for the integer programme; when the counts are known, :func:`divided`
divides all pieces together.

Method: the logarithms of the segments' lengths differ as little as can be, from one segment to the next, from those of
the edge graded as a whole, under the condition that the segments of a piece fill it, and that the ratio (or the first
length) is kept: by steps that each solve the linearised equations, which are sparse.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..errors import InputError, SurfaceMeshError
from .background import GROWTH
from .grading import Division, fractions_from, graded_fractions, turned_round

_FINE = 1000
"""Steps by which the division of a whole edge is known between its pieces."""
_PASSES = 60
_CLOSED = 1e-11
"""Error of logarithms of lengths at which the equations are solved."""
_STEADY = 1e-3
"""Weight of the lengths themselves against that of their changes: it makes the solution one."""
_LEAST_STEP = 1e-3
_FITS = float(np.log(1.5))
"""Logarithm of a length over the wanted one up to which a piece of one segment can hold a ratio."""
_KEPT = 1.1
"""Factor between what is asked for and what is had from which on it is said."""


_STEEP = 2.0
"""Growth from one segment to the next that is said: whoever asks for a first length seldom means it."""
_MOST_TRIED = 400
"""Segments of an edge up to which a number is looked for that grows gently."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chain:
    """An edge in pieces, and how it is graded.

    Attributes
    ----------
    edges : tuple of (int, bool)
        Ids or keys from one end to the other, and whether they run along.
    lengths : tuple of float
    fine : (bool, bool)
        Whether segments are short at the beginning, and at the end; neither: in the middle.
    ratio : float or None
        Longest segment over shortest.
    share : float or None
        Length of the shortest over that of the whole edge, instead.
    first : float or None
        That length, model units, for messages.
    label : str
        The edge, for messages.
    """

    edges: tuple[tuple[int, bool], ...]
    lengths: tuple[float, ...]
    fine: tuple[bool, bool]
    ratio: float | None = None
    share: float | None = None
    first: float | None = None
    label: str = ""

    def whole(self, n: int) -> FloatArray:
        """Fractions (n + 1,) of the edge in n segments, if it were in one piece.

        Raises
        ------
        InputError
            No n segments begin with the share that is asked for.
        """
        if self.share is None:
            assert self.ratio is not None, "one of the two is asked for"
            start, end = (self.ratio if fine else 1.0 for fine in self.fine)
            if self.fine == (False, False):
                start = end = 1.0 / self.ratio
            return graded_fractions(n, start=start, end=end)
        try:
            fractions = fractions_from(n, self.share, both=all(self.fine))
        except SurfaceMeshError as error:
            raise InputError(
                f"{self.label} gets {n} segments, of which the first cannot be {self.first:g} long ({error}): ask for "
                "another count or size there"
            ) from error
        return fractions if self.fine[0] else turned_round(fractions)

    def shares(self, n: float) -> FloatArray:
        """Parts (pieces,) of all n segments that each piece should get."""
        try:
            whole = self.whole(_FINE if self.share is None else max(1, round(n)))
        except InputError:  # said where the counts are known
            return np.array(self.lengths) / sum(self.lengths)
        return np.diff(np.interp(self._ends(), whole, np.linspace(0.0, 1.0, len(whole))))

    def divide(self, counts: Mapping[int, int]) -> tuple[list[FloatArray], float]:
        """Fractions (n + 1,) of every piece, in its own edge's way; and the factor by which what is asked is off."""
        own = np.array([counts[e] for e, _ in self.edges], dtype=np.int64)
        lengths = np.array(self.lengths)
        wanted = np.log(np.diff(self.whole(int(own.sum()))) * lengths.sum())
        ties = self._ties(wanted, own)
        logs = _fitted(wanted, own, lengths, ties)
        if logs is None:  # pieces of one segment have their length
            logs = _fitted(wanted, own, lengths, [])
            assert logs is not None, "lengths alone can be met"
        pieces = []
        for (_, forward), row in zip(self.edges, np.split(np.exp(logs), np.cumsum(own)[:-1]), strict=True):
            fractions = np.concatenate([[0.0], np.cumsum(row)]) / row.sum()
            fractions[-1] = 1.0
            pieces.append(fractions if forward else turned_round(fractions))
        least = np.ptp(wanted) - np.ptp(logs) if self.share is None else wanted.min() - logs.min()
        return pieces, float(np.exp(abs(least)))

    def portion(self, place: int, n: int) -> FloatArray:
        """Fractions of a piece, in its own way, as if all others had the segments that go with n of it."""
        if len(self.edges) == 1:
            whole = self.whole(n)
            return whole if self.edges[place][1] else turned_round(whole)
        begin, end = self._ends()[place : place + 2]
        whole = self.whole(_FINE if self.share is None else max(2, round(n / (end - begin))))
        at = np.linspace(0.0, 1.0, len(whole))
        first, last = np.interp([begin, end], whole, at)
        fractions = (np.interp(np.linspace(first, last, n + 1), at, whole) - begin) / (end - begin)
        fractions[0], fractions[-1] = 0.0, 1.0
        return fractions if self.edges[place][1] else turned_round(fractions)

    def _ends(self) -> FloatArray:
        run = np.concatenate([[0.0], np.cumsum(self.lengths)]) / sum(self.lengths)
        run[-1] = 1.0
        return run

    def _ties(self, wanted: FloatArray, counts: IntArray) -> list[_Tie]:
        """What must hold between single segments: (one, other or -1, logarithm of one over other).

        A piece of one segment has its length. Where that is far from what is wanted, what would hold for it holds for
        the nearest segment that has a choice.
        """
        given = np.repeat(self.lengths, counts)
        fits = np.abs(np.log(given) - wanted) < _FITS
        several = np.repeat(counts > 1, counts)
        free = np.flatnonzero(several | fits) if several.any() else np.arange(0)
        if not len(free):
            return []
        n = len(wanted)
        ends = [j for j, fine in zip((0, n - 1), self.fine, strict=True) if fine]
        far = n // 2 if len(ends) != 1 else n - 1 - ends[0]
        nearest = {j: int(free[np.argmin(np.abs(free - j))]) for j in (0, far, n - 1)}
        if self.share is not None:
            return [(nearest[j], -1, float(np.log(self.share * sum(self.lengths)))) for j in ends]
        pairs = {(nearest[j], nearest[far]): float(wanted[j] - wanted[far]) for j in ends or (0, n - 1) if j != far}
        return [(one, other, ratio) for (one, other), ratio in pairs.items() if one != other]


_Tie = tuple[int, int, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class ChainPiece:
    """The division of one piece of a chain: by n alone as if the others had their shares, or by :func:`divided`."""

    chain: Chain
    place: int
    turned: bool = False

    def __call__(self, n: int) -> FloatArray:
        """Fractions (n + 1,) by the piece's own count."""
        found = self.chain.portion(self.place, n)
        return turned_round(found) if self.turned else found


def divided(divisions: Mapping[int, Division], counts: Mapping[int, int]) -> dict[int, FloatArray]:
    """Fractions of edges from their counts, the pieces of a chain together."""
    done: dict[int, list[FloatArray]] = {}
    found = {}
    for edge, division in divisions.items():
        if not isinstance(division, ChainPiece) or any(e not in counts for e, _ in division.chain.edges):
            found[edge] = division(counts[edge])
            continue
        chain = division.chain
        if id(chain) not in done:
            done[id(chain)] = chain.divide(counts)[0]
        own = done[id(chain)][division.place]
        found[edge] = turned_round(own) if division.turned else own
    return found


def turned(division: Division) -> Division:
    """The same division of an edge that runs the other way."""
    if isinstance(division, ChainPiece):
        return replace(division, turned=not division.turned)
    return partial(_turned, division)


def _turned(division: Division, n: int) -> FloatArray:
    return turned_round(division(n))


def chains_of(divisions: Mapping[int, Division]) -> list[Chain]:
    """The chains that divisions belong to, each once."""
    found = {id(own.chain): own.chain for own in divisions.values() if isinstance(own, ChainPiece)}
    return list(found.values())


def say_chains(chains: Iterable[Chain], counts: Mapping[int, int]) -> list[str]:
    """Notes on chains whose counts do not allow what is asked of them, and on the one whose segments grow fastest."""
    notes = []
    steepest, steep = _STEEP, ""
    for chain in chains:
        if any(e not in counts for e, _ in chain.edges):
            continue
        off = chain.divide(counts)[1]
        if len(chain.edges) > 1 and off > _KEPT:
            each = ", ".join(str(counts[e]) for e, _ in chain.edges)
            asked = "ratio" if chain.share is None else "first length"
            notes.append(
                f"biases: {chain.label} is in {len(chain.edges)} pieces of {each} segments here, too few in some: the "
                f"{asked} asked for is off by a factor of {off:.3g}, take a smaller size"
            )
        n = sum(counts[e] for e, _ in chain.edges)
        growth = _growth(chain.whole(n)) if chain.share is not None and n > 1 else 1.0
        if growth > steepest:
            enough = next((m for m in range(n + 1, _MOST_TRIED) if _grows_gently(chain, m)), None)
            advice = "take a smaller size" if enough is None else f"{enough} of them (counts) would make that {GROWTH}"
            steepest = growth
            steep = f"biases: the {n} segments of {chain.label} grow by {growth:.2g} from one to the next: {advice}"
    return [*notes, steep] if steep else notes


def _grows_gently(chain: Chain, n: int) -> bool:
    try:
        return _growth(chain.whole(n)) <= GROWTH
    except InputError:  # the first is too long for as many
        return True


def _growth(fractions: FloatArray) -> float:
    """Greatest ratio of segments beside each other."""
    lengths = np.diff(fractions)
    ratios = lengths[1:] / lengths[:-1]
    return float(np.maximum(ratios, 1.0 / ratios).max())


def _fitted(wanted: FloatArray, counts: IntArray, lengths: FloatArray, ties: list[_Tie]) -> FloatArray | None:
    """Logarithms (n,) of lengths that fill the pieces and keep the ties; None where there are none."""
    n, m = len(wanted), len(counts)
    of = np.repeat(np.arange(m), counts)
    at = np.arange(n - 1)
    steps = scipy.sparse.csr_array(
        (np.tile([-1.0, 1.0], n - 1), (np.repeat(at, 2), np.column_stack([at, at + 1]).ravel())), shape=(n - 1, n)
    )
    hessian = steps.T @ steps + scipy.sparse.csr_array((np.full(n, _STEADY / n), (np.arange(n), np.arange(n))))
    entries = [(row, j, sign) for row, tie in enumerate(ties) for j, sign in ((tie[0], 1.0), (tie[1], -1.0)) if j >= 0]
    row, column, sign = np.array(entries, dtype=float).reshape(-1, 3).T
    tie_rows = scipy.sparse.csr_array((sign, (row.astype(np.int64), column.astype(np.int64))), shape=(len(ties), n))
    asked = np.array([tie[2] for tie in ties])

    def missing(logs: FloatArray) -> FloatArray:
        filled = np.bincount(of, np.exp(logs), minlength=m) / lengths
        return np.concatenate([np.log(filled), tie_rows @ logs - asked])

    logs = wanted - missing(wanted)[:m][of]
    for _ in range(_PASSES):
        off = missing(logs)
        if np.abs(off).max() < _CLOSED:
            return logs
        each = np.exp(logs)
        shares = each / np.bincount(of, each, minlength=m)[of]
        rows = scipy.sparse.vstack([scipy.sparse.csr_array((shares, (of, np.arange(n))), shape=(m, n)), tie_rows])
        system = scipy.sparse.bmat([[hessian, rows.T], [rows, None]], format="csc")
        try:
            step = scipy.sparse.linalg.splu(system).solve(np.concatenate([hessian @ (wanted - logs), -off]))[:n]
        except RuntimeError:  # singular: ties between segments whose lengths are given
            return None
        if not np.isfinite(step).all():
            return None
        share = 1.0
        while share > _LEAST_STEP and np.abs(missing(logs + share * step)).max() >= np.abs(off).max():
            share *= 0.5
        logs = logs + share * step
    return None
