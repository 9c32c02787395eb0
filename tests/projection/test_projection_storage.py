"""Saved factors give back the same points, bit for bit, from a small file."""

from __future__ import annotations

import os

import numpy as np
import pytest

from cadsweep.errors import InputError
from cadsweep.projection import FactoredSweep, project_layers

from .projection_sections import annulus, dome, rotation, square


def curved_sweep(section, n_layers=10, **options):
    base = section.points
    layers = np.array(
        [
            (base + 0.2 * t * np.sin(2 * base[:, [1, 0, 0]])) @ rotation([1, 0.3, 0.2], t).T + [0, t**2, 4 * t]
            for t in np.linspace(0, 1, n_layers + 1)
        ]
    )
    options.setdefault("target_points", layers[-1])
    return project_layers(base, section.quads, layers[:, section.ring], loops=section.loops, **options)


@pytest.mark.parametrize(
    ("strategy", "with_target"),
    [("source", True), ("source", False), ("advancing", True), ("advancing", False), ("both", True)],
)
@pytest.mark.parametrize("make", [lambda: dome(square()), annulus])
def test_round_trip_is_bit_for_bit(tmp_path, strategy, with_target, make):
    options = {} if with_target else {"target_points": None}
    sweep = curved_sweep(make(), strategy=strategy, **options)
    path = tmp_path / "part.sweep.npz"
    sweep.save(path)
    back = FactoredSweep.load(path)
    assert (back.points() == sweep.points()).all()
    assert (back.basis == sweep.basis).all()
    assert (back.quads == sweep.quads).all()
    assert all((a == b).all() for a, b in zip(back.loops, sweep.loops, strict=True))
    assert (back.ranks == sweep.ranks).all()
    assert (back.conditions == sweep.conditions).all()
    assert (back.strategy, back.functional, back.n_modes) == (sweep.strategy, sweep.functional, sweep.n_modes)
    assert back.quads.dtype == np.int64


def test_the_file_is_much_smaller_than_the_points(tmp_path):
    sweep = curved_sweep(dome(square(40)), n_layers=200)
    path = tmp_path / "part.sweep.npz"
    sweep.save(path)
    assert os.path.getsize(path) < 0.15 * sweep.points().nbytes


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 not a zip", b"hello"])
def test_another_file_is_refused(tmp_path, content):
    path = tmp_path / "other.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"other\.npz"):
        FactoredSweep.load(path)


def test_a_foreign_npz_is_refused(tmp_path):
    path = tmp_path / "foreign.npz"
    np.savez(path, a=np.arange(3))
    with pytest.raises(InputError, match="not a factored sweep"):
        FactoredSweep.load(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.npz"):
        FactoredSweep.load(tmp_path / "nowhere.npz")
