"""How near the mesh's boundary comes to the CAD model: asked for, by default, and where it is too far."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline.nearness.cap_sizes import sizes_of_quads

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

pytestmark = pytest.mark.cad

RADIUS, HEIGHT = 10.0, 6.0


@pytest.fixture(scope="module")
def bar():
    return cs.load(cq.Workplane().circle(RADIUS).extrude(HEIGHT))


def off_cylinder(mesh):
    """Greatest distance of the mantle's chords from the cylinder, from the nodes alone."""
    mantle = [quads for quads in mesh.boundaries.values() if np.ptp(mesh.points[quads][..., 2]) > 0]
    ends = np.concatenate([np.stack([q, np.roll(q, -1, axis=1)], axis=-1).reshape(-1, 2) for q in mantle])
    middles = mesh.points[ends].mean(axis=1)
    return float(RADIUS - np.hypot(middles[:, 0], middles[:, 1]).min())


@pytest.mark.parametrize("tolerance", [0.2, 0.02])
def test_a_tolerance_is_kept_and_not_by_far(bar, tolerance):
    mesh = cs.sweep_mesh(bar, tolerance=tolerance, size=4.0, layers=2)
    assert mesh.info["distance"] == pytest.approx(off_cylinder(mesh), abs=1e-9)
    # Counts are whole and even: of the sagitta r (1 - cos(pi / n)), half of what is asked for is not undercut.
    assert 0.4 * tolerance < mesh.info["distance"] <= tolerance


def test_layers_follow_the_tolerance_round_a_bend(elbow):
    mesh = cs.sweep_mesh(elbow, tolerance=0.01, size=2.0)
    # The outermost rail has a radius of 12 and turns by a right angle: chords that sag 0.01 turn by 2 acos(1 - s / r).
    assert mesh.structure.n_layers >= (np.pi / 2) / (2 * np.arccos(1 - 0.01 / 12)) - 1e-9
    assert mesh.info["distance"] <= 0.01


def test_what_was_asked_for_stands_and_is_said(bar):
    mesh = cs.sweep_mesh(bar, tolerance=1e-4, size=4.0, counts={"edges:%CIRCLE": 16}, layers=1)
    assert any("was asked for" in note for note in mesh.info["notes"])
    assert mesh.info["distance"] == pytest.approx(RADIUS * (1 - np.cos(np.pi / 16)))


def test_a_mesh_that_is_another_part_has_to_be_allowed(bar):
    # An octagon has 10 % less area than its circle.
    coarse = {"counts": {"edges:%CIRCLE": 8}, "layers": 2}
    with pytest.raises(cs.CadSweepError, match=r"(?s)-10.0%.*allow_coarse"):
        cs.sweep_mesh(bar, **coarse)
    mesh = cs.sweep_mesh(bar, allow_coarse=True, **coarse)
    assert mesh.info["quality"].volume == pytest.approx(8 / 2 * RADIUS**2 * np.sin(np.pi / 4) * HEIGHT)


@pytest.fixture(scope="module")
def dome():
    """A hexagonal plate with a freeform dome as high as it is wide (20)."""
    corners = [(10 * np.cos(a), 10 * np.sin(a)) for a in np.arange(6) * np.pi / 3]
    plate = cq.Workplane().polyline(corners).close().extrude(3)
    rim = cq.Workplane().workplane(offset=3).polyline(corners).close().wire().vals()[0]
    ridge = [cq.Vector(r * x, r * y, 3 + 20 * (1 - r * r)) for r in (0.35, 0.65) for x, y in corners]
    top = cq.Face.makeNSidedSurface(rim.Edges(), [cq.Vector(0, 0, 23), *ridge])
    others = [face for face in plate.faces().vals() if face.Center().z < 3 - 1e-6]
    return cs.load(cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([*others, top]))))


def test_a_dome_as_high_as_wide_is_all_there_and_its_quads_are_alike(dome):
    mesh = cs.sweep_mesh(dome)
    report = mesh.info["quality"]
    assert report.valid
    assert abs(report.volume / mesh.info["cad_volume"] - 1.0) < 0.005
    n = mesh.structure.n_nodes
    lengths = []
    for cap in (mesh.points[:n], mesh.points[-n:]):
        quads = mesh.structure.quads
        corners = cap[quads]
        if np.ptp(corners[..., 2]) > 5.0:
            lengths.append(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2))
    (found,) = lengths
    middle = np.median(found)
    assert middle / 2.5 < found.min()
    assert found.max() < 2.5 * middle


def test_order_two_is_judged_by_its_curved_sides(bar):
    # Parabolas through the middles of eight arcs leave less than a thousandth of the circle.
    mesh = cs.sweep_mesh(bar, counts={"edges:%CIRCLE": 8}, layers=1, order=2)
    assert abs(mesh.info["quality"].volume / mesh.info["cad_volume"] - 1.0) < 1e-3


def under_a_surface(section, height, half):
    """A prism of a section under a freeform surface."""
    at = np.linspace(-half, half, 13)
    surface = cq.Face.makeSplineApprox([[cq.Vector(x, y, height(x, y)) for y in at] for x in at], tol=1e-4)
    pieces = cq.Workplane(obj=section.extrude(30).val().split(surface)).solids().vals()
    return cq.Workplane(obj=min(pieces, key=lambda piece: piece.Center().z))


def test_a_tolerance_is_kept_on_a_small_crown():
    # The crown has a radius of curvature of 2/3: a front of quads of size 1.8 passes by it.
    bell = under_a_surface(cq.Workplane().circle(10), lambda x, y: 3 + 9 * np.exp(-(x * x + y * y) / 12), 13)
    mesh = cs.sweep_mesh(bell, tolerance=0.1, size=1.8, layers=2)
    assert mesh.info["distance"] <= 0.1
    assert not any("asked for" in note for note in mesh.info["notes"])


def test_a_tolerance_is_kept_at_the_rim_of_a_cap():
    """Walls are plane, so only the cap tells that its rim is bent; at the corners it leans by 60 degrees."""
    saddle = under_a_surface(cq.Workplane().polygon(6, 22), lambda x, y: 9 + 0.004 * (x**3 - 3 * x * y * y), 14)
    mesh = cs.sweep_mesh(saddle, tolerance=0.04, size=2.4, layers=2)
    assert mesh.info["distance"] <= 0.04
    assert not any("asked for" in note for note in mesh.info["notes"])
    quads, n = mesh.structure.quads, mesh.structure.n_nodes
    (top,) = (cap for cap in (mesh.points[:n], mesh.points[-n:]) if np.ptp(cap[:, 2]) > 1.0)
    rim = [np.linalg.norm(top[loop] - top[np.roll(loop, 1)], axis=1) for loop in mesh.structure.loops]
    # Alike on the surface: a view from above that is lifted to the nearest place of the face squeezes them by 3.3.
    lengths = np.linalg.norm(top[quads] - top[np.roll(quads, -1, axis=1)], axis=2)
    assert lengths.max() < 2.5 * np.median(lengths)
    # What is bent most has shorter segments than the rest of the rim, and they grow by 1.3.
    ratios = np.concatenate([own / np.roll(own, 1) for own in rim])
    assert 1.0 < max(ratios.max(), 1.0 / ratios.min()) < 1.6


def test_rings_on_a_round_dome_are_even_on_its_surface():
    dome = under_a_surface(cq.Workplane().circle(9), lambda x, y: 12 - 0.06 * (x * x + y * y), 11)
    mesh = cs.sweep_mesh(dome, size=1.5)
    quads, n = mesh.structure.quads, mesh.structure.n_nodes
    (top,) = (cap for cap in (mesh.points[:n], mesh.points[-n:]) if np.ptp(cap[:, 2]) > 1.0)
    lengths = np.linalg.norm(top[quads] - top[np.roll(quads, -1, axis=1)], axis=2)
    assert lengths.min() > 1.5 / 2.5
    assert lengths.max() < 1.5 * 1.5
    # A core of rings has four nodes inside that do not have four quads.
    inner = np.setdiff1d(np.arange(n), np.concatenate(mesh.structure.loops))
    assert (np.bincount(quads.ravel(), minlength=n)[inner] != 4).sum() == 4


def test_short_segments_go_where_a_thin_section_turns():
    """A tip is not cut off, and its segments are no measure for the long walls beside it."""
    at = 2 * np.pi * np.arange(24) / 24 + np.pi / 2
    section = [tuple(p) for p in np.column_stack([10 * np.cos(at), 0.5 * np.sin(at)]).tolist()]
    part = cs.load(cq.Workplane().spline(section, periodic=True).wire().extrude(2))
    mesh = cs.sweep_mesh(part, tolerance=0.01)
    source = mesh.points[: mesh.structure.n_nodes]
    loop = mesh.structure.loops[0]
    begin, steps = source[loop], np.roll(source[loop], -1, axis=0) - source[loop]
    outlines = [e.curve.evaluate(np.linspace(0, 1, 2001)) for e in part.solids[0].edges]
    places = np.concatenate([outline for outline in outlines if np.abs(outline[:, 2] - begin[0, 2]).max() < 1e-9])
    assert np.ptp(places[:, 0]) > 19
    off = places[:, None] - begin
    along = np.clip(np.einsum("psd,sd->ps", off, steps) / np.einsum("sd,sd->s", steps, steps), 0, 1)
    away = np.linalg.norm(off - along[..., None] * steps, axis=2).min(axis=1)
    assert away.max() <= 0.01
    lengths = np.linalg.norm(steps, axis=1)
    assert lengths.max() > 3 * lengths.min()
    assert max(np.maximum(lengths / np.roll(lengths, 1), np.roll(lengths, 1) / lengths)) < 1.6


@pytest.mark.parametrize("base", [False, True], ids=["alone", "on_a_base"])
def test_a_sharp_rim_is_no_farther_off_than_is_said(base):
    """A wavy dish meets its wall at 25 to 51 degrees: there its quads are nearer to it than its chords to the rim."""

    def height(x, y):
        return 6 + 0.06 * (x * x + y * y) + 0.05 * x * y

    part = under_a_surface(cq.Workplane().circle(10), height, 12)
    if base:
        part = cq.Assembly().add(part, name="dish").add(cq.Workplane().circle(10).extrude(-4), name="base")
    mesh = cs.sweep_mesh(part, tolerance=0.05, size=3.0)
    x, y, z = mesh.points.T
    # The spline is within 1e-4 of the formula.
    on_rim = mesh.points[(abs(np.hypot(x, y) - 10) < 1e-6) & (abs(z - height(x, y)) < 1e-3)]
    at = np.sort(np.arctan2(on_rim[:, 1], on_rim[:, 0]))
    middle = at + 0.5 * ((np.roll(at, -1) - at) % (2 * np.pi))
    begin, rim = ([10 * np.cos(a), 10 * np.sin(a)] for a in (at, middle))
    begin, rim = (np.column_stack([*xy, height(*xy)]) for xy in (begin, rim))
    chord = np.roll(begin, -1, axis=0) - begin
    away = rim - begin
    away -= (np.einsum("sd,sd->s", away, chord) / np.einsum("sd,sd->s", chord, chord))[:, None] * chord
    assert len(at) >= 16
    assert np.linalg.norm(away, axis=1).max() <= mesh.info["distance"] + 2e-4
    assert base or mesh.info["distance"] <= 0.05  # inside the caps of cells quads are as large as their size


def test_a_tolerance_is_kept_inside_the_cap_of_a_cell():
    """The rim of the crown's cap is all but flat: what sags are the quads inside."""
    at = np.linspace(-13, 13, 21)
    rows = [[cq.Vector(x, y, 5 + 2 * np.exp(-((x - 2) ** 2 + y**2) / 9)) for y in at] for x in at]
    top = cq.Face.makeSplineApprox(rows, tol=1e-3)
    crown = min(cq.Workplane().circle(10).extrude(12).val().split(top).Solids(), key=lambda solid: solid.Center().z)
    both = cq.Assembly().add(cq.Workplane().box(30, 30, 4).translate((0, 0, -2)), name="base")
    mesh = cs.sweep_mesh(both.add(cq.Workplane(crown), name="crown"), tolerance=0.1, size=3.0)
    assert mesh.info["distance"] <= 0.1
    quads = mesh.points[np.concatenate(list(mesh.boundaries.values()))]
    upper = quads[(quads[:, :, 2] > 4.9).all(axis=1)].mean(axis=1)
    assert len(upper) > 100
    assert max(cq.Vertex.makeVertex(*place).distance(top) for place in upper) <= 0.1


@pytest.mark.parametrize("size", [3.0, 10.0, 50.0])
@pytest.mark.parametrize("kind", ["rod", "bend", "columns", "assembly"])
def test_a_size_is_an_upper_bound_and_a_round_part_keeps_its_shape(kind, size):
    """A size larger than a pin divides it finer, and says so; no part loses what makes it another one."""
    rod = cq.Workplane().circle(4).extrude(16)
    plate = cq.Workplane().box(24, 24, 4)
    model = {
        "rod": rod,
        "bend": cq.Workplane().circle(4).revolve(90, (12, 0, 0), (12, 1, 0)),
        "columns": plate.faces(">Z").workplane().circle(8).extrude(12),
        "assembly": cq.Assembly(name="both").add(plate.cut(rod), name="plate").add(rod, name="pin"),
    }[kind]
    mesh = cs.sweep_mesh(model, size=size)
    report = mesh.info["quality"]
    assert report.valid
    assert report.volume == pytest.approx(mesh.info["cad_volume"], rel=0.05)
    finer = [note for note in mesh.info["notes"] if "divided finer than the size asked for" in note]
    assert finer or kind == "columns"  # the flat plate is most of it


def test_a_cap_that_is_off_at_its_rim_alone_wants_no_finer_quads_inside():
    middles = np.arange(12.0).reshape(4, 3)
    assert sizes_of_quads(middles, np.ones(4), np.full(4, 0.5), None) is None
    finer = sizes_of_quads(middles, np.ones(4), np.full(4, 2.0), None)
    assert finer is not None
    assert finer(middles) == pytest.approx(np.full(4, 0.5))
