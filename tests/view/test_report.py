"""The page about a mesh: whole, self-contained, and drawn by a browser without a complaint."""

import base64
import io
import json
import re
import sys
import zlib
from dataclasses import replace

import numpy as np
import pytest

from cadsweep.errors import CadSweepError
from cadsweep.report import mesh_summary_html, write_report

from .view_blocks import painted_block, twisted_block
from .view_browser import find_browser, opened

pytest.importorskip("pyvista")
pytest.importorskip("plotly")

COMMAND = "cadsweep report 'a <b>.step' -o page.html"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return write_report(twisted_block(), tmp_path_factory.mktemp("report") / "page.html", command=COMMAND)


def traces_of(page):
    """What the page's viewer draws, unpacked as the browser does it."""
    text = page.read_text(encoding="utf-8")
    packed = re.search(r'id="traces">([^<]*)<', text)[1].replace("/", "<")
    return json.loads(zlib.decompressobj().decompress(base64.b85decode(packed)))


def drawn_share(png):
    """Share of the pixels that are neither white nor grey."""
    from PIL import Image

    image = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=int)
    return (np.ptp(image, axis=-1) > 40).mean()


def test_the_page_says_what_is_known(page):
    text = page.read_text(encoding="utf-8")
    mesh = twisted_block()
    assert "cadsweep report &#x27;a &lt;b&gt;.step&#x27; -o page.html" in text
    for words in ("every check passed", f"{mesh.n_hexes:,} of order 1", "lid", "surface", "0.25 s", "Worst hexahedra"):
        assert words in text
    assert all(name in text for name in mesh.boundaries)
    assert list(page.parent.iterdir()) == [page]


def test_a_long_part_is_seen_from_farther_away(tmp_path):
    mesh = twisted_block(turn=0.0)  # 2 x 2 x 4
    eyes = []
    for stretch in (0.5, 5000.0):
        long = replace(mesh, points=mesh.points * [1, 1, stretch])
        text = write_report(long, tmp_path / "page.html").read_text(encoding="utf-8")
        eyes.append(json.loads(re.search(r'"camera":\{"eye":(\{[^}]*\})', text)[1])["z"])
    assert eyes[0] == pytest.approx(1.25)  # a cube, as plotly itself does
    # Of 2 x 2 x 20,000 the geometric mean is 2 x 10,000^(1/3), and half the length over it must lie before the eye.
    assert eyes[1] * np.sqrt(3) > 10_000 / (2 * 10_000 ** (1 / 3))


def test_the_page_names_nothing_to_load(page):
    # Outside the drawing library's own text there is no address, and no element that would fetch one.
    text = re.sub(r"<script>.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert not re.search(r"https?://|<(img|iframe|script)[^>]+src=|<link[^>]+stylesheet", text)


@pytest.mark.skipif(find_browser() is None, reason="needs Chromium (apt-get install chromium)")
def test_a_browser_draws_the_page_and_does_not_complain(page, tmp_path):
    with opened(page.as_uri(), tmp_path) as tab:
        tab.wait_for("document.body && document.body.dataset.drawn === 'yes'")
        views = tab.evaluate("Array.from(document.querySelectorAll('#bar button'), b => b.textContent)")
        assert views == ["quality", "boundaries", "cut across x", "cut across y", "cut across z"]
        pictures = [tab.picture("#view")]
        for i in (1, 2):
            tab.evaluate(f"document.querySelectorAll('#bar button')[{i}].click()")
            tab.wait_for(f"document.querySelectorAll('#bar button')[{i}].classList.contains('on')")
            tab.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            pictures.append(tab.picture("#view"))
        assert [drawn_share(picture) > 0.05 for picture in pictures] == [True] * 3
        assert len(set(pictures)) == 3
        assert tab.errors() == []
        assert [a for a in tab.requests() if not a.startswith(("file:", "data:", "blob:"))] == []


def test_the_page_has_the_colours_and_names_of_the_cad(tmp_path):
    mesh = painted_block()
    names = {"side_1": "Seite größer", "steel_37": "steel 37"}
    mesh = replace(mesh, info={**mesh.info, "names": names, "material": "steel_37"})
    page = write_report(mesh, tmp_path / "page.html")
    text = page.read_text(encoding="utf-8")
    assert {"#ff0000", "#00ff00"} <= {trace.get("color") for trace in traces_of(page)}
    assert "side_1 (named Seite größer)" in text
    assert "steel_37 (named steel 37)" in text


def test_a_page_of_a_few_hundred_hexahedra_is_small(page):
    assert twisted_block().n_hexes < 400
    assert page.stat().st_size < 2e6


def test_an_invalid_mesh_says_so():
    mesh = twisted_block()
    mesh.points[mesh.hexes[-1, 6]] = mesh.points[mesh.hexes[-1, 0]] - 0.2
    assert "Not valid" in mesh_summary_html(mesh)


def test_a_notebook_shows_a_summary():
    text = twisted_block()._repr_html_()
    assert "<svg" in text
    assert "side_3 (24)" in text  # 4 quads across, 6 layers
    assert text.count("<div") == text.count("</div>")


def test_without_plotly_the_extra_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    with pytest.raises(CadSweepError, match=r"cadsweep\[view\]"):
        write_report(twisted_block(), tmp_path / "page.html")
    assert not list(tmp_path.iterdir())


def test_a_page_that_cannot_be_written_leaves_the_old_one(monkeypatch, tmp_path):
    place = tmp_path / "page.html"
    place.write_text("old")
    monkeypatch.setattr("os.fsync", lambda descriptor: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(CadSweepError, match="No space left"):
        write_report(twisted_block(), place)
    assert place.read_text() == "old"
    assert list(tmp_path.iterdir()) == [place]


def test_a_refused_part_is_shown_with_the_faces_in_question(tmp_path):
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs
    from cadsweep.report import write_refusal

    part = cs.load(cq.Workplane().box(4, 3, 2).union(cq.Workplane().sphere(1).translate((0, 0, 1.5))))
    ball = [face.id for face in part.solids[0].faces if face.kind == "sphere"]
    ring = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 1.0]])
    page = write_refusal(
        part, tmp_path / "page.html", reason="a <ball>", faces_in_question=ball[:1], reasons=["why"], left=[ring]
    )
    text = page.read_text(encoding="utf-8")
    assert "No mesh: a &lt;ball&gt;" in text
    red = [trace["name"] for trace in traces_of(page) if trace.get("color") == "#e0241b"]
    # A ball is divided on the way in: all pieces of the face are coloured.
    assert red == [part.solids[0].faces[f].label() for f in ball]
    # What is left without a sweep is drawn over the part.
    assert [trace["line"]["color"] for trace in traces_of(page) if trace["name"] == "left without a sweep"] == [
        "#f28e00"
    ]


def test_cards_have_a_picture_and_figures():
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs

    part = cs.load(cq.Workplane().box(4, 3, 2))
    for card, words in (
        (part._repr_html_(), "volume"),
        (cs.find_sweeps(part)[0]._repr_html_(), "linking sides"),
        (twisted_block()._repr_html_(), "worst scaled Jacobian"),
    ):
        assert 'src="data:image/png;base64,' in card or "no picture:" in card
        assert words in card
        assert card.count("<div") == card.count("</div>")
    assert "<svg" in twisted_block().quality()._repr_html_()


def test_the_page_of_an_assembly_shows_its_parts_in_their_places_and_apart(tmp_path):
    block = twisted_block(n_layers=2)
    half = block.n_hexes // 2
    mesh = replace(
        block,
        parts={"low": np.arange(half), "high": np.arange(half, 2 * half)},
        interfaces={"low__high": block.hexes[:half, 4:8]},
        info={"materials": {"high": "rubber"}},
        structure=None,
    )
    page = write_report(mesh, tmp_path / "page.html")
    text, traces = page.read_text(encoding="utf-8"), traces_of(page)
    scene = json.loads(re.search(r'id="scene">(.*?)</script>', text, re.DOTALL)[1])
    for view in ("parts", "parts apart"):
        names = [traces[i].get("name") for i in scene["views"][view]]
        assert {"low", "high"} <= set(names)
    assert "Interfaces" in text
    assert "low__high" in text
    assert "rubber" in text
    assert "parts apart" not in write_report(block, tmp_path / "one.html").read_text(encoding="utf-8")


def test_the_page_of_columns_draws_them_apart(tmp_path):
    block = twisted_block(n_layers=3)
    layer = block.n_hexes // 3
    info = {"blocks": [layer, 2 * layer], "sweeps": [{"columns": 2}]}
    mesh = replace(block, info=info, structure=None)
    page = write_report(mesh, tmp_path / "page.html")
    text, traces = page.read_text(encoding="utf-8"), traces_of(page)
    scene = json.loads(re.search(r'id="scene">(.*?)</script>', text, re.DOTALL)[1])
    names = [traces[i].get("name") for i in scene["views"]["columns apart"]]
    assert names[:2] == ["column 1", "column 2"]
    other = replace(mesh, info=info | {"blocks": [layer, layer]})
    assert "columns apart" not in write_report(other, tmp_path / "x.html").read_text(encoding="utf-8"), "not all of it"
