"""What a user may ask of a sweep, as one checked value.

Foundation: ``pipeline`` makes it from the keyword arguments of :func:`cadsweep.sweep_mesh`; the
command line, batches and MPI runs hand it on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from numbers import Integral, Real
from typing import Any

from .asked import LocalSize, edge_bias, local_size, wall_layers
from .asked import check_positive as _positive
from .choices import FUNCTIONALS, STRATEGIES
from .errors import InputError

INTERFACES = ("auto", "shared", "separate")


def _count(name: str, value: Any) -> None:
    """Refuse what is not a whole number of at least 1."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < 1:
        raise InputError(f"{name} must be a whole number of at least 1, not {value!r}")


def _each(name: str, wishes: Any, what: str, check: Callable[[str, Any], Any]) -> None:
    """Check the wishes for single faces and edges."""
    if wishes is not None and not isinstance(wishes, Mapping):
        raise InputError(
            f"{name} must be a mapping from names of faces or edges to what is asked of them, not {wishes!r}"
        )
    for word, value in (wishes or {}).items():
        check(f"{what} of '{word}'", value)


def _one_of(name: str, value: Any, choices: Sequence[Any]) -> None:
    if value not in choices:
        raise InputError(f"{name} must be one of {', '.join(map(str, choices))}, not {value!r}")


def _names(name: str, value: Any) -> None:
    if value is not None and (isinstance(value, str) or not all(isinstance(word, str) for word in value)):
        raise InputError(f"{name} must be a list of names, not {value!r}")


def _name_or_number(name: str, value: Any) -> None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, str | int)):
        raise InputError(f"{name} must be a name or a number, not {value!r}")


def _chosen_faces(name: str, value: Any) -> None:
    for one in value if isinstance(value, list | tuple) else [value]:
        if one is None:
            raise InputError(f"{name} must be the id, name or selector of faces or edges, not None")
        _name_or_number(name, one)


@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """Options of :func:`cadsweep.sweep_mesh`; every length is in model units.

    Attributes
    ----------
    size : float, None, callable, or sequence of LocalSize or mapping
        Wanted edge length of the quads on the source cap; None derives it from the part. A function of points (n, 3)
        that gives lengths (n,), model units, or places with a size each are kept as `local_sizes`; a number among the
        places is the size away from them.
    tolerance : float or None
        Greatest distance of the mesh's boundary from the CAD faces, measured; edges, sides and caps are divided as
        finely as it takes. None: what loses no more than 0.5 % of volume and area where no `size` is given either.
    bridge : float or None
        Distance up to which the mesh may leave the CAD where a face ends in a tip, its edges meeting at next to no
        angle: it ends where they are that far apart; and where embossing or engraving is lower than that, which is
        flattened. None takes a twentieth of the size, and no more than the tolerance, and for embossing that leaves no
        good mesh 0.3 of the size; 0 keeps all.
    layers : int or None
        Layers of hexahedra from source to target, over all stations; None derives it from `size`.
    bias : float, (float, float) or None
        Grading along the sweep, within each span between stations: the ratio of the last layer's
        thickness to the first's, or a pair (source end, target end) of ratios of the middle's to
        each end's.
    fractions : sequence of float or None
        Explicit places of the layers, rising from 0 to 1, instead of `layers` and `bias`.
    functional : {"H", "F", "G"}
        The functional of the affine fit, equations (10), (6), (9) of the paper. It, `strategy` and `residual` go with
        sweeps; a part that is meshed as a stack of columns refuses others than the usual ones, as it does `bias`.
    strategy : {"both", "source", "advancing"}
    residual : bool
        Carry what the affine map leaves of the rings into the interior.
    smoothing : bool
        Mend what the checks find wrong.
    source, target : str, int, sequence of them, or None
        Caps by name, id or CadQuery selector string; None finds them.
    sizes : mapping of str to float
        Wanted edge length on edges, each by name, ``"edge 12"`` or ``"edges:|Z"`` (a CadQuery selector), or on
        all edges of a face. An edge along the sweep sets the layers that its span wants. What is said of an edge
        itself goes before what is said of its faces.
    counts : mapping of str to int
        Segments that an edge must get, by name, id (``"edge 12"``) or CadQuery selector; each edge that a name
        covers gets as many. An edge that had to be divided gets them in all.
    rail_layers : mapping of str to int
        Layers between the ends of an edge along the sweep, by name, id or CadQuery selector, or of a span between
        stations (``"span 2"``, counted from the source); edges of one name that follow each other get them in
        all. The other spans share what is left of `layers`.
    local_sizes : callable, or sequence of LocalSize or mapping
        Sizes that change from place to place, below `size`: ``[{"at": (x, y, z), "radius": r, "size": s}]``, where
        `at` may be a name or selector, or a function of points (m, 3) that gives lengths (m,), model units.
    biases : mapping of str to EdgeBias or mapping
        Grading of the segments of edges by name, id (``"edge 12"``) or CadQuery selector (``"edges:|X"``):
        ``{"towards": "clamp", "ratio": 5}``, see :class:`cadsweep.asked.EdgeBias`. Edges that answer them across
        rectangles and along the sweep follow; counts stay as the size gives them.
    wall_layers : mapping of str to WallLayers or mapping
        Layers of hexahedra along faces by name, id or CadQuery selector: ``{"wall": WallLayers(first=0.05, growth=1.2,
        n=8)}``, see :class:`cadsweep.asked.WallLayers`.
    periodic : mapping of str to str
        Faces whose meshes answer each other node by node, under the translation or rotation from the first to the
        second: ``{"left": "right"}``, by name, id or CadQuery selector. Pairs are in ``mesh.periodic``.
    names : mapping of str to str, int, or sequence of them
        Names for faces and edges: to each what it is given to, as ``{"inlet": "face 7", "ribs": ["face 3", "face
        9"]}``; of one solid of several ``"pin: face 7"``. Other options know them, and so does the mesh.
    params : mapping or None
        Parameters of a CadQuery script.
    part : str, int or None
        Which solid of an assembly: its name, or its number from 0.
    touch : float or None
        Distance up to which solids of an assembly are taken to touch; None takes the noise of their coordinates.
    cut_overlaps : bool
        Whether the larger of two solids that overlap is cut where they do; else they are refused.
    interfaces : {"auto", "shared", "separate"}
        Whether solids that touch share their nodes, or are meshed each by itself, their contacts named in pairs; by
        default they share nodes but where no mesh can be had so, and a note names those that do not.
    only, skip : sequence of str or None
        Solids of an assembly to be meshed, or not to be meshed, by name.
    skip_unmeshable : bool
        Leave out the solids of an assembly that cannot be meshed; a note names each and says why.
    order : int
        1 to 8.
        Polynomial order of the hexahedra.
    nodes : {20, 27}
        Nodes of a hexahedron of order 2.
    allow_inverted : bool
        Return a mesh that is not valid, marked so, instead of raising.
    allow_coarse : bool
        Return a mesh whose volume or area is more than 5 % off the CAD's.
    refine : int
        How often every hexahedron of the finished mesh is made into eight (:func:`cadsweep.refine`).
    decompose : bool
        Cut a solid that no sweep fits into cells.
    fitted : bool or None
        Fill the solid by a fitted grid: True, whatever else could; False, never; None, where nothing else makes a mesh
        of a single solid and `decompose` is on.
    cuts : sequence or None
        Cuts of the user's own, made first: ``"plane z=3"``, ``"plane 1,1,0,2.5"``, ``"face 12"``, a STEP or BREP file,
        CadQuery planes, faces and solids. A shape cuts as far as it reaches, a face of the part itself is extended.
    decompose_time : float or None
        Seconds of processor time after which no more cuts are looked for; the best found until then are taken, and a
        note says so. None: 20, and after 45 nothing more is tried of a solid, so that there is an answer in a minute.
    suppress : sequence of str or None
        Features to be removed first: ``"fillets r<0.5"``, ``"holes d<2"`` (model units), ``"fillets"``, ``"holes"``, or
        faces by name, id (``"face 12"``) or CadQuery selector. Each is listed in the notes.
    without : sequence of str
        Rules that are switched off, by name, as ``"cap: fan"``; :func:`cadsweep.pipeline.tables.all_rows` lists them.
    max_hexes : int, math.inf or None
        Refuse larger meshes before work starts; None refuses more than 5 million in memory, and ``math.inf`` allows
        what the memory holds.
    max_memory : float or None
        Memory for the run in GB; None takes what the machine has.

    Examples
    --------
    >>> from cadsweep.options import SweepOptions
    >>> SweepOptions(size=2.0).strategy
    'both'
    >>> SweepOptions(layers=0)
    Traceback (most recent call last):
    cadsweep.errors.InputError: layers must be a whole number of at least 1, not 0
    """

    size: float | None = None
    tolerance: float | None = None
    bridge: float | None = None
    layers: int | None = None
    bias: float | tuple[float, float] | None = None
    fractions: Sequence[float] | None = None
    functional: str = "H"
    strategy: str = "both"
    residual: bool = True
    smoothing: bool = True
    source: Any = None
    target: Any = None
    sizes: Mapping[str, float] | None = None
    counts: Mapping[str, int] | None = None
    rail_layers: Mapping[str, int] | None = None
    local_sizes: Callable[[Any], Any] | Sequence[Any] | None = None
    biases: Mapping[str, Any] | None = None
    wall_layers: Mapping[str, Any] | None = None
    periodic: Mapping[str, str] | None = None
    names: Mapping[str, Any] | None = None
    params: Mapping[str, Any] | None = None
    part: str | int | None = None
    touch: float | None = None
    cut_overlaps: bool = False
    interfaces: str = "auto"
    only: Sequence[str] | None = None
    skip: Sequence[str] | None = None
    skip_unmeshable: bool = False
    order: int = 1
    nodes: int = 20
    allow_inverted: bool = False
    allow_coarse: bool = False
    refine: int = 0
    decompose: bool = True
    fitted: bool | None = None
    cuts: Sequence[Any] | None = None
    decompose_time: float | None = None
    suppress: Sequence[str] | None = None
    without: Sequence[str] = ()
    max_hexes: float | None = None
    max_memory: float | None = None

    def __post_init__(self) -> None:
        self._take_places(self.size)
        for name in ("size", "tolerance", "bridge", "max_memory", "decompose_time"):
            if getattr(self, name) is not None and (name, getattr(self, name)) != ("bridge", 0.0):
                _positive(name, getattr(self, name))
        if self.layers is not None:
            _count("layers", self.layers)
            if self.layers > 10**8:
                raise InputError(f"layers = {self.layers} is more than any machine holds; try fewer")
        if self.bias is not None:
            for ratio in self.bias if isinstance(self.bias, tuple | list) else (self.bias,):
                _positive("bias", ratio)
                if not 1e-4 <= ratio <= 1e4:
                    raise InputError(f"bias must lie between 1e-4 and 1e4, not {ratio!r}")
            if isinstance(self.bias, tuple | list) and len(self.bias) != 2:
                raise InputError(f"bias is one ratio or a pair (source end, target end), not {self.bias!r}")
        if self.fractions is not None:
            self._check_fractions(self.fractions)
        _one_of("functional", self.functional, FUNCTIONALS)
        _one_of("strategy", self.strategy, STRATEGIES)
        _one_of("interfaces", self.interfaces, INTERFACES)
        _names("only", self.only)
        _names("skip", self.skip)
        _names("suppress", self.suppress)
        _names("without", self.without)
        _one_of("order", self.order, tuple(range(1, 9)))
        _one_of("nodes", self.nodes, (20, 27))
        if self.nodes == 27 and self.order != 2:
            raise InputError("nodes=27 goes with order=2")
        _one_of("refine", self.refine, range(9))
        _name_or_number("part", self.part)
        if self.touch is not None:
            _positive("touch", self.touch)
        _each("sizes", self.sizes, "the size", _positive)
        _each("counts", self.counts, "the count", _count)
        _each("rail_layers", self.rail_layers, "the number of layers", _count)
        self._check_local_sizes(self.local_sizes)
        _each("biases", self.biases, "the bias", edge_bias)
        _each("periodic", self.periodic, "the periodic partner", _name_or_number)
        _each("names", self.names, "what has the name", _chosen_faces)
        _each("wall_layers", self.wall_layers, "the wall layers", wall_layers)
        if self.max_hexes is not None and self.max_hexes != math.inf:
            _positive("max_hexes", self.max_hexes)

    def _take_places(self, asked: Any) -> None:
        """Keep a `size` that is a function, or places, as local sizes."""
        if asked is None or isinstance(asked, Real):
            return
        if self.local_sizes is not None:
            raise InputError("size is a function or a list of places: without local_sizes, which is another")
        wished: list[Any] = []
        if not callable(asked):
            if isinstance(asked, str) or not isinstance(asked, Sequence | Mapping | LocalSize):
                raise InputError(f"size must be a number, a function or a list of places, not {asked!r}")
            wished = list(asked) if isinstance(asked, Sequence) else [asked]
        numbers = [value for value in wished if isinstance(value, Real)]
        if len(numbers) > 1:
            raise InputError(f"size: one number beside the places is the size away from them, not {numbers!r}")
        places = [value for value in wished if not isinstance(value, Real)]
        if not callable(asked) and not places:
            raise InputError(f"size must be a number, a function or a list of places, not {asked!r}")
        # The value is frozen for its users; here it is still being made.
        object.__setattr__(self, "size", numbers[0] if numbers else None)
        object.__setattr__(self, "local_sizes", asked if callable(asked) else places)

    @staticmethod
    def _check_local_sizes(asked: Any) -> None:
        if asked is None or callable(asked):
            return
        if isinstance(asked, str | Mapping) or not isinstance(asked, Sequence):
            raise InputError(f"local_sizes must be a function or a list of places, not {asked!r}")
        for number, value in enumerate(asked, 1):
            local_size(f"local size {number}", value)

    def _check_fractions(self, fractions: Sequence[float]) -> None:
        values = list(fractions)
        if len(values) < 2 or not all(isinstance(v, Real) and math.isfinite(v) for v in values):
            raise InputError("fractions must be at least two finite numbers")
        if values[0] != 0 or values[-1] != 1 or any(b <= a for a, b in pairwise(values)):
            raise InputError("fractions must rise from 0 to 1")
        if self.bias is not None:
            raise InputError("give bias or fractions, not both")
        if self.layers is not None and self.layers != len(values) - 1:
            raise InputError(f"{len(values)} fractions make {len(values) - 1} layers, not layers = {self.layers}")
