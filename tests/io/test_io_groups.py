"""Names and groups, for any that a user may have."""

from __future__ import annotations

import string
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cadsweep import io
from cadsweep.io.labels import make_blocks
from cadsweep.io.names import portable_names
from cadsweep.mesh import HexMesh

from .io_meshes import box

N_CELLS = 12
LETTERS = string.ascii_letters + string.digits + "_"

sets = st.dictionaries(
    st.text(LETTERS, min_size=1, max_size=4).filter(lambda name: not name[0].isdigit()),
    st.lists(st.integers(0, N_CELLS - 1), min_size=1, unique=True).map(np.array),
    max_size=6,
)


@settings(deadline=None)
@given(st.lists(st.text(max_size=100), unique=True, max_size=8), st.integers(8, 80))
def test_names_become_portable(names, longest):
    found = portable_names(names, max_length=longest)
    assert list(found) == names
    assert len({name.lower() for name in found.values()}) == len(names)
    for name in found.values():
        assert 0 < len(name) <= longest
        assert set(name) <= set(LETTERS)
        assert not name[0].isdigit()
    # What is portable stays, and a second time changes nothing.
    assert list(portable_names(found.values(), max_length=longest).values()) == list(found.values())


@settings(deadline=None)
@given(sets)
def test_blocks_are_disjoint_and_lose_nothing(groups):
    blocks = make_blocks(groups, N_CELLS)
    assert sorted(np.concatenate([blocks.cells(j) for j in range(len(blocks.members))])) == list(range(N_CELLS))
    assert len(set(map(frozenset, blocks.members))) == len(blocks.members)
    for name, ids in groups.items():
        np.testing.assert_array_equal(blocks.named(name), np.sort(ids))
    exclusive = blocks.exclusive_names()
    assert len({name.lower() for name in exclusive}) == len(blocks.members)
    for block, (name, members) in enumerate(zip(exclusive, blocks.members, strict=True)):
        if name in members:  # a group's own name stands for the whole group
            np.testing.assert_array_equal(blocks.cells(block), np.sort(groups[name]))
        else:
            assert name not in groups


@pytest.mark.parametrize("suffix", [".vtu", ".vtkhdf"])
def test_colours_of_the_cad_go_with_the_names(tmp_path, suffix):
    base = box()
    colors = {"boundaries": {"in let": "#12ab34", "target": "#00000080"}, "parts": {"box": "#ffffff"}}
    boundaries = {"in let": base.boundaries["source"], "target": base.boundaries["target"]}
    mesh = replace(base, boundaries=boundaries, info={"colors": colors})
    io.write(mesh, tmp_path / f"part{suffix}")
    back = io.read(tmp_path / f"part{suffix}").info["colors"]
    assert back == {"boundaries": {"in_let": "#12ab34", "target": "#00000080"}, "parts": {"box": "#ffffff"}}
    io.write(base, tmp_path / f"plain{suffix}")
    assert "colors" not in io.read(tmp_path / f"plain{suffix}").info


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    boundaries=st.dictionaries(st.text(max_size=60), st.lists(st.integers(0, 27), min_size=1, unique=True), max_size=4),
    parts=st.dictionaries(st.text(max_size=60), st.lists(st.integers(0, 11), min_size=1, unique=True), max_size=4),
)
def test_any_groups_go_through_every_format(tmp_path, boundaries, parts):
    """Writing compares what was read back itself: it must simply not fail."""
    base = box(2, 2, 3)
    quads = np.concatenate([base.boundaries[name] for name in ("source", "target", "side_1", "side_2", "side_3")])
    mesh = HexMesh(
        points=base.points,
        hexes=base.hexes,
        boundaries={name: quads[np.array(ids) % len(quads)] for name, ids in boundaries.items()},
        parts={name: np.array(ids) for name, ids in parts.items()},
    )
    for suffix in io.FORMATS:
        if suffix in {".pvtu", ".exo"}:
            continue
        io.write(mesh, tmp_path / f"part{suffix}")
        back = io.read(tmp_path / f"part{suffix}")
        assert back.n_hexes == mesh.n_hexes
    io.write(mesh, tmp_path / "part.msh", version="2.2")
