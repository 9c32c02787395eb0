"""Bands that cover only a part of another one's end are given up one after the other, whatever the way it is done."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.brep import Solid
from cadsweep.recognition.bands import Band
from cadsweep.recognition.corners import read_rectangles
from cadsweep.recognition.ends import without_partial_ends
from cadsweep.recognition.layout import _Graph

from .recognition_solids import (
    bevelled_bar,
    box_with_split_side,
    prism,
    regular,
    sharp_bracket,
)

SOLIDS = {
    "split side": box_with_split_side,
    "stations": lambda: prism(regular(5), (0.0, 1.0, 1.5, 3.0)),
    "bevelled": bevelled_bar,
    "bracket": sharp_bracket,
}


def single_faces(solid: Solid, random: np.random.Generator) -> list[Band]:
    """Most rectangles of a solid, each a band by itself that runs one way or the other, in any order."""
    bands = []
    for f in random.permutation(len(solid.faces)).tolist():
        readings = read_rectangles(solid.faces[f], folded=True)
        if readings and random.random() < 0.8:
            reading = readings[int(random.integers(len(readings)))]
            way = int(random.integers(2))
            rails = frozenset(e for k in (way, way + 2) for e in reading.chains[k])
            bands.append(Band(faces={f: (reading, way)}, rails=rails, cost=reading.cost))
    return bands


def met(graph: _Graph) -> list[set[int]]:
    """For every end that several bands or groups of faces meet, the bands among them but the first."""
    several = [partners for partners in graph.partners.values() if len(partners) > 1]
    return [{i for kind, i, _ in partners if kind == "band" and i != 0} for partners in several]


@pytest.mark.parametrize("name", SOLIDS)
def test_the_first_end_that_several_meet_gives_them_up_until_there_is_none(name):
    solid = SOLIDS[name]()
    n_given_up = 0
    for seed in range(30):
        bands = single_faces(solid, np.random.default_rng(seed))
        left = bands
        while True:
            drop = next((each for each in met(_Graph(solid, left)) if each), None)
            if drop is None:
                break
            left = [band for i, band in enumerate(left) if i not in drop]
        assert without_partial_ends(solid, bands) == left
        n_given_up += len(bands) - len(left)
    assert n_given_up > 0, "nothing was tried"
