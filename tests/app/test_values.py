"""The page's values without a browser: wishes, their history, what is taken away, who is let in, what is seen."""

import shlex

import click.testing
import numpy as np
import pytest

from cadsweep.app.entities import Entity, PartData, all_tangent, same_kind
from cadsweep.app.guard import Guard
from cadsweep.app.jobs import Job, Stage
from cadsweep.app.meshing import _stages
from cadsweep.app.picking import pick
from cadsweep.app.session import Session
from cadsweep.app.skins import Look, find_quads, make_view
from cadsweep.app.taking import to_command, to_script
from cadsweep.app.wishes import Asked, Wish, make_wish
from cadsweep.cli.making import mesh as mesh_command
from cadsweep.cli.mesh_options import checked_options
from cadsweep.errors import InputError
from cadsweep.mesh import HexMesh


def cube(names=("left", "right"), solids=1):
    """Two faces of a unit cube's worth of picture, with an edge between them, for each solid."""
    entities, chains, points, triangles, owners = {}, {}, [], [], []
    for j in range(solids):
        entities[f"solid:{j}"] = Entity(key=f"solid:{j}", name=f"s{j}", shape="solid", measure=1.0, place=(0, 0, 0))
        for f, name in enumerate(names):
            key = f"face:{j}:{f}"
            entities[key] = Entity(
                key=key, name=name if solids == 1 else "", shape="plane", measure=1.0, place=(f, 0.5, j),
                neighbours=(f"edge:{j}:0",),
            )  # fmt: skip
            corners = np.array([[f, 0, j], [f + 1, 0, j], [f + 1, 1, j], [f, 1, j]], dtype=float)
            triangles += [
                [len(points), len(points) + 1, len(points) + 2],
                [len(points), len(points) + 2, len(points) + 3],
            ]
            points += corners.tolist()
            owners += [j * len(names) + f] * 2
        entities[f"edge:{j}:0"] = Entity(
            key=f"edge:{j}:0", shape="line", measure=1.0, place=(1, 0.5, j), tangent=True,
            neighbours=(f"face:{j}:0", f"face:{j}:1"),
        )  # fmt: skip
        chains[f"edge:{j}:0"] = np.array([[1.0, 0, j], [1, 1, j]])
    points = np.array(points)
    return PartData(
        name="cube", entities=entities, points=points, normals=np.zeros_like(points), triangles=np.array(triangles),
        owners=np.array(owners), chains=chains,
    )  # fmt: skip


FIELDS = {"size": "0.5", "count": "7", "ratio": "3", "towards": "both", "first": "0.05", "growth": "1.2", "n": "4"}


def every_wish(part):
    asked = Asked().with_whole("size", 2.0).with_whole("order", 2).with_whole("max_hexes", 10**6)
    for kind, on in (
        ("name", "face:0:0"), ("size", "face:0:0"), ("size", "edge:0:0"), ("count", "edge:0:0"), ("bias", "edge:0:0"),
        ("walls", "face:0:1"), ("suppress", "face:0:1"), ("cut", "face:0:0"),
    ):  # fmt: skip
        asked = asked.with_wish(make_wish(kind, [on], FIELDS | {"name": "in let"}, part))
    return asked.with_wish(make_wish("partner", ["face:0:0", "face:0:1"], {}, part))


def parsed(command):
    """The options that the command line makes of a command's words."""
    words = shlex.split(command)[2:]
    with mesh_command.make_context("mesh", words) as context:
        given = {
            key: value
            for key, value in context.params.items()
            if key not in {"input_file", "output", "like", "family", "stream", "timeout", "as_json", "quiet", "verbose"}
        }
        writing = {
            "version",
            "element",
            "first_node",
            "first_element",
            "prefix",
            "ties",
            "patch_types",
            "letters",
            "structured",
            "max_blocks",
            "scale",
            "units",
        }
        found = checked_options("part.step", {k: v for k, v in given.items() if k not in writing | {"max_memory"}})
    from cadsweep.options import SweepOptions

    usual = SweepOptions()
    return {key: value for key, value in found.items() if value != getattr(usual, key)}


@pytest.mark.parametrize("solids", [1, 2])
def test_the_command_and_the_script_say_what_the_options_say(solids):
    part = cube(solids=solids)
    options = every_wish(part).options(part)
    as_lists = {
        k: {n: [v] if isinstance(v, str) else v for n, v in o.items()} if k == "names" else o
        for k, o in options.items()
    }
    assert parsed(to_command("part.step", "a.inp", options)) == as_lists
    seen = {}

    class Mesh:
        write = quality = lambda self, *a: None

    import cadsweep as cs

    kept = cs.sweep_mesh
    try:
        cs.sweep_mesh = lambda source, **given: seen.update(given) or Mesh()
        exec(to_script("part.step", "a.inp", options), {"print": lambda *a: None})
    finally:
        cs.sweep_mesh = kept
    given = {**seen, "wall_layers": {k: vars(v) for k, v in seen["wall_layers"].items()}}
    given["biases"] = {k: {a: b for a, b in vars(v).items() if b is not None} for k, v in seen["biases"].items()}
    assert given == options


def test_faces_of_several_solids_get_names_for_what_is_asked_of_them():
    part = cube(solids=2)
    options = Asked().with_wish(Wish(kind="size", on=("face:1:0",), value=0.5)).options(part)
    ((name, word),) = options["names"].items()
    assert word == "s1: face 0"
    assert options["sizes"] == {f"faces:{name}": 0.5}


def test_undo_gives_back_what_was_and_redo_what_was_undone():
    session, part = Session(), cube()
    states = [session.asked]
    for number in (1.0, 2.0, 3.0):
        session.ask(session.asked.with_whole("size", number))
        states.append(session.asked)
    for state in reversed(states[:-1]):
        session.undo()
        assert session.asked == state
    assert not session.can_undo
    session.redo()
    assert session.asked == states[1]
    session.ask(every_wish(part))
    assert not session.can_redo


def test_a_session_file_opens_again_and_a_damaged_one_is_refused():
    part = cube()
    session = Session(source="part.step", params={"a": 1})
    session.ask(every_wish(part))
    again = Session.from_json(session.to_json())
    assert (again.asked.options(part), again.source, again.params) == (
        session.asked.options(part),
        "part.step",
        {"a": 1},
    )
    for text in ("", "[]", "{}", session.to_json()[:-20], session.to_json().replace('"walls"', '"wall"')):
        with pytest.raises(InputError):
            Session.from_json(text)


@pytest.mark.parametrize(
    ("kind", "picked", "fields"),
    [
        ("size", ["face:0:0"], {"size": "-1"}), ("size", ["face:0:0"], {"size": "wide"}), ("size", [], {"size": "1"}),
        ("count", ["edge:0:0"], {"count": "1.5"}), ("count", ["face:0:0"], {"count": "3"}),
        ("name", ["face:0:0"], {"name": " "}),
        ("walls", ["face:0:0"], {"first": "1", "growth": "1.2", "n": ""}), ("partner", ["face:0:0"], {}),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_said(kind, picked, fields):
    with pytest.raises(InputError):
        make_wish(kind, picked, fields, cube())


def test_who_has_no_token_or_comes_from_elsewhere_is_refused():
    guard = Guard()
    fine = {"host": "127.0.0.1:80", "token": guard.token, "cookie": None, "origin": None, "site": None}
    assert guard.refuses(**fine) is None
    assert guard.refuses(**fine | {"token": None, "cookie": guard.token, "origin": "http://127.0.0.1:80"}) is None
    for change, status in (
        ({"token": None}, 401), ({"token": guard.token[:-1]}, 401), ({"token": ""}, 401), ({"token": "ä"}, 401),
        ({"host": "evil.example:80"}, 403), ({"host": ""}, 403), ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403), ({"origin": "http://127.0.0.1:81"}, 403),
        ({"token": None, "cookie": guard.token, "site": "cross-site"}, 403),
    ):  # fmt: skip
        refused = guard.refuses(**fine | change)
        assert refused is not None, change
        assert refused[0] == status, change
    assert Guard().token != guard.token


def test_a_line_of_sight_meets_the_face_the_edge_and_the_solid():
    part = cube()
    above, below = np.array([0.5, 0.5, 5.0]), np.array([0.5, 0.5, -5.0])
    assert pick(part, above, below, kind="face", width=2.0) == "face:0:0"
    assert pick(part, above, below, kind="solid", width=2.0) == "solid:0"
    assert pick(part, above, below, kind="edge", width=2.0) is None
    near = np.array([0.51, 0, 0])
    assert pick(part, above + near, below + near, kind="edge", width=2.0) == "edge:0:0"
    assert pick(part, above + 5, below + 5, kind="face", width=2.0) is None
    assert set(all_tangent(part, ["face:0:0"])) == {"face:0:0", "face:0:1"}
    assert set(same_kind(part, ["face:0:0"])) == {"face:0:0", "face:0:1"}


def blocks(n):
    """n x n x n unit cubes."""
    ids = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    hexes = np.column_stack([ids[a : n + a, b : n + b, c : n + c].ravel() for a, b, c in corner])
    points = np.stack(np.meshgrid(*[np.arange(n + 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    halves = np.array_split(np.arange(len(hexes)), 2)
    return HexMesh(points=points, hexes=hexes, boundaries={}, info={"blocks": [len(half) for half in halves]})


def test_what_is_seen_of_cubes_is_the_skin_of_those_kept():
    n = 4
    mesh = blocks(n)
    view = make_view(mesh)
    quads, sides = find_quads(mesh.hexes)
    assert len(quads) == 3 * n**2 * (n + 1)  # each of three directions has n + 1 planes of n x n
    assert (sides[:, 1] < 0).sum() == 6 * n**2
    seen = view.surface(Look())
    assert len(seen.quads) == 6 * n**2
    assert np.allclose(view.size, 1.0)
    half = view.surface(Look(axis="x", place=0.5))
    assert half.n_shown == n**3 // 2
    assert len(half.quads) == 2 * n**2 + 4 * n * n // 2
    inner = view.surface(Look(peel=1))
    assert len(inner.quads) == 6 * (n - 2) ** 2
    apart = view.surface(Look(apart=0.5))
    assert len(apart.quads) == 6 * n**2 + 2 * n**2  # both sides of where the blocks meet
    assert view.surface(Look(low=2.0)).n_shown == 0
    for one in (seen, half, inner):
        a, b, c, d = (one.points[one.quads[:, j]] for j in range(4))
        normal = np.cross(c - a, d - b)
        middle = (a + b + c + d) / 4
        assert (np.einsum("ij,ij->i", normal, middle - mesh.points[mesh.hexes[one.behind]].mean(axis=1)) > 0).all()


def test_a_name_given_on_the_command_line_reaches_the_mesh(tmp_path):
    import cadquery as cq

    import cadsweep as cs

    box = cq.Workplane().box(4, 3, 2)
    mesh = cs.sweep_mesh(box, size=1.0, names={"front": "face 0", "sides": [">Y", "<Y"], "rim": "edges:|Z"})
    assert len(mesh.boundaries["front"]) == 6  # 3 x 2 quads of size 1
    assert len(mesh.boundaries["sides"]) == 16
    both = cs.sweep_mesh(box, size=1.0, names={"front": ">X", "FRONT": "<X"})
    assert {"front", "FRONT_2"} <= set(both.boundaries)  # alike to a solver, which knows no case
    with pytest.raises(InputError):
        cs.sweep_mesh(box, size=1.0, names={"front": "face 99"})
    assert "--name" in click.testing.CliRunner().invoke(mesh_command, ["--help"]).output


def test_a_stage_that_says_what_it_is_at_is_one_row():
    names = ("cad", "decomposition", "decomposition, 3 cells open", "decomposition, 1 cells open")
    job = Job(stages=[Stage(name=name, began=float(j), ended=j + 1.0) for j, name in enumerate(names)])
    assert [(row["name"], row["seconds"], row["share"]) for row in _stages(job)] == [
        ("cad", "1.0", ""),
        ("decomposition", "3.0", ""),
    ]
    job.stages[-1].ended = None
    assert _stages(job)[-1]["share"] == "1 cells open"
