"""Decks as other programs' readers see them, each in an environment of its own (``scripts/make_readers.py``)."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cadsweep import io
from cadsweep.io.nastran import HEX_ORDER
from cadsweep.mesh import HexMesh

from .io_meshes import bent_box, box

PYTHON = Path(__file__).parents[2] / ".venv-readers" / "bin" / "python"
pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="no .venv-readers: run python scripts/make_readers.py")

NASTRAN = """
from pyNastran.bdf.bdf import BDF
m = BDF(debug=False); m.read_bdf(path, xref=False)
title = {}
for line in open(path):
    if line.startswith("$ Femap Load Set"): title[int(line.split()[4])] = line.split(":")[1].strip()
found = {
    "points": [m.nodes[k].xyz.tolist() for k in sorted(m.nodes)],
    "hexes": [m.elements[k].node_ids for k in sorted(m.elements)],
    "across": {title[s]: [[l.eids[0], l.g1, l.g34] for l in own] for s, own in m.loads.items()},
    "nodes": {title[s]: sorted(own.ids) for s, own in m.sets.items()},
}
"""
ANSYS = """
from mapdl_archive import Archive
a = Archive(path, parse_vtk=False)
off, elem = a._elem_off, a._elem
rows = [elem[off[j] + 10 : off[j + 1]].tolist() for j in range(len(off) - 1)]
parts = {k: v.tolist() for k, v in a.element_components.items()}
numbers = a.enum.tolist()
of = dict(zip(numbers, rows))
found = {
    "points": a.nodes.tolist(),
    "hexes": [of[k] for k in parts["box"]],
    "quads": {k[:-5]: [of[e] for e in v] for k, v in parts.items() if k.endswith("_S154")},
    "nodes": {k: sorted(v.tolist()) for k, v in a.node_components.items()},
}
"""
DYNA = """
import lsdyna_mesh_reader
d = lsdyna_mesh_reader.Deck(path)
found = {
    "points": d.node_sections[0].coordinates.tolist(),
    "hexes": d.element_solid_sections[0].node_ids.reshape(-1, 8).tolist(),
}
"""
MESHIO = """
import meshio
m = meshio.read(path)
found = {"points": m.points.tolist(), "hexes": (m.cells[0].data + 1).tolist()}
"""


def seen(reader: str, path: Path) -> dict:
    script = (
        f"import json, sys, numpy as np\npath = sys.argv[1]\n{reader}\nprint('\\n@' + json.dumps(found, default=int))"
    )
    run = subprocess.run([PYTHON, "-c", script, path], capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads(run.stdout.split("\n@")[-1])


@pytest.mark.parametrize("nodes", [8, 20])
def test_pynastran_reads_solids_sides_and_sets(tmp_path, nodes):
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "part.bdf")
    found = seen(NASTRAN, tmp_path / "part.bdf")
    np.testing.assert_allclose(found["points"], mesh.points, rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(np.array(found["hexes"]) - 1, mesh.hexes[:, HEX_ORDER[nodes]])
    assert set(found["across"]) == set(mesh.boundaries)
    for name, quads in mesh.boundaries.items():
        across = np.array(found["across"][name]) - 1
        assert sorted(across[:, 1:].tolist()) == sorted(quads[:, [0, 2]].tolist())
        assert all(set(row[1:]) <= set(mesh.hexes[row[0]]) for row in across.tolist())
        np.testing.assert_array_equal(np.array(found["nodes"][name]) - 1, np.unique(quads))


@pytest.mark.parametrize("nodes", [8, 20])
def test_mapdl_archive_reads_solids_components_and_surface_elements(tmp_path, nodes):
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "part.cdb")
    found = seen(ANSYS, tmp_path / "part.cdb")
    np.testing.assert_allclose(found["points"], mesh.points, rtol=1e-14, atol=1e-15)
    np.testing.assert_array_equal(np.array(found["hexes"]) - 1, mesh.hexes)
    for name, quads in mesh.boundaries.items():
        assert sorted((np.array(found["quads"][name]) - 1).tolist()) == sorted(quads.tolist())
        np.testing.assert_array_equal(np.array(found["nodes"][name]) - 1, np.unique(quads))


def test_mapdl_archive_finds_both_sides_of_a_contact_by_name(tmp_path):
    """Two boxes that share no nodes, one on the other: components of nodes and of surface elements of either side."""
    low, high = box(), box(nx=5, ny=3)
    n, m = low.n_nodes, low.n_hexes
    boundaries = {f"low_{name}": quads for name, quads in low.boundaries.items() if name != "target"}
    boundaries |= {f"high_{name}": quads + n for name, quads in high.boundaries.items() if name != "source"}
    boundaries |= {"low__high_1": low.boundaries["target"], "low__high_2": high.boundaries["source"] + n}
    mesh = HexMesh(
        points=np.concatenate([low.points, high.points + [0, 0, 1]]),
        hexes=np.concatenate([low.hexes, high.hexes + n]),
        boundaries=boundaries,
        parts={"low": np.arange(m), "high": np.arange(m, m + high.n_hexes)},
    )
    io.write(mesh, tmp_path / "part.cdb")
    found = seen(ANSYS.replace('parts["box"]', 'parts["low"] + parts["high"]'), tmp_path / "part.cdb")
    np.testing.assert_array_equal(np.array(found["hexes"]) - 1, mesh.hexes)
    for side in ("low__high_1", "low__high_2"):
        np.testing.assert_array_equal(np.array(found["nodes"][side]) - 1, np.unique(boundaries[side]))
        assert sorted((np.array(found["quads"][side]) - 1).tolist()) == sorted(boundaries[side].tolist())
    pairs = {name[:-2] for name in found["nodes"] if name[-2:] in {"_1", "_2"} and "__" in name}
    assert pairs == {"low__high"}
    assert not set(found["nodes"]["low__high_1"]) & set(found["nodes"]["low__high_2"])


@pytest.mark.parametrize(("suffix", "reader"), [(".k", DYNA), (".bdf", MESHIO)])
def test_mesh_readers_read_nodes_and_hexes(tmp_path, suffix, reader):
    mesh = box()
    io.write(mesh, tmp_path / f"part{suffix}")
    found = seen(reader, tmp_path / f"part{suffix}")
    np.testing.assert_allclose(found["points"], mesh.points, rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(np.array(found["hexes"]) - 1, mesh.hexes)
