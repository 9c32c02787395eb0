"""What stands in README and docs/ is so: every link leads somewhere, every command and block of code runs."""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import subprocess
import sys

import click
import pytest

from cadsweep.cli import group

from ..commands import exit_code, in_this_process
from .docs_pages import PAGES, ROOT, anchors, blocks, inline_commands, links

PROGRAMS = {"ccx": "ccx", "checkMesh": "checkMesh", "gmshToFoam": "gmshToFoam"}
FOAM = "/usr/share/openfoam"


def name_of(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_leads_somewhere(page):
    for target in links(page):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        assert other.exists(), f"{target} of {name_of(page)}"
        assert not anchor or anchor in anchors(other), f"{target} of {name_of(page)}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_in_the_text_have_the_options_that_they_name(page):
    for command in inline_commands(page):
        words = [word for word in shlex.split(command, comments=True)[1:] if word not in ("...", "[...]")]
        known = group.cadsweep.get_command(click.Context(group.cadsweep), words[0])
        assert known is not None, command
        options = {name for parameter in known.params for name in (*parameter.opts, *parameter.secondary_opts)}
        for word in words[1:]:
            assert not word.startswith("--") or word in {*options, "--help"}, command


def run_command(line, monkeypatch):
    """Run a line of a shell; returns its exit code."""
    words = shlex.split(line, comments=True)
    output = words[words.index(">") + 1] if ">" in words else None
    words = words[: words.index(">")] if ">" in words else words
    while "=" in words[0]:
        monkeypatch.setenv(*words.pop(0).split("=", 1))
    if words[0] == "cadsweep":
        with monkeypatch.context() as patch, contextlib.ExitStack() as files:
            if output is not None:
                patch.setattr(sys, "stdout", files.enter_context(open(output, "w")))
            return exit_code(words[1:], monkeypatch)
    if words[0] == "mkdir":
        for folder in words[2:]:
            os.makedirs(folder)
        return 0
    environment = {**os.environ, "WM_PROJECT_DIR": FOAM} if os.path.isdir(FOAM) else dict(os.environ)
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False, env=environment)
    assert "Mesh OK." in done.stdout or words[0] != "checkMesh", done.stdout[-2000:]
    assert "*ERROR" not in done.stdout or words[0] != "ccx", done.stdout[-2000:]
    return done.returncode


def lines_of(text):
    """The commands of a block, continued lines joined."""
    return [line for line in text.replace("\\\n", " ").splitlines() if line.strip() and not line.startswith("#")]


def expected_code(line):
    return int(line.rsplit("exits with", 1)[1]) if "# exits with" in line else 0


RUNNABLE = [page for page in PAGES if any(b.lang in ("python", "sh") and not b.not_run for b in blocks(page))]


@pytest.mark.cad
@pytest.mark.timeout(600)
@pytest.mark.parametrize("page", RUNNABLE, ids=name_of)
def test_every_block_of_a_page_runs_as_it_stands(page, tmp_path, monkeypatch, capsys):
    pytest.importorskip("cadquery")
    pytest.importorskip("gmsh")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cadsweep.isolation.run_isolated", in_this_process)  # also what Python blocks call
    (tmp_path / "models").symlink_to(ROOT / "models")
    names = {"__name__": "__main__"}
    for block in blocks(page):
        where = f"{name_of(page)}:{block.line}"
        if block.title is not None:
            file = tmp_path / block.title
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text)
        elif block.not_run:
            continue
        elif block.lang == "python":
            exec(compile(block.text, where, "exec"), names)
        elif block.lang == "sh":
            for line in lines_of(block.text):
                program = shlex.split(line, comments=True)[0]
                if line.startswith("sh install.sh"):
                    continue  # the gate itself runs it
                if program in PROGRAMS and shutil.which(PROGRAMS[program]) is None:
                    pytest.skip(f"{program}, which {where} calls, is missing here")
                code = run_command(line, monkeypatch)
                assert code == expected_code(line), f"{where}: {line}\n{capsys.readouterr().err}"
