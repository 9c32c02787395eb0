"""Several meshes that share no node, as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...mesh import HexMesh


def side_by_side(meshes: Sequence[HexMesh]) -> HexMesh:
    """One mesh of several that share no node; boundaries of one name become one."""
    nodes = np.cumsum([0, *(mesh.n_nodes for mesh in meshes)])
    hexes = np.cumsum([0, *(mesh.n_hexes for mesh in meshes)])
    kinds = ("boundaries", "interfaces", "periodic", "parts")
    groups: dict[str, dict[str, list[np.ndarray]]] = {kind: {} for kind in kinds}
    for mesh, node, first in zip(meshes, nodes, hexes, strict=False):
        for kind, start in zip(kinds, (node, node, node, first), strict=True):
            for name, ids in getattr(mesh, kind).items():
                groups[kind].setdefault(name, []).append(ids + start)
    merged = {kind: {n: np.concatenate(ids) for n, ids in own.items()} for kind, own in groups.items()}
    return HexMesh(
        points=np.concatenate([mesh.points for mesh in meshes]),
        hexes=np.concatenate([mesh.hexes + node for mesh, node in zip(meshes, nodes, strict=False)]),
        boundaries=merged["boundaries"],
        interfaces=merged["interfaces"],
        periodic=merged["periodic"],
        parts=merged["parts"],
        info=info_of_all([mesh.info for mesh in meshes]),
    )


def info_of_all(infos: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What is known of several meshes together."""
    return {
        **infos[0],
        "material": None,
        "materials": {k: v for info in infos for k, v in info.get("materials", {}).items()},
        "cad_volume": sum(info["cad_volume"] for info in infos),
        "way": _ways(infos),
        "sweeps": [sweep for info in infos for sweep in info["sweeps"]],
        "colors": {
            kind: {k: v for info in infos for k, v in info.get("colors", {}).get(kind, {}).items()}
            for kind in ("boundaries", "parts")
        },
        "notes": list(dict.fromkeys(note for info in infos for note in info["notes"])),
    }


def _ways(infos: Sequence[Mapping[str, Any]]) -> dict[str, str] | None:
    """How each solid was filled; None where a mesh was made like another, which does not say."""
    known = [info.get("way") for info in infos]
    if not all(isinstance(way, Mapping) for way in known):
        return None
    return {solid: way for own in known for solid, way in (own or {}).items()}


__all__ = ["info_of_all", "side_by_side"]
