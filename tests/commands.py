"""The command line without its processes: what a command does, said to the caller's own streams.

A program and its worker import OpenCASCADE and compiled kernels anew for every command, which is most of what a small
one costs. That they do, and end, and are ended, has its own tests; the others need what a command does alone.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from cadsweep.cli import group


def as_program(*args: object, cwd: Path, **options: object) -> subprocess.CompletedProcess[str]:
    """Run a command as its user does."""
    return subprocess.run(  # type: ignore[call-overload,no-any-return]
        [sys.executable, "-m", "cadsweep", *map(str, args)],
        capture_output=True, text=True, timeout=800, check=False, cwd=cwd, **options,
    )  # fmt: skip


def in_this_process(
    task: str, args: Sequence[object], kwargs: dict, *, on_progress: object, **limits: object
) -> object:
    """What a worker does, without the worker."""
    del on_progress, limits
    module, name = task.split(":")
    return getattr(importlib.import_module(module), name)(*args, **kwargs, on_progress=lambda *_: None)


def exit_code(words: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> int:
    """Run ``cadsweep`` with these words in this process and folder; returns its exit code."""
    with monkeypatch.context() as patch:
        patch.setattr("cadsweep.isolation.run_isolated", in_this_process)
        patch.setattr(sys, "argv", ["cadsweep", *words])
        # What tells click its own name, beside the first argument; pytest was started as a module.
        patch.setattr(sys.modules["__main__"], "__package__", None)
        try:
            return group._run(words)
        except SystemExit as end:
            return int(end.code or 0)
