"""What is known of a mesh besides its arrays: :class:`MeshRecord`.

Place in the flow: the pipeline fills it, files keep some of it, reports show it. ``HexMesh.info`` is it, read as a
mapping of what is known; ``HexMesh.record`` has its fields.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .arrays import IntArray
    from .quality import QualityReport


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshRecord(Mapping[str, Any]):
    """The making of a mesh: a read-only mapping of those of its fields that are known.

    ``record | {"notes": [...]}`` is a new record with another value.

    Attributes
    ----------
    way : str, mapping of str to str, or None
        How its solid was filled: ``sweep``, ``columns``, ``cells`` or ``fitted``; of several by name.
    part : str or None
        What the CAD model calls the part.
    material : str or None
        Its material, where it is one.
    materials : mapping of str to str, or None
        Materials of the solids of an assembly, by name.
    paths : mapping of str to str, or None
        For each solid of an assembly the names of the assemblies that it is in and its own, joined by ``/``.
    cad_volume : float or None
        Volume of the CAD model, model units.
    cad_volume_doubt : float or None
        How uncertain that is, where faces of the model miss each other.
    distance : float or None
        Greatest distance of the boundary's straight-sided quads from the CAD faces, measured, model units.
    curved_distance : float or None
        Of a mesh of order 2 and above: that of its curved quads from the curved faces, at places between their nodes.
    sweeps : sequence of mapping, or None
        For every sweep its ``source`` and ``target`` (names of faces, or ids), ``layers``, and ``span_layers`` or
        ``cell``, where there is such a thing.
    blocks : sequence of int, or None
        Hexahedra of every column or cell that the mesh is made of, one after the other, where there are several and
        their hexahedra come in turn.
    names : mapping of str to str, or None
        Declared name to the name that the user gave.
    colors : mapping or None
        Those of the CAD model, ``{"boundaries": {name: "#rrggbb"}, "parts": {...}}``.
    notes : sequence of str, or None
        What was done to the model and the mesh on the way, a readable line each.
    rows : sequence of str, or None
        Rows of tables of rules that had a share in it, by name (:mod:`cadsweep.rows`).
    seconds : mapping of str to float, or None
        Wall time by stage.
    quality : QualityReport or None
        What the checks found, once they have been made.
    coarse_nodes : (n,) int64, or None
        Of a refined mesh: for every node of the mesh before, which node of this one it is.
    extra : mapping
        Whatever else somebody wants to keep with the mesh.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> mesh = cs.sweep_mesh(box, size=1.0, layers=2)
    >>> mesh.record.sweeps[0]["layers"], mesh.info["cad_volume"]
    (2, 24.0)
    >>> sorted(mesh.record.seconds)[:2]
    ['assembly', 'cad']
    """

    way: str | Mapping[str, str] | None = None
    part: str | None = None
    material: str | None = None
    materials: Mapping[str, str] | None = None
    paths: Mapping[str, str] | None = None
    cad_volume: float | None = None
    cad_volume_doubt: float | None = None
    distance: float | None = None
    curved_distance: float | None = None
    sweeps: Sequence[Mapping[str, Any]] | None = None
    blocks: Sequence[int] | None = None
    names: Mapping[str, str] | None = None
    colors: Mapping[str, Mapping[str, str]] | None = None
    notes: Sequence[str] | None = None
    rows: Sequence[str] | None = None
    seconds: Mapping[str, float] | None = None
    quality: QualityReport | None = None
    coarse_nodes: IntArray | None = None
    extra: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> MeshRecord:
        """The record with these values; a record is itself."""
        if isinstance(values, MeshRecord):
            return values
        known = {key: value for key, value in values.items() if key in _KNOWN}
        return cls(**known, extra={key: value for key, value in values.items() if key not in _KNOWN})

    def __getitem__(self, key: str) -> Any:
        value = getattr(self, key) if key in _KNOWN else self.extra[key]
        if value is None:
            raise KeyError(key)
        return value

    def __iter__(self) -> Iterator[str]:
        yield from (key for key in _KNOWN if getattr(self, key) is not None)
        yield from self.extra

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __or__(self, changes: Mapping[str, Any]) -> MeshRecord:
        return MeshRecord.of({**self, **changes})


_KNOWN = tuple(known.name for known in fields(MeshRecord) if known.name != "extra")
