"""Commands for the tests of the command line."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from ..commands import exit_code

Command = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Command:
    """``command(*args, cwd)`` in this process, with what it wrote to both streams, libraries' own words too."""

    def run(*args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
        words = [str(arg) for arg in args]
        capfd.readouterr()
        before = os.getcwd()
        os.chdir(cwd)
        try:
            code = exit_code(words, monkeypatch)
        finally:
            os.chdir(before)
        out, err = capfd.readouterr()
        return subprocess.CompletedProcess(words, code, out, err)

    return run
