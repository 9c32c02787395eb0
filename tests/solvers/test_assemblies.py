"""CalculiX solves on meshes of several solids, with shared nodes and with ties: stresses and fluxes known exactly."""

from __future__ import annotations

import numpy as np
import pytest

import cadsweep as cs

from .calculix import require_calculix, run_deck

pytestmark = [pytest.mark.solver, pytest.mark.cad]

WAYS = ["shared", "separate"]


@pytest.fixture(autouse=True)
def _calculix():
    require_calculix()
    pytest.importorskip("cadquery")


def assembly(**solids):
    import cadquery as cq

    whole = cq.Assembly(name="whole")
    for name, shape in solids.items():
        whole.add(shape, name=name)
    return whole


def block(x, y, z, at=(0, 0, 0)):
    import cadquery as cq

    return cq.Workplane().box(x, y, z, centered=False).translate(at)


def with_hole(z):
    return block(20, 20, 4, (-10, -10, z)).faces(">Z").workplane(origin=(0, 0, 0)).hole(8)


def nodes_at(mesh, axis, value):
    return np.flatnonzero(np.abs(mesh.points[:, axis] - value) < 1e-9)


def node_set(name, nodes):
    return f"*NSET, NSET={name}\n" + ",\n".join(map(str, nodes + 1)) + "\n"


def write_mesh(mesh, folder, n_ties, **options):
    """Write the deck's mesh; a tie a contact stands in it where the solids share nothing."""
    mesh.write(folder / "part.inp", **options)
    assert (folder / "part.inp").read_text().count("*TIE") == n_ties


def elastic(**constants):
    """Materials and sections of parts with (Young's modulus, Poisson's ratio)."""
    return "".join(
        f"*MATERIAL, NAME=M_{part}\n*ELASTIC\n{young}, {poisson}\n*SOLID SECTION, ELSET={part}, MATERIAL=M_{part}\n"
        for part, (young, poisson) in constants.items()
    )


@pytest.mark.parametrize("ways", WAYS)
def test_a_bar_of_two_materials_in_tension(tmp_path, ways):
    """The stress is 100 all over: u_z = s z / E, piece by piece; one nu / E, so that both get narrower alike."""
    bar = assembly(steel=block(4, 4, 10), alloy=block(4, 4, 10, (0, 0, 10)))
    mesh = cs.sweep_mesh(bar, size=1.0, interfaces=ways)
    write_mesh(mesh, tmp_path, 1 if ways == "separate" else 0)
    young = {"steel": 200e3, "alloy": 50e3}
    ratio = 0.3 / 200e3
    low, high = nodes_at(mesh, 2, 0.0), nodes_at(mesh, 2, 20.0)
    x, y, z = mesh.points.T
    corner = low[np.argmin((x + y)[low])]
    along_x = low[np.argmax((x - y)[low])]
    loaded = next(name for name, quads in mesh.boundaries.items() if np.isin(quads, high).all())
    found = run_deck(
        tmp_path,
        f"*INCLUDE, INPUT=part.inp\n*NSET, NSET=EVERY, GENERATE\n1, {mesh.n_nodes}\n{node_set('LOW', low)}"
        f"{elastic(**{part: (e, e * ratio) for part, e in young.items()})}"
        f"*STEP\n*STATIC\n*BOUNDARY\nLOW, 3, 3\n{corner + 1}, 1, 2\n{along_x + 1}, 2, 2\n*DSLOAD\n{loaded}, P, -100.\n"
        "*NODE PRINT, NSET=EVERY\nU\n*END STEP\n",
    )
    u = found["displacements"][np.argsort(found["displacements"][:, 0]), 1:]
    grown = np.where(z <= 10, 100 / young["steel"] * z, 100 / young["steel"] * 10 + 100 / young["alloy"] * (z - 10))
    exact = np.column_stack([-100 * ratio * x, -100 * ratio * y, grown])
    assert np.abs(u - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("ways", WAYS)
def test_a_bolted_pair_pulled_apart(tmp_path, ways):
    """Two plates on a bolt that fills their hole, stretched by 0.001: every solid has the stress E times that.

    The plates have one Poisson's ratio with the bolt, so that nothing else than the pull stresses any of them. Bolt and
    holes get as many segments at this size: a tie holds the chords of unlike ones apart, and stresses them by that.
    """
    import cadquery as cq

    pair = assembly(low=with_hole(0), high=with_hole(4), bolt=cq.Workplane().circle(4).extrude(8))
    mesh = cs.sweep_mesh(pair, size=1.6, interfaces=ways)
    write_mesh(mesh, tmp_path, 3 if ways == "separate" else 0)
    young = {"low": 70e3, "high": 70e3, "bolt": 210e3}
    low, high = nodes_at(mesh, 2, 0.0), nodes_at(mesh, 2, 8.0)
    x, y, _ = mesh.points.T
    corner, along_x = low[np.argmin((x + y)[low])], low[np.argmax((x - y)[low])]
    prints = "".join(f"*EL PRINT, ELSET={part}\nS\n" for part in young)
    found = run_deck(
        tmp_path,
        f"*INCLUDE, INPUT=part.inp\n{node_set('LOW', low)}{node_set('HIGH', high)}"
        f"{elastic(**{part: (e, 0.3) for part, e in young.items()})}"
        f"*STEP\n*STATIC\n*BOUNDARY\nLOW, 3, 3\nHIGH, 3, 3, 0.008\n"
        f"{corner + 1}, 1, 2\n{along_x + 1}, 2, 2\n{prints}*END STEP\n",
    )
    stresses = found["stresses"]
    assert len(stresses) == 8 * mesh.n_hexes
    elements = stresses[:, 0].astype(int) - 1
    for part, e in young.items():
        own = stresses[np.isin(elements, mesh.parts[part])]
        assert np.abs(own[:, 4] - 0.001 * e).max() < 1e-4 * e * 0.001
        assert np.abs(own[:, [2, 3, 5, 6, 7]]).max() < 1e-4 * e * 0.001


def test_a_bolt_in_a_wide_hole_carries_all_of_the_load(tmp_path):
    """Plates that are held by the heads of a bolt alone and pulled apart: its shank has the stress force / section.

    The plates do not hold on to each other: their tie is left out.
    """
    import cadquery as cq

    head = cq.Workplane().circle(8).extrude(3)
    bolt = cq.Workplane().circle(3).extrude(8).union(head.translate((0, 0, 8))).union(head.translate((0, 0, -3)))
    mesh = cs.sweep_mesh(assembly(low=with_hole(0), high=with_hole(4), bolt=bolt), size=2.0, interfaces="separate")
    write_mesh(mesh, tmp_path, 0, ties=False)
    lines = "".join(
        f"*TIE, NAME=T{k}, POSITION TOLERANCE=0.5, ADJUST=NO\n{plate}__bolt_2, {plate}__bolt_1\n"
        for k, plate in enumerate(("low", "high"))
    )
    sides = np.flatnonzero((np.abs(mesh.points[:, :2]) > 10 - 1e-9).any(axis=1))
    held, pulled = (np.intersect1d(sides, mesh.hexes[mesh.parts[part]]) for part in ("low", "high"))
    found = run_deck(
        tmp_path,
        f"*INCLUDE, INPUT=part.inp\n{lines}{node_set('HELD', held)}{node_set('PULLED', pulled)}"
        f"{elastic(low=(70e3, 0.3), high=(70e3, 0.3), bolt=(210e3, 0.3))}"
        f"*STEP\n*STATIC\n*BOUNDARY\nHELD, 1, 3\n*CLOAD\nPULLED, 3, {1000 / len(pulled)}\n"
        "*EL PRINT, ELSET=bolt\nS\n*END STEP\n",
    )
    stresses = found["stresses"][:, 4].reshape(-1, 8).mean(axis=1)
    bolt_hexes = found["stresses"][::8, 0].astype(int) - 1
    z = mesh.points[mesh.hexes[bolt_hexes], 2]
    layer = (z.min(axis=1) < 4.001) & (z.max(axis=1) > 4.001)
    corners = mesh.points[mesh.hexes[bolt_hexes[layer], :4], :2]
    across, other = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    sections = np.abs(across[:, 0] * other[:, 1] - across[:, 1] * other[:, 0]) / 2
    assert sections.sum() == pytest.approx(np.pi * 9, rel=0.05)
    force = (stresses[layer] * sections).sum()
    assert force == pytest.approx(1000, rel=0.01)


@pytest.mark.parametrize("ways", WAYS)
def test_heat_through_three_layers(tmp_path, ways):
    """The flux is the difference of temperatures over the sum of thickness / conductivity."""
    layers = {"brick": (3.0, 0.5), "wool": (5.0, 0.04), "board": (1.0, 0.2)}
    at, solids = 0.0, {}
    for name, (thick, _) in layers.items():
        solids[name] = block(6, 6, thick, (0, 0, at))
        at += thick
    mesh = cs.sweep_mesh(assembly(**solids), size=1.0, interfaces=ways)
    write_mesh(mesh, tmp_path, 2 if ways == "separate" else 0, element="DC3D8")
    materials = "".join(
        f"*MATERIAL, NAME=M_{part}\n*CONDUCTIVITY\n{k}\n*SOLID SECTION, ELSET={part}, MATERIAL=M_{part}\n"
        for part, (_, k) in layers.items()
    )
    prints = "".join(f"*EL PRINT, ELSET={part}\nHFL\n" for part in layers)
    found = run_deck(
        tmp_path,
        f"*INCLUDE, INPUT=part.inp\n{node_set('WARM', nodes_at(mesh, 2, 0.0))}"
        f"{node_set('COLD', nodes_at(mesh, 2, at))}{materials}"
        f"*STEP\n*HEAT TRANSFER, STEADY STATE\n*BOUNDARY\nWARM, 11, 11, 20.\nCOLD, 11, 11, -10.\n{prints}*END STEP\n",
    )
    flux = 30.0 / sum(thick / k for thick, k in layers.values())
    got = found["heat"][:, 2:]
    assert len(got) == 8 * mesh.n_hexes
    assert np.abs(got - [0, 0, flux]).max() < 1e-5 * flux
