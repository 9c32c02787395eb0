"""MFEM solves on meshes of order p with the rate of order p, and on straight-sided ones with that of order 1."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mfem.ser")
pytest.importorskip("cadquery")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]

SCRIPT = Path(__file__).parents[2] / "scripts" / "solve_orders.py"


def test_the_error_falls_with_the_order_where_the_mesh_bends(tmp_path):
    output = tmp_path / "rates.json"
    done = subprocess.run(
        [sys.executable, SCRIPT, "--orders", "2-3", "--json", output], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for order, row in json.loads(output.read_text(encoding="utf-8")).items():
        assert row["curved power"] > int(order) + 0.8
        assert row["straight power"] < 2.2
        assert row["straight fine"] > 10.0 * row["curved fine"]
