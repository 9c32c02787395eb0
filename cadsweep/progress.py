"""How a long run tells how far it is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float | None], None]
"""Called with the stage under way and how much of it is done (0 to 1, None where unknown)."""


def silent(stage: str, fraction: float | None) -> None:
    """Progress for those who did not ask."""
