"""CadQuery scripts, run through ``cadquery.cqgi``.

Place in the flow: one of the readers. A script is a program: it runs with the rights of the caller.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from .model import Model
from .objects import read_object


def run_script(path: Path, params: Mapping[str, Any]) -> Model:
    """Run a script and take the one object that it shows."""
    from cadquery import cqgi

    model = cqgi.parse(path.read_text(encoding="utf-8-sig"))
    result = model.build(build_parameters=dict(params))
    if not result.success:
        raise InputError(f"{path}: {result.exception}")
    if len(result.results) != 1:
        raise InputError(f"{path}: the script shows {len(result.results)} objects instead of one.")
    shown = read_object(result.results[0].shape)
    if shown is None:
        raise InputError(f"{path}: the script shows something that is no shape.")
    shown.source, shown.name = str(path), path.stem
    return shown
