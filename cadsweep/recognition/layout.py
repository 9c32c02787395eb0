"""Layouts: bands joined so that exactly two caps remain.

Place in the flow: third step of :mod:`cadsweep.recognition`. Bands that share no face can belong
to one sweep: the outer sides and the walls of every hole, and bands that follow each other along
the sweep, with a station between them. The faces outside all chosen bands fall into connected
groups. Where two groups remain and every chain of bands leads from one to the other, they are the
caps.

A band that leads to a flat imprint in a cap is given up for it, and one that is a plane around a hole where no
second cap is left; bands that close to a cycle (a
ring whose every face is a rectangle) are opened at the two best places.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations
from math import pi
from statistics import median

from ..brep import Solid
from ..errors import NotSweepableError
from .bands import Band
from .ends import across, ends_of, without_partial_ends

FLAT = 0.03
"""Radians from pi below which two faces in a row count as one plane."""
SHALLOW = pi / 4
"""Radians from pi below which a band beside a group of faces may be taken for a part of a cap."""
MAX_CYCLE = 12
"""Bands of a cycle at most: pairs of them are tried, 66 of 12."""

ALIKE = 1.5
"""Ratio of the lengths of rails up to which two bands cross a sheet of one thickness."""

End = tuple[int, int]
"""A band's index and its side: 0 at the bottom, 1 at the top."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Layout:
    """Two caps and the chains of bands between them.

    Attributes
    ----------
    caps : two tuples of int
        Face ids.
    chains : tuple of tuple of (Band, dict)
        For every loop the bands from the first cap to the second; the dict gives, for every face,
        the chain of its reading that lies towards the first cap.
    """

    caps: tuple[tuple[int, ...], tuple[int, ...]]
    chains: tuple[tuple[tuple[Band, dict[int, int]], ...], ...]


def choose_bands(bands: Sequence[Band]) -> Iterator[list[Band]]:
    """Yield, for every band, the bands that can share a sweep with it (it comes first), each set once."""
    conflicts = _conflicts(bands)
    order = sorted(range(len(bands)), key=lambda i: (len(conflicts[i]), bands[i].cost, i))
    seen: set[frozenset[int]] = set()
    settled: set[int] = set()
    for i in range(len(bands)):
        if i in settled:
            continue
        excluded = set(conflicts[i])
        chosen = [i]
        for j in order:
            if j not in excluded:
                chosen.append(j)
                excluded |= conflicts[j]
        # a band that all bands outside the set conflict with can only give the same set again
        settled |= {j for j in chosen if len(conflicts[j]) - 1 == len(bands) - len(chosen)}
        key = frozenset(chosen)
        if key not in seen:
            seen.add(key)
            yield [bands[j] for j in chosen]


def choose_sheets(solid: Solid, bands: Sequence[Band]) -> Iterator[list[Band]]:
    """Yield, for every band, those across a sheet of one thickness: with rails about as long as its own, each set once.

    The faces of a bent or drawn sheet's two skins close to rings as well, which :func:`choose_bands` takes for
    linking sides wherever they can follow each other. Those of an embossing may be as long as the sheet is thick:
    laid out with `steepest` = pi they are parts of the skins.
    """
    conflicts = _conflicts(bands)
    lengths = [median(solid.edges[e].length for e in band.rails) for band in bands]
    order = sorted(range(len(bands)), key=lambda j: (bands[j].cost, j))
    seen: set[frozenset[int]] = set()
    for i in sorted(range(len(bands)), key=lengths.__getitem__):
        chosen = [i]
        for j in order:
            alike = max(lengths[i], lengths[j]) < ALIKE * min(lengths[i], lengths[j])
            if alike and not conflicts[j].intersection(chosen):
                chosen.append(j)
        if frozenset(chosen) not in seen:
            seen.add(frozenset(chosen))
            yield [bands[j] for j in chosen]


def _conflicts(bands: Sequence[Band]) -> list[set[int]]:
    """For every band those that share a face with it, itself included."""
    users: dict[int, list[int]] = {}
    for i, band in enumerate(bands):
        for f in band.faces:
            users.setdefault(f, []).append(i)
    conflicts: list[set[int]] = [set() for _ in bands]
    for who in users.values():
        for i in who:
            conflicts[i].update(who)
    return conflicts


def lay_out(solid: Solid, bands: Sequence[Band], *, steepest: float = SHALLOW) -> list[Layout]:
    """Join bands to layouts; one that leads to a face of its own, by no more than an angle, may be a part of a cap.

    Raises
    ------
    NotSweepableError
        There is none; the message is the reason, in half a sentence.
    """
    bands = list(bands)
    for _ in range(len(bands) + 1):
        bands = without_partial_ends(solid, bands)
        graph = _Graph(solid, bands)
        drop = graph.imprints(steepest) or graph.divided_cap()
        if drop:
            bands = [b for i, b in enumerate(bands) if i not in drop]
            continue
        if graph.reason:
            raise NotSweepableError(graph.reason)
        if graph.groups:
            return [graph.layout()]
        return _open_cycle(solid, bands, graph)
    raise NotSweepableError("the bands of its linking sides do not fit together")


def _open_cycle(solid: Solid, bands: list[Band], graph: _Graph) -> list[Layout]:
    """Lay out bands that close to a cycle and leave no caps, by giving up two of them."""
    if any(not edges for edges in graph.edges.values()):
        face = solid.faces[min(bands[0].faces)]
        raise NotSweepableError(
            f"the linking sides form a closed ring through {face.label()}, so that no face is left for a cap"
        )
    layouts: list[Layout] = []
    n = len(bands)
    for i, j in combinations(range(n), 2) if 4 <= n <= MAX_CYCLE else ():
        with suppress(NotSweepableError):  # two other bands may do
            layouts.extend(lay_out(solid, [b for k, b in enumerate(bands) if k not in (i, j)]))
    if not layouts:
        raise NotSweepableError("its faces close to rings in both directions")
    return layouts


class _Graph:
    """What lies at the two ends of every band."""

    def __init__(self, solid: Solid, bands: Sequence[Band]) -> None:
        self.solid = solid
        self.bands = bands
        self.owner = [-1] * len(solid.faces)
        for i, band in enumerate(bands):
            for f in band.faces:
                self.owner[f] = i
        self.group = [-1] * len(solid.faces)
        self.groups = self._group_caps()
        self.ends = [ends_of(solid, band) for band in bands]
        self.reason = next((ends.reason for ends in self.ends if ends.reason), "")
        self.bottoms = [ends.bottoms for ends in self.ends]
        self.edges: dict[End, list[int]] = {(i, side): [] for i in range(len(bands)) for side in (0, 1)}
        self.partners: dict[End, set[tuple[str, int, int]]] = {end: set() for end in self.edges}
        self._find_partners()

    def _group_caps(self) -> list[list[int]]:
        groups: list[list[int]] = []
        for face in self.solid.faces:
            if self.owner[face.id] >= 0 or self.group[face.id] >= 0:
                continue
            members = [face.id]
            self.group[face.id] = len(groups)
            for f in members:
                for e in self.solid.faces[f].edges:
                    g = across(self.solid, e, f)
                    if self.owner[g] < 0 and self.group[g] < 0:
                        self.group[g] = len(groups)
                        members.append(g)
            groups.append(sorted(members))
        return groups

    def _label(self, face: int) -> str:
        return self.solid.faces[face].label()

    def _find_partners(self) -> None:
        for i, ends in enumerate(self.ends):
            for side in (0, 1):
                for e, g in ends.beyond[side]:
                    self.edges[i, side].append(e)
                    self.partners[i, side].add(self._partner(g, e))
                if len(self.partners[i, side]) > 1:
                    self.reason = "a ring of its linking sides meets several separate faces"

    def _partner(self, face: int, edge: int) -> tuple[str, int, int]:
        j = self.owner[face]
        if j < 0:
            return ("cap", self.group[face], 0)
        reading, _ = self.bands[j].faces[face]
        b = self.bottoms[j][face]
        return ("band", j, 0 if edge in reading.chains[b] else 1)

    def _deviation(self, end: End) -> float:
        return max(abs(self.solid.edges[e].dihedral - pi) for e in self.edges[end])

    def imprints(self, steepest: float) -> set[int]:
        """Return bands that only divide a flat cap, or one that bulges no more steeply, but for two caps that stay."""
        if self.reason or not self.groups:
            return set()
        n_ends = [0] * len(self.groups)
        for partners in self.partners.values():
            for kind, i, _ in partners:
                if kind == "cap":
                    n_ends[i] += 1
        flat: set[int] = set()
        bulging: list[int] = []
        for (i, side), partners in self.partners.items():
            for kind, group, _ in partners:
                if i == 0 or kind != "cap" or not self.edges[i, side]:
                    continue
                deviation = self._deviation((i, side))
                planes = all(self.solid.faces[f].kind == "plane" for e in self.edges[i, side]
                             for f in self.solid.edges[e].faces)  # fmt: skip
                if planes and deviation < FLAT:
                    flat.add(i)
                elif n_ends[group] == 1 and deviation < steepest:
                    bulging.append(i)
        return flat or set(bulging[: max(len(self.groups) - 2, 0)])

    def divided_cap(self) -> set[int]:
        """Return a band that is one plane around a hole, where it leaves no second cap: it is that cap, divided."""
        if self.reason or len(self.groups) != 1:
            return set()
        for i, band in enumerate(self.bands):
            faces = [self.solid.faces[f] for f in band.faces]
            if all(face.kind == "plane" and face.normal @ faces[0].normal > 1.0 - FLAT**2 for face in faces):
                return {i}
        return set()

    def layout(self) -> Layout:
        """Follow the bands from one group of faces to the other."""
        if len(self.groups) != 2:
            raise NotSweepableError(self._wrong_groups())
        chains = []
        used: set[int] = set()
        for start, partners in sorted(self.partners.items()):
            if start[0] in used or partners != {("cap", 0, 0)}:
                continue
            chain: list[tuple[Band, dict[int, int]]] = []
            end = start
            while True:
                i, side = end
                used.add(i)
                turn = {f: (b + 2 * side) % 4 for f, b in self.bottoms[i].items()}
                chain.append((self.bands[i], turn))
                far = self.partners[i, 1 - side]
                if not far:
                    raise NotSweepableError("a ring of its linking sides ends nowhere")
                kind, j, s = next(iter(far))
                if kind == "cap":
                    break
                end = (j, s)
            if j != 1:
                raise NotSweepableError(f"the sides from {self._name(self.groups[0])} lead back to it")
            chains.append(tuple(chain))
        if not chains:
            one, other = (self._name(group) for group in self.groups)
            raise NotSweepableError(f"no linking sides join {one} with {other}")
        if len(used) != len(self.bands):
            unused = next(b for i, b in enumerate(self.bands) if i not in used)
            astray = self._label(min(unused.faces))
            raise NotSweepableError(f"the sides through {astray} do not lead from one cap to the other")
        return Layout(caps=(tuple(self.groups[0]), tuple(self.groups[1])), chains=tuple(chains))

    def _name(self, group: list[int]) -> str:
        more = f" and {len(group) - 1} more" if len(group) > 1 else ""
        return self._label(max(group, key=lambda f: self.solid.faces[f].area)) + more

    def _wrong_groups(self) -> str:
        if len(self.groups) == 1:
            return f"beyond its linking sides all faces hang together, from {self._name(self.groups[0])}"
        names = [self._name(group) for group in self.groups]
        n_more = len(names) - 3
        more = f" and {n_more} other{'s' if n_more > 1 else ''}" if n_more > 0 else ""
        return f"its linking sides leave {len(names)} caps instead of 2: {'; '.join(names[:3])}{more}"
