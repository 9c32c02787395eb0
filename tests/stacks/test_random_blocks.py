"""Blocks with random pockets and bosses from both sides: a few of those that benchmarks/blocks.py runs by the dozen."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import cadsweep as cs
from cadsweep import stacks
from cadsweep.stacks import mending

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


def test_what_is_mended_stays_only_where_all_levels_have_gained(monkeypatch):
    calls = []

    def mend(*args):
        calls.append(args)
        return mend_quads(*args)

    mend_quads = stacks.mend_quads
    monkeypatch.setattr(stacks, "mend_quads", mend)
    cs.sweep_mesh(generators.block(2, 8), size=6.0, decompose=False)
    stack, levels, mesh = calls[-1]
    mended = mend_quads(stack, levels, mesh)
    before, after = (stacks.judge_plane(stack, levels, quads) for quads in (mesh, mended))
    assert after.worst > before.worst + 0.2
    # Carried to the levels anew, what was divided otherwise may be folded there.
    true_places = mending.find_places

    def folded(stack, levels, quads):
        places = np.array(true_places(stack, levels, quads))
        return places if quads is mesh else places[:, ::-1]

    monkeypatch.setattr(mending, "find_places", folded)
    assert mend_quads(stack, levels, mesh) is mesh
