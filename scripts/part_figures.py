"""What becomes of parts with the libraries that are installed here, to be compared with other versions of them.

    python scripts/part_figures.py OUT.json [SCRIPT ...]
    python scripts/part_figures.py --compare ONE.json OTHER.json

Without names of scripts, the models, and every third of the parts that ``tests/parts`` has of stacks and of cells. Of
each are written: kinds of faces of every cell, the cuts and their reasons, names and counts of quads, counts of
hexahedra and nodes, the worst scaled Jacobian, or why it is refused. ``--compare`` prints what differs (of quality
only what is more than 0.02 apart) and exits with 1 where faces, cuts, names or counts do. ``scripts/try_versions.py``
makes the environments.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from importlib.metadata import version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
LIBRARIES = ("cadquery", "cadquery-ocp", "gmsh", "numpy", "scipy", "numba")


def chosen() -> list[Path]:
    """Scripts of parts in the checkout."""
    models = [path for path in sorted((ROOT / "models").glob("*.py")) if "show_object" in path.read_text()]
    parts = ROOT / "tests" / "parts"
    return models + sorted((parts / "stacks").glob("*.py"))[::3] + sorted((parts / "decomposed").glob("*.py"))[::3]


def figures(path: Path) -> dict[str, Any]:
    """What is known of one part and its mesh."""
    import cadsweep as cs

    part = cs.load(path)
    cells = [sorted(Counter(face.kind for face in solid.faces).items()) for solid in part.solids]
    try:
        mesh = cs.sweep_mesh(part)
    except cs.CadSweepError as error:
        return {"faces": cells, "refused": str(error).splitlines()[0]}
    return {
        "faces": cells,
        "cuts": [f"{cut.kind}: {cut.reason}" for cut in getattr(getattr(mesh.origin, "part", None), "cuts", ())],
        "boundaries": {name: len(quads) for name, quads in mesh.boundaries.items()},
        "parts": {name: len(ids) for name, ids in mesh.parts.items()},
        "hexes": mesh.n_hexes,
        "nodes": mesh.n_nodes,
        "quality": mesh.quality().min_scaled_jacobian,
    }


def compare(one: dict[str, Any], other: dict[str, Any]) -> int:
    """Print what differs; how many parts do in more than quality."""
    print("versions:", one["versions"], other["versions"], sep="\n  ")
    differing = 0
    for name in sorted(one["parts"].keys() | other["parts"].keys()):
        a, b = one["parts"].get(name, {}), other["parts"].get(name, {})
        keys = [key for key in sorted(a.keys() | b.keys()) if key != "quality" and a.get(key) != b.get(key)]
        differing += bool(keys)
        for key in keys:
            print(f"{name}: {key}:\n  {a.get(key)}\n  {b.get(key)}")
        if abs(a.get("quality", 0.0) - b.get("quality", 0.0)) > 0.02:
            print(f"{name}: quality: {a.get('quality')} {b.get('quality')}")
    print(f"{differing} of {len(one['parts'])} parts differ in faces, cuts, names or counts")
    return differing


def main() -> int:
    """Write figures, or compare two files of them."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("files", nargs="+", type=Path)
    given = parser.parse_args()
    if given.compare:
        one, other = (json.loads(path.read_text()) for path in given.files)
        return int(compare(one, other) > 0)
    found = {}
    for path in given.files[1:] or chosen():
        start = time.perf_counter()
        found[path.stem] = figures(path)
        print(f"{path.stem}: {time.perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
    versions = {name: version(name) for name in LIBRARIES}
    given.files[0].write_text(json.dumps({"versions": versions, "parts": found}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
