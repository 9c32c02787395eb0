"""Blocks with random pockets and bosses from both sides: a few of those that benchmarks/blocks.py runs by the dozen."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs
from cadsweep import stacks
from cadsweep.stacks.harmonic import carried
from cadsweep.stacks.places import find_places

_PATH = Path(__file__).parents[2] / "benchmarks" / "generators.py"
_SPEC = importlib.util.spec_from_file_location("generators", _PATH)
generators = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(generators)


@pytest.mark.parametrize(
    "seed",
    [
        0,
        1,
        3,
        4,
        5,  # the ends of two slots of unlike width are tangent to each other
    ],
)
def test_a_block_of_random_pockets_and_bosses_is_meshed(seed):
    part = generators.block(seed, 8, snap=5.0)
    mesh = cs.sweep_mesh(part, size=6.0, decompose=False)
    report = mesh.quality()
    assert report.valid, report.problems
    assert mesh.info["sweeps"][0]["columns"] >= 8
    assert report.volume == pytest.approx(part.val().Volume(), rel=0.02)  # drums of 8 segments lose a tenth, each


def test_slivers_that_cannot_be_merged_leave_no_tolerance_behind():
    # A floor of 0.03 by 0.12 is left between three pockets: the trial to merge it must not blur its corners.
    part = cs.load(generators.block(7))
    assert not any("slivers" in note for note in part.notes)
    assert part.solids[0].tolerance * part.scale < 1e-4


def test_what_is_mended_is_what_the_levels_get(monkeypatch):
    found = []

    def mend(stack, levels, mesh):
        mended = mend_quads(stack, levels, mesh)
        found.append((stack, levels, mesh, mended))
        return mended

    mend_quads = stacks.mend_quads
    monkeypatch.setattr(stacks, "mend_quads", mend)
    cs.sweep_mesh(generators.block(7, 8), size=6.0, decompose=False)
    worst = [[stacks.judge_plane(*own[:2], quads).worst for quads in own[2:]] for own in found]
    before, after = max(worst, key=lambda pair: pair[1] - pair[0])
    assert after > before + 0.04
    stack, levels, mesh, mended = found[worst.index([before, after])]
    # Nodes on lines are on the part's own outlines on every level, whatever was divided otherwise beside them.
    known, places = find_places(stack, levels, mesh), find_places(stack, levels, mended)
    for e, nodes in mesh.edge_nodes.items():
        assert places[:, mended.edge_nodes[e]] == pytest.approx(known[:, nodes], abs=1e-9)
    # What was judged is what is there: mended once more, nothing is worse.
    assert (
        stacks.judge_plane(stack, levels, mend_quads(stack, levels, mended)).lacking
        <= stacks.judge_plane(stack, levels, mended).lacking
    )


def test_both_sides_of_a_narrow_cell_are_carried_together():
    # A strip of width 0.01 between two wide ones: its lower side moves by 1, the far sides stay.
    xs, ys = np.arange(6.0), np.array([-1.0, 0.0, 0.01, 1.0])
    points = np.array([(x, y, 0.0) for y in ys for x in xs])
    quads = np.array([[k, k + 1, k + 7, k + 6] for r in range(3) for k in range(6 * r, 6 * r + 5)])
    row = np.arange(24) // 6
    values = np.where(row == 1, 1.0, 0.0)[:, None]
    found = carried(values, row != 2, quads, points)
    assert found[row == 2].min() > 0.98
    assert found.max() <= 1.0 + 1e-12
