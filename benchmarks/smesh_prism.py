"""SMESH's Prism_3D on a box, timed: run by the Python that Debian's ``freecad-python3`` belongs to.

    PYTHONPATH=/usr/lib/freecad-python3/lib /usr/bin/python3 benchmarks/smesh_prism.py SEGMENTS LAYERS

Prints one JSON object: hexes, seconds of ``compute`` by the clock and of the processor, bytes of memory above the start
at the peak.
"""

import json
import sys
import time


def peak_bytes() -> int:
    """Peak resident memory of this process."""
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))


def mesh_box(n_segments: int, n_layers: int) -> dict:
    import FreeCAD  # noqa: F401, I001  (before Fem, which crashes without it)
    import Fem
    import Part

    box = Part.makeBox(10, 10, 10)
    upright = [e for e in box.Edges if abs(e.tangentAt(e.FirstParameter).z) > 0.5]
    Fem.FemMesh()  # SMESH numbers hypotheses from the second mesh on
    mesh = Fem.FemMesh()
    mesh.setShape(box)
    kept = []

    def assign(name: str, shape, **settings) -> None:
        hypothesis = getattr(Fem, f"StdMeshers_{name}")(len(kept), mesh)
        for setter, value in settings.items():
            getattr(hypothesis, setter)(value)
        mesh.addHypothesis(hypothesis, shape)
        kept.append(hypothesis)

    assign("Regular_1D", box)
    assign("NumberOfSegments", box, setNumberOfSegments=n_segments)
    if n_layers != n_segments:
        for edge in upright:
            assign("NumberOfSegments", edge, setNumberOfSegments=n_layers)
    assign("Quadrangle_2D", box)
    assign("Prism_3D", box)
    before = peak_bytes()
    start, used = time.perf_counter(), time.process_time()
    mesh.compute()
    seconds, used = time.perf_counter() - start, time.process_time() - used
    return {"hexes": mesh.HexaCount, "seconds": seconds, "processor": used, "bytes": peak_bytes() - before}


if __name__ == "__main__":
    print(json.dumps(mesh_box(int(sys.argv[1]), int(sys.argv[2]))))
