"""Parts with caps at many levels, without a hint: meshed as columns, each no worse than its floor; and real ones."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

from cadsweep import load, sweep_mesh

pytestmark = pytest.mark.cad

HERE = Path(__file__).parent
STACKS = sorted((HERE / "stacks").glob("*.py"))
BLOCKS = HERE.parent / "data" / "mfcad"

# Worst scaled Jacobian that every part promises: 0.3 where outlines are a size apart, as in all of them.
FLOORS = dict.fromkeys((path.stem for path in STACKS), 0.3)


@pytest.mark.parametrize("path", STACKS, ids=lambda path: path.stem)
def test_part_is_meshed_no_worse_than_its_floor(path):
    part = load(path)
    # A twentieth of the diagonal: a few thousand hexahedra, walls and ribs one or two wide.
    mesh = sweep_mesh(part, size=part.solids[0].size * part.scale / 20)
    report = mesh.info["quality"]
    assert report.valid, report.problems
    assert report.min_scaled_jacobian >= FLOORS[path.stem]
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=0.05)


@pytest.mark.parametrize(
    "name",
    [
        "3-10-19",  # pockets from three sides
        "10-11-12-12-12-23",  # flat caps at eleven columns
        "0-5-5-7-11-23",  # slanted caps
        "0-1-4-10-12-23",  # a passage whose floor and roof meet at its edges
    ],
)
def test_a_machined_block_is_meshed_to_the_digit(name):
    mesh = sweep_mesh(BLOCKS / f"{name}.step", size=1.0)
    report = mesh.info["quality"]
    assert report.valid, report.problems
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=1e-9)  # all faces are planes
    assert mesh.info["sweeps"][0]["columns"] > 1
