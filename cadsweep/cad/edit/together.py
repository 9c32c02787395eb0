"""Edges and faces in groups that hang together.

Place in the flow: :mod:`.axial` makes features of them.
"""

from __future__ import annotations


class Together:
    """Edges and faces in groups that share vertices or faces; the one that was joined last stands last."""

    def __init__(self) -> None:
        self.groups: dict[int, tuple[set[int], set[int]]] = {}
        self.owners: dict[tuple[str, int], int] = {}
        self.keys: dict[int, list[tuple[str, int]]] = {}

    def join(self, edges: set[int], vertices: set[int], faces: set[int]) -> None:
        """Put edges and faces in one group with all that have a vertex or a face in common with them."""
        own = [*(("vertex", v) for v in vertices), *(("face", f) for f in faces)]
        touched = {self.owners[key] for key in own if key in self.owners}
        # The largest takes in the others: no group is copied over and over.
        stays = max(touched, key=lambda g: (len(self.keys[g]), -g), default=len(self.owners))
        all_edges, all_faces = self.groups.pop(stays, (set(), set()))
        for other in sorted(touched - {stays}):
            more_edges, more_faces = self.groups.pop(other)
            all_edges |= more_edges
            all_faces |= more_faces
            own += self.keys.pop(other)
        all_edges |= edges
        all_faces |= faces
        self.groups[stays] = all_edges, all_faces
        keys = self.keys.setdefault(stays, [])
        for key in own:
            if self.owners.get(key) != stays:
                self.owners[key] = stays
                keys.append(key)


__all__ = ["Together"]
