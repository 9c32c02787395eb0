"""What is known of a mesh: typed fields, and a read-only mapping of those that are known."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

from cadsweep.mesh import HexMesh
from cadsweep.record import MeshRecord


def cube(**info):
    points = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    return HexMesh(points=points, hexes=np.arange(8)[None], boundaries={}, info=info)


def test_the_mapping_has_what_is_known_and_nothing_else():
    record = MeshRecord(part="lid", notes=[], cad_volume=2.0)
    assert dict(record) == {"part": "lid", "cad_volume": 2.0, "notes": []}
    assert len(record) == 3
    assert "material" not in record
    assert record.get("material") is None
    with pytest.raises(KeyError):
        record["material"]
    assert record == {"notes": [], "cad_volume": 2.0, "part": "lid"}
    assert json.loads(json.dumps(dict(record))) == record


def test_a_mapping_given_to_a_mesh_becomes_a_record_and_cannot_be_changed():
    given = {"part": "lid", "my own": 3}
    mesh = cube(**given)
    assert mesh.info == given
    assert mesh.record.part == "lid"
    assert mesh.record.extra == {"my own": 3}
    with pytest.raises(TypeError):
        mesh.info["part"] = "box"
    with pytest.raises(AttributeError):
        mesh.record.part = "box"
    changed = replace(mesh, info=mesh.info | {"part": "box"})
    assert (mesh.record.part, changed.record.part) == ("lid", "box")
    assert changed.info["my own"] == 3
    assert pickle.loads(pickle.dumps(changed)).info == changed.info


def test_every_field_is_explained():
    assert all(f"    {name} : " in MeshRecord.__doc__ for name in MeshRecord.__dataclass_fields__)
