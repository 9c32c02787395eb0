"""Nek5000's ``.re2``: what is written is what is read, by this package and by pymech."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cadsweep import io
from cadsweep.cells import HEX_FACES
from cadsweep.errors import InputError
from cadsweep.mesh import HexMesh

from .io_meshes import bent_box, box, two_parts
from .test_deck_readers import PYTHON, seen

PYMECH = """
from pymech.neksuite import readre2
m = readre2(path)
found = {
    "corners": [[e.pos[:, k // 4, (k % 4) // 2, (k % 4 in (1, 2)) * 1].tolist() for k in range(8)] for e in m.elem],
    "curved": [[e.ccurv, e.curv[:, :3].tolist()] for e in m.elem],
    "conditions": [
        [j, f, c[0], [c[k] for k in range(3, 8)]]
        for j, e in enumerate(m.elem) for f, c in enumerate(e.bcs[0].tolist()) if c[0]
    ],
    "fields": m.nbc,
}
"""


def places(mesh: HexMesh, cells: np.ndarray) -> list:
    """Cells by where their nodes are, their order and where each begins aside."""
    return sorted(sorted(map(tuple, own)) for own in mesh.points[cells].tolist())


@pytest.mark.parametrize("mesh", [bent_box(8), bent_box(20), box(), two_parts()], ids=["8", "20", "straight", "parts"])
def test_elements_boundaries_and_parts_come_back(tmp_path, mesh):
    io.write(mesh, tmp_path / "a.re2")
    back = io.read(tmp_path / "a.re2")
    assert back.n_nodes == mesh.n_nodes
    np.testing.assert_array_equal(back.points[back.hexes], mesh.points[mesh.hexes])
    assert set(back.boundaries) == set(mesh.boundaries) - {"interface"}
    for name, quads in back.boundaries.items():
        assert places(back, quads) == places(mesh, mesh.boundaries[name]), name
    assert sum(map(len, back.parts.values())) == mesh.n_hexes
    for name, ids in back.parts.items():
        own = [name[:-5]] if name.endswith("_only") else name.split("_and_")
        assert all(set(ids) <= set(mesh.parts[one]) for one in own)
    assert back.quality().problems == ()
    io.write(mesh, tmp_path / "b.re2")
    assert (tmp_path / "a.re2").read_bytes() == (tmp_path / "b.re2").read_bytes()


def test_files_of_the_other_order_of_bytes_and_with_rounded_corners_are_read(tmp_path):
    mesh = bent_box(20)
    io.write(mesh, tmp_path / "a.re2")
    content = (tmp_path / "a.re2").read_bytes()
    numbers = np.frombuffer(content[84:], dtype="<f8").byteswap()
    # The last of eight numbers of a curved side or a condition holds characters; no note of ours follows them.
    at = 25 * mesh.n_hexes
    for _ in range(2):
        count = int(np.frombuffer(content, "<f8", 1, 84 + 8 * at)[0])
        letters = slice(at + 8, at + 1 + 8 * count, 8)
        numbers[letters] = numbers[letters].byteswap()
        at += 1 + 8 * count
    numbers = numbers[:at]
    corners = numbers[: 25 * mesh.n_hexes].reshape(-1, 25)[:, 1:]
    corners[:] = (corners.byteswap() * (1 + 1e-13 * np.arange(24))).byteswap()
    (tmp_path / "b.re2").write_bytes(content[:80] + content[83:79:-1] + numbers.tobytes())
    back = io.read(tmp_path / "b.re2")
    assert back.n_nodes == mesh.n_nodes
    np.testing.assert_allclose(back.points[back.hexes], mesh.points[mesh.hexes], rtol=1e-11, atol=1e-11)
    assert list(back.boundaries) == [f"boundary_{j}" for j in range(1, 7)]
    named = [quads for name, quads in mesh.boundaries.items() if name != "walls"]
    assert [len(quads) for quads in back.boundaries.values()] == [len(quads) for quads in named]


def test_letters_and_periodic_partners_stand_in_the_conditions(tmp_path):
    mesh = box()
    pairs = np.stack([np.arange(12), mesh.n_nodes - 12 + np.arange(12)], axis=1)
    some = {name: mesh.boundaries[name] for name in ("source", "target", "side_1")}
    mesh = replace(mesh, boundaries=some, periodic={"source__target": pairs})
    io.write(mesh, tmp_path / "a.re2", letters={"side_1": "W"})
    content = (tmp_path / "a.re2").read_bytes()
    count = int(np.frombuffer(content, "<f8", 1, 84 + 200 * mesh.n_hexes + 8)[0])
    rows = np.frombuffer(content, "<f8", 8 * count, 84 + 200 * mesh.n_hexes + 16).reshape(count, 8)
    letters = [row[7:].tobytes()[:3] for row in rows]
    per_layer = 6
    assert count == 2 * (per_layer + 4 * 3 + 4 * 2)  # caps of 3 times 2, four layers of sides of 3 and 2
    assert letters.count(b"W  ") == 12
    assert letters.count(b"P  ") == 2 * per_layer
    assert letters.count(b"MSH") == count - 12 - 2 * per_layer
    last = mesh.n_hexes - per_layer
    partners = {(a, b): (c, d) for (a, b, c, d, *_), own in zip(rows, letters, strict=True) if own == b"P  "}
    ahead = {(j, 5.0): (last + j, 6.0) for j in range(1, per_layer + 1)}
    assert partners == ahead | {there: here for here, there in ahead.items()}


def test_what_nek_cannot_have_is_refused(tmp_path):
    mesh = two_parts()
    with pytest.raises(InputError, match="nodes=20"):
        io.write(bent_box(27), tmp_path / "a.re2")
    with pytest.raises(InputError, match="side_1"):
        io.write(mesh, tmp_path / "a.re2", letters={"side_11": "W"})
    with pytest.raises(InputError, match="1 to 3"):
        io.write(mesh, tmp_path / "a.re2", letters={"side_1": "WALL"})
    apart = replace(mesh, points=np.vstack([mesh.points, mesh.points[:1]]))
    with pytest.raises(InputError, match="at one place"):
        io.write(apart, tmp_path / "a.re2")
    many = replace(mesh, parts={f"p{j}": np.array([j]) for j in range(12)})
    with pytest.raises(InputError, match="groups=False"):
        io.write(many, tmp_path / "a.re2")
    io.write(many, tmp_path / "a.re2", groups=False)
    assert io.read(tmp_path / "a.re2").parts == {}


@pytest.mark.skipif(not PYTHON.exists(), reason="no .venv-readers: run python scripts/make_readers.py")
def test_pymech_sees_corners_middles_of_bent_edges_and_identifiers(tmp_path):
    mesh = bent_box(20)
    io.write(mesh, tmp_path / "a.re2")
    found = seen(PYMECH, tmp_path / "a.re2")
    np.testing.assert_array_equal(found["corners"], mesh.points[mesh.hexes[:, :8]])
    for row, (kinds, middles) in zip(mesh.hexes, found["curved"], strict=True):
        for edge in range(12):
            if kinds[edge] == "m":
                np.testing.assert_array_equal(middles[edge], mesh.points[row[8 + edge]])
        # Bent about y: edges along y are straight.
        assert [bool(kind) for kind in kinds] == [False] * 8 + [True] * 4
    sides = {1: 2, 2: 3, 3: 4, 4: 5, 5: 0, 6: 1}
    named = {}
    for hex_id, face, letter, values in found["conditions"]:
        assert letter == "MSH"
        named.setdefault(int(values[4]), []).append(mesh.hexes[hex_id, HEX_FACES[sides[face + 1]]])
    for number, name in enumerate(["source", "target", "side_1", "side_2", "side_3", "side_4"], 1):
        assert sorted(map(sorted, np.array(named[number]).tolist())) == sorted(
            map(sorted, mesh.boundaries[name][:, :4].tolist())
        )
