"""A curved face that is one facet wide is judged by its distance from the facet, not by angles it does not have."""

import numpy as np
import pytest

from cadsweep.mesh import HexMesh
from cadsweep.quality import CadReference, check_mesh
from cadsweep.quality.sag import measure_slack

ANGLE = np.pi / 3


def sector(n):
    """A sector of a tube, radii 1 and 2, height 1, of n hexahedra around."""
    t = np.linspace(0, ANGLE, n + 1)
    ring = np.stack([np.cos(t), np.sin(t), np.zeros(n + 1)], axis=1)
    layers = [np.stack([r * p + [0, 0, z] for r, z in ((1, 0), (2, 0), (2, 1), (1, 1))]) for p in ring]
    points = np.concatenate(layers)
    hexes = np.array([[*(4 * k + np.array([0, 3, 2, 1])), *(4 * k + np.array([4, 7, 6, 5]))] for k in range(n)])
    a, b = 4 * np.arange(n), 4 * np.arange(1, n + 1)
    sides = {
        "inner": np.stack([a, a + 3, b + 3, b], axis=1),
        "outer": np.stack([a + 1, b + 1, b + 2, a + 2], axis=1),
        "bottom": np.stack([a, b, b + 1, a + 1], axis=1),
        "top": np.stack([a + 3, a + 2, b + 2, b + 3], axis=1),
        "start": np.array([[0, 1, 2, 3]]),
        "end": np.array([[4 * n, 4 * n + 3, 4 * n + 2, 4 * n + 1]]),
    }
    return HexMesh(points=points, hexes=hexes, boundaries=sides)


def distance(points, name, close):
    """From the exact faces."""
    radius = np.hypot(points[:, 0], points[:, 1])
    along = {"start": points[:, 1], "end": np.sin(ANGLE) * points[:, 0] - np.cos(ANGLE) * points[:, 1]}
    flat = {"inner": radius - 1, "outer": radius - 2, "bottom": points[:, 2], "top": points[:, 2] - 1, **along}
    return flat[name]


def reference(**changes):
    cap = ANGLE / 2 * 3
    values = {
        "volume": cap,
        "areas": {"inner": ANGLE, "outer": 2 * ANGLE, "bottom": cap, "top": cap, "start": 1.0, "end": 1.0},
        "distance": distance,
    }
    return CadReference(**{**values, **changes})


@pytest.mark.parametrize("n", [1, 2, 7])
def test_facets_explain_themselves_however_few_they_are(n):
    report = check_mesh(sector(n), cad=reference())
    assert report.valid, report.problems


def test_what_facets_cannot_explain_is_still_found():
    assert any("volume" in p for p in check_mesh(sector(1), cad=reference(volume=20.0)).problems)
    assert any("'start'" in p for p in check_mesh(sector(1), cad=reference(areas={"start": 1.01})).problems)
    assert not check_mesh(sector(1), cad=reference(distance=None)).valid


def test_a_rim_is_measured_from_both_sides_and_overlapping_names_are_no_sides():
    """Two quads that share an edge whose middle lies 0.1 off one face and 0.2 off the other."""
    points = np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [2, 0, 3], [0, 0, 3]])
    quads = {"floor": np.array([[0, 1, 2, 3]]), "wall": np.array([[1, 0, 5, 4]])}
    off = {"floor": 0.1, "wall": 0.2}

    def away(places, name, close):
        return np.where((places == [1.0, 0.0, 0.0]).all(axis=1), off[name], 0.0)

    apart, same = (measure_slack(points, quads, away, o) for o in (set(), {("floor", "wall"), ("wall", "floor")}))
    bulge = 2 / 3 * 2.0 * 2 * (0.1 + 0.2)  # two thirds of the chord's length times the bound of the bulge
    for name in quads:
        assert apart[name][1] - same[name][1] == pytest.approx(bulge)
        assert same[name][1] == pytest.approx(6.0 * 8 / 3 * (off[name] / 2.0) ** 2)
        assert apart[name][0] == 0.0
