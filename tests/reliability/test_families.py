"""Over families of parts: a mesh that passes every check, or a named error. Nothing else."""

import math
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import cadsweep
from cadsweep.errors import CadSweepError
from cadsweep.quality import check_mesh

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
from .families import TYPICAL, members, options

pytestmark = [pytest.mark.cad, pytest.mark.timeout(0)]

N = int(os.environ.get("CADSWEEP_EXAMPLES", "20"))
slow = settings(
    max_examples=N, deadline=None, derandomize=N <= 20, suppress_health_check=list(HealthCheck), database=None
)


def build(member):
    """The solid, or None where CadQuery itself cannot make it; its own failures are not our subject."""
    family, numbers = member
    try:
        return family(*numbers)
    except Exception:
        return None


def ending(solid, **chosen):
    """The mesh, or what is said where there is none; any error without a name of ours fails the test."""
    try:
        return cadsweep.sweep_mesh(solid, **chosen), ""
    except CadSweepError as error:
        return None, str(error)


@slow
@given(member=members, chosen=options, coarseness=st.floats(0.1, 0.5))
def test_a_valid_mesh_or_a_named_error(member, chosen, coarseness):
    solid = build(member)
    if solid is None:
        return
    size = coarseness * abs(solid.Volume()) ** (1 / 3)
    if not 0 < size < math.inf:
        return
    mesh, refusal = ending(solid, size=size, max_hexes=50_000, **chosen)
    if mesh is None:
        assert len(refusal) > 20
        return
    report = check_mesh(mesh)
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > 0
    assert np.isfinite(mesh.points).all()


@slow
@given(
    width=st.floats(1e-3, 1e3), height=st.floats(1e-3, 1e3), thickness=st.floats(1e-3, 1e3), layers=st.integers(1, 5)
)
def test_every_box_is_meshed(width, height, thickness, layers):
    """No box is refused, unless it asks for more hexes than are allowed."""
    import cadquery as cq

    box = cq.Workplane().box(width, height, thickness)
    mesh, refusal = ending(box, layers=layers, max_hexes=20_000)
    if mesh is None:
        assert "beyond the limit" in refusal
        return
    volume = width * height * thickness
    assert math.isclose(check_mesh(mesh).volume, volume, rel_tol=1e-9)
    assert mesh.info["sweeps"][0]["layers"] == layers


@pytest.mark.parametrize("family", TYPICAL)
def test_most_of_a_family_is_meshed(family):
    """Of what an engineer would draw, nine of ten; here ten are drawn, of which one may be refused."""
    rng = np.random.default_rng(0)
    refusals = []
    for _ in range(10):
        solid = TYPICAL[family](rng.uniform)
        mesh, refusal = ending(solid, size=0.3 * solid.Volume() ** (1 / 3), max_hexes=50_000)
        if mesh is None:
            refusals.append(refusal)
        else:
            assert check_mesh(mesh).valid
    assert len(refusals) <= 1, refusals
