"""The page in a real browser: what a user does on it, and what others cannot."""

import contextlib
import http.client
import json
import subprocess
import sys
import urllib.error
import urllib.parse
import urllib.request
import zipfile
from pathlib import Path

import psutil
import pytest

from cadsweep.io import FORMATS

from .pages import find_browser, served, visited

pytestmark = [
    pytest.mark.cad,
    pytest.mark.skipif(find_browser() is None, reason="needs Chromium (apt-get install chromium)"),
]
INLET = (8.75, 0.0, 0.0)  # on the ring between the radii 7.5 and 10 at the lower end of the elbow


def status_of(address, **headers):
    class Stay(urllib.request.HTTPRedirectHandler):
        def redirect_request(self, *arguments):
            return None

    request = urllib.request.Request(address, headers=headers)
    try:
        return urllib.request.build_opener(Stay).open(request, timeout=20).status
    except urllib.error.HTTPError as error:
        return error.code


def status_or_gone(address):
    """How the server answers, or that there is none any more."""
    try:
        return status_of(address)
    except urllib.error.URLError:
        return "gone"


def socket_status(base, query):
    """How the server answers who wants to talk to it by websocket."""
    place = urllib.parse.urlsplit(base).netloc
    with contextlib.closing(http.client.HTTPConnection(place, timeout=20)) as connection:
        key = {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="}
        connection.request("GET", f"/ws{query}", headers={"Upgrade": "websocket", "Connection": "Upgrade", **key})
        return connection.getresponse().status


def file_names(visitor):
    """Suffix and file name of every format that the page offers."""
    suffixes = visitor.page.evaluate("[...document.querySelectorAll('#format option')].map((e) => e.value)")
    return [(suffix, "polyMesh.zip" if suffix == ".polymesh" else f"elbow{suffix}") for suffix in suffixes]


def bytes_of(path):
    """Contents by name: of a file, of a folder, or of a folder in a zip file."""
    if path.suffix == ".zip":
        with zipfile.ZipFile(path) as archive:
            return {Path(name).name: archive.read(name) for name in archive.namelist()}
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    return {file.name: file.read_bytes() for file in files}


def open_elbow(visitor):
    visitor.wait_drawn()
    visitor.look_from((0, 0, 1))


def test_from_the_inlet_to_a_deck_and_the_command_and_the_script_make_the_same(tmp_path, monkeypatch):  # noqa: PLR0915
    with served("models/elbow.step") as (process, address), visited(address, tmp_path / "profile") as user:
        base = address.split("?")[0]
        assert socket_status(base, "") == 401
        assert socket_status(base, "?" + address.split("?")[1]) == 101
        for path in ("", "index.html", "ws", "vue.global.js", "hand-down/0/a", "make?name=a.inp"):
            assert status_of(base + path) == 401
        assert status_of(address, Host="evil.example") == 403
        assert status_of(address, Origin="http://evil.example") == 403

        open_elbow(user)
        user.click_at(*user.where(INLET))
        user.wait_state("picked", ["face:0:2"])
        user.wait("document.querySelector('.item.picked .label')?.textContent === 'inlet'")
        user.press('[data-key="face:0:11"]')  # and in the tree
        user.wait_state("picked", ["face:0:11"])
        user.click_at(*user.where(INLET))
        user.wait_state("picked", ["face:0:2"])

        user.type("#f-name", "entry")
        user.press("#b-name")
        user.type("#f-first", "thin")
        user.press("#b-walls")
        user.wait("!!document.querySelector('.problem')")
        assert "thin" in user.page.evaluate("document.querySelector('.problem').textContent")
        user.type("#f-first", "0.2")
        user.press("#b-walls")
        user.wait("trame.state.get('wishes').length === 2")
        user.key("Escape")
        user.press("#undo")
        user.wait("trame.state.get('wishes').length === 1")
        user.press("#redo")
        user.wait("trame.state.get('wishes').length === 2")
        user.type("#w-size", "3")
        user.wait("trame.state.get('estimate').includes('hexahedra')")
        user.press("#make")
        user.wait_state("has_mesh", True, 300)
        user.wait("document.querySelectorAll('#histogram .bin').length > 10")
        user.wait("!!trame.state.get('n_shown')")
        shown = user.state("n_shown")
        user.press("#axis-y")
        user.wait(f"trame.state.get('n_shown') !== '{shown}' && trame.state.get('n_shown') !== '0'")

        user.press("#axis-none")
        for color in ("size", "boundary", "solid", "cell", "distance", "quality"):
            legend = user.state("legend")
            user.type("#color", color)
            user.wait_state("l_color", color)
            user.wait(f"JSON.stringify(trame.state.get('legend')) !== {json.dumps(json.dumps(legend))}")

        sizes = "[...document.querySelectorAll('body *')].filter((e) => e.childNodes.length && e.textContent.trim())"
        assert user.page.evaluate(f"Math.min(...{sizes}.map((e) => parseFloat(getComputedStyle(e).fontSize)))") >= 12
        assert user.page.evaluate("document.documentElement.scrollWidth <= 1280 && document.body.scrollHeight <= 720")
        assert user.outside() == []

        downloads = tmp_path / "downloads"
        user.saves_to(downloads)
        taken = [user.save(suffix, name) for suffix, name in file_names(user)]
        user.press("#take-report")
        assert "elbow" in user.saved(downloads / "elbow.html").read_text()
        user.press("#take-picture")
        assert user.saved(downloads / "elbow.png").read_bytes()[:4] == b"\x89PNG"
        user.press("#take-script")
        assert "sweep_mesh" in user.saved(downloads / "elbow_mesh.py").read_text()
        user.press("#take-session")
        assert '"entry"' in user.saved(downloads / "elbow.cadsweep.json").read_text()
        user.type("#format", ".inp")
        user.wait_state("format", ".inp")
        command, script = user.copied("#copy-command"), user.copied("#copy-script")
        assert (command, script) == (user.state("command"), user.state("script"))
    assert process.returncode == 0
    words = command.replace("cadsweep mesh", f"{sys.executable} -m cadsweep mesh", 1)
    subprocess.run(words, shell=True, check=True, cwd=tmp_path, capture_output=True)
    monkeypatch.chdir(tmp_path)
    made = {"print": lambda *words: None}
    by_command = (tmp_path / "elbow.inp").read_bytes()
    exec(script, made)
    assert (tmp_path / "elbow.inp").read_bytes() == by_command
    assert b"NAME=entry" in by_command
    for path in taken:  # every format holds, to the bit, what the script's mesh is written as
        made["mesh"].write(tmp_path / path.name.removesuffix(".zip"))
        assert bytes_of(path) == bytes_of(tmp_path / path.name.removesuffix(".zip")), path.name
    assert len(taken) == len(FORMATS) - 1  # all but the one of several ranks


def test_a_run_is_ended_half_way_two_pages_show_the_same_and_nothing_is_left(tmp_path):
    (tmp_path / "tmp").mkdir()
    with served("models/elbow.step", TMPDIR=str(tmp_path / "tmp")) as (process, address):
        with visited(address, tmp_path / "one") as user, visited(address, tmp_path / "two") as other:
            open_elbow(user)
            other.wait_drawn()
            user.press('[data-key="face:0:3"]')
            other.wait_state("picked", ["face:0:3"])
            user.type("#w-size", "0.3")  # some three million hexahedra: seconds
            other.wait("trame.state.get('w_size') === '0.3'")
            other.press("#make")
            user.wait("trame.state.get('stages').length > 1")
            user.press("#end")
            user.wait_state("meshing", False)
            user.wait("trame.state.get('message').includes('ended')")  # and so it was not at its end by itself
            assert user.state("has_mesh") is False
            user.press('[data-key="face:0:4"]')  # the page is usable
            other.wait_state("picked", ["face:0:4"])
        children = psutil.Process(process.pid).children(recursive=True)
    assert process.returncode == 0
    assert process.stdout.read() == ""
    assert process.stderr.read() == ""
    _, alive = psutil.wait_procs(children, timeout=10)
    assert alive == []
    assert list((tmp_path / "tmp").glob("cadsweep*")) == []


def test_what_is_refused_damaged_or_a_program_is_said_and_the_page_goes_on(tmp_path):
    import cadquery as cq

    pit = cq.Solid.makeCone(0, 5, 8, pnt=cq.Vector(3, -1, 5), dir=cq.Vector(0.3, 0.4, 1))
    cq.exporters.export(cq.Workplane().box(20, 20, 20).cut(cq.Workplane(pit)), str(tmp_path / "pit.step"))
    damaged = tmp_path / "damaged.step"
    damaged.write_bytes(Path("models/elbow.step").read_bytes()[:9000])
    program = tmp_path / "ball.py"
    long_name = "a_name_that_is_as_long_as_names_of_some_companies_are_" * 3
    program.write_text(
        "import pathlib\nimport cadquery as cq\n"
        f"pathlib.Path({str(program.with_suffix('.ran'))!r}).touch()\n"
        "ball = cq.Workplane().sphere(5)\n"
        f"show_object(cq.Assembly(name='{long_name}').add(ball))\n"
    )
    with served() as (_, address), visited(address, tmp_path / "profile") as user:
        user.wait_state("phase", "empty")
        user.page.evaluate(f"trame.trigger('open_path', ['{damaged}'])")
        user.wait("trame.state.get('message_kind') === 'error' && !!trame.state.get('message')")
        assert "damaged.step" in user.state("message")
        assert "Traceback" not in user.page.evaluate("document.body.innerText")
        user.page.evaluate(f"trame.trigger('open_path', ['{program}'])")
        user.wait("!!document.querySelector('#consent')")
        assert not program.with_suffix(".ran").exists()
        user.press("#consent-no")
        user.wait_state("phase", "empty")
        assert not program.with_suffix(".ran").exists()
        user.page.evaluate(f"trame.trigger('open_path', ['{program}'])")
        user.press("#consent-yes")
        user.wait(
            "trame.state.get('phase') === 'part' || "
            "(trame.state.get('phase') !== 'consent' && !!trame.state.get('message'))"
        )
        assert user.state("phase") == "part", user.state("message")
        assert program.with_suffix(".ran").exists()
        assert user.page.evaluate("document.documentElement.scrollWidth <= 1280")
        user.page.evaluate("trame.trigger('wish_whole', ['max_hexes', '2'])")
        user.wait("trame.state.get('whole') !== 1 && trame.state.get('w_max_hexes') === '2'")
        user.wait(
            "document.querySelector('.pane .problem')?.textContent.includes('beyond the limit')"
        )  # beside the field
        user.press("#make")
        user.wait("!!trame.state.get('refusal')", 120)
        assert 1 <= len(user.state("refusal")["lines"]) <= 3
        user.press("#theme")
        user.wait("document.documentElement.dataset.theme === 'dark'")
        user.page.evaluate("trame.trigger('open_path', ['models/elbow.step'])")
        user.wait_state("part_name", "elbow")  # the camera turns to the middle of another part
        user.wait("Math.hypot(...trame.refs.view.getCamera().focalPoint.map((v, i) => v - [20, 0, 30][i])) < 1")

        user.page.evaluate(f"trame.trigger('open_path', ['{tmp_path / 'pit.step'}'])")
        user.wait_state("part_name", "pit")
        user.type("#w-layers", "6")  # which no fitted grid can do: the search is shorter
        user.wait("trame.state.get('w_layers') === '6'")
        user.wait("document.querySelector('#view').dataset.drawn == 2")
        user.press("#make")
        user.wait("(trame.state.get('refusal')?.lines ?? []).join().includes('face 6')", 300)
        assert set(user.state("questioned")) == {"face:0:6", "face:0:7", "face:0:8"}
        user.wait("document.querySelector('#view').dataset.drawn == 3")  # with the edges of the cell
        user.press("#tries button")  # a mesh was made with it
        user.wait("trame.state.get('wishes').length === 1")
        assert "left out" in user.state("wishes")[0]["text"]


def test_an_object_of_a_program_is_opened_and_a_notebook_shows_its_page(tmp_path):
    import cadquery as cq

    import cadsweep as cs

    with cs.open(cq.Workplane().box(3, 2, 1), browser=False, wait=False) as page:
        assert page.address in page._repr_html_().replace("&amp;", "&")
        assert status_of(page.address.split("?")[0]) == 401
        with visited(page.address, tmp_path / "profile") as user:
            user.wait_drawn()
            assert len(user.state("tree")) == 1 + 6 + 12
            user.wait("trame.state.get('estimate').includes('hexahedra')")
            assert user.state("command") == ""  # there is no file that a command could name
            assert "part = ..." in user.state("script")
    assert status_or_gone(page.address) == "gone"


def test_the_server_ends_by_itself_when_its_page_has_been_closed(tmp_path):
    with served("models/block.step", idle="1.5") as (process, address):
        with visited(address, tmp_path / "profile") as user:
            user.wait_state("phase", "part")
        process.wait(120)
    assert process.returncode == 0
