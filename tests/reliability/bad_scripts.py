"""Scripts and geometry that are wrong or hard, each in its own way.

``SCRIPTS`` and ``GEOMETRY`` map a name to the source and to how it must end: a regular expression that the
message matches, or ``None`` where either a valid mesh or a named error will do. ``HOSTILE`` need a worker.
"""

HEAD = "import cadquery as cq\n"


def shown(expression):
    return f"{HEAD}show_object({expression})\n"


SCRIPTS = {
    "empty": ("", "shows nothing"),
    "no_python": ("def (:\n", "no Python"),
    "raises": ("raise RuntimeError('the wall is too thin')\n", "line 1.*RuntimeError: the wall is too thin"),
    "raises_later": (HEAD + "x = cq.Workplane().box(1, 1, 1).faces('>Q')\n", "line 2.*raises"),
    "exits": ("import sys\nsys.exit(0)\n", "ends the program"),
    "quits": ("raise SystemExit\n", "ends the program"),
    "interrupts": ("raise KeyboardInterrupt\n", None),
    "shows_nothing": (HEAD + "box = cq.Workplane().box(1, 1, 1)\n", "shows nothing"),
    "shows_two": (shown("cq.Workplane().box(1, 1, 1)") * 2, "shows 2 objects"),
    "shows_a_number": ("show_object(3)\n", "shows a int"),
    "shows_none": ("show_object(None)\n", "NoneType"),
    "shows_empty": (shown("cq.Workplane()"), None),
    "reads_input": ("input()\n", "raises"),
    "recurses": ("def f():\n    f()\nf()\n", "RecursionError"),
    "missing_module": ("import no_such_module\n", "no_such_module"),
    "latin_1": ("# caf\xe9\n", "read"),
}

HARMLESS_SCRIPTS = {
    "prints": "print('x' * 100 * 1000 * 1000)\n" + shown("cq.Workplane().box(1, 1, 1)"),
    "moves": "import os\nos.chdir('/')\n" + shown("cq.Workplane().box(1, 1, 1)"),
    "bom_crlf": "\ufeff" + shown("cq.Workplane().box(1, 1, 1)").replace("\n", "\r\n"),
    "closes_its_output": "import sys\nsys.stdout.close()\n" + shown("cq.Workplane().box(1, 1, 1)"),
}

HOSTILE = {
    "loops": ("while True:\n    pass\n", "time-out.*'cad'"),
    "sleeps": ("import time\ntime.sleep(1e6)\n", "time-out.*'cad'"),
    "nan_height": (shown("cq.Workplane().rect(1, 1).extrude(float('nan'))"), "'cad'"),
    "infinite_height": (shown("cq.Workplane().rect(1, 1).extrude(float('inf'))"), "'cad'"),
    "kills_itself": ("import os\nos.kill(os.getpid(), 9)\n", "SIGKILL.*'cad'"),
    "leaves_at_once": ("import os\nos._exit(0)\n", "'cad'"),
    "crashes": ("import ctypes\nctypes.string_at(0)\n", "SIGSEGV.*'cad'"),
    "eats_memory": ("x = []\nwhile True:\n    x.append(bytearray(10**8))\n", "MemoryError|out of memory"),
}

HANGS = ("loops", "sleeps", "nan_height", "infinite_height")

GEOMETRY = {
    "self_intersecting": (shown("cq.Workplane().polyline([(0,0),(2,2),(2,0),(0,2)]).close().extrude(1)"), None),
    "tangent_hole": (
        shown("cq.Workplane().rect(4, 4).extrude(1).cut(cq.Workplane().center(1, 0).circle(1).extrude(1))"),
        None,
    ),
    "edge_touching": (
        shown("cq.Workplane().box(1, 1, 1).union(cq.Workplane().box(1, 1, 1).translate((1, 1, 0)))"),
        None,
    ),
    "vertex_touching": (
        shown("cq.Workplane().box(1, 1, 1).union(cq.Workplane().box(1, 1, 1).translate((1, 1, 1)))"),
        None,
    ),
    "overlapping": (
        shown("cq.Workplane().box(1, 1, 1).add(cq.Workplane().box(1, 1, 1).translate((0.5, 0, 0)))"),
        "overlap by a volume of 0.5",
    ),
    "zero_height": (shown("cq.Workplane().rect(1, 1).extrude(0)"), None),
    "flat": (shown("cq.Workplane().rect(1, 1).extrude(1e-12)"), None),
    "a_face": (shown("cq.Face.makePlane(1, 1)"), "solid"),
    "a_wire": (shown("cq.Workplane().rect(1, 1)"), "solid|face"),
    "a_vertex": (shown("cq.Vertex.makeVertex(0, 0, 0)"), None),
    "sliver": (
        shown("cq.Workplane().polyline([(0,0),(3,0),(3,1),(1.00001,1),(1,1.00001),(0,2)]).close().extrude(2)"),
        None,
    ),
    "needle": (shown("cq.Workplane().polyline([(0,0),(10,0),(0,0.001)]).close().extrude(1)"), None),
    "sphere": (shown("cq.Workplane().sphere(1)"), None),
    "cone": (shown("cq.Workplane().add(cq.Solid.makeCone(1, 0, 2))"), None),
    "crossing_holes": (
        shown("cq.Workplane().box(4, 4, 4).faces('>Z').workplane().hole(1).faces('>X').workplane().hole(0.6)"),
        None,
    ),
    "hollow": (shown("cq.Workplane().box(3, 3, 3).cut(cq.Workplane().box(1, 1, 1))"), None),
    "infinite": (shown("cq.Workplane().rect(1, 1).extrude(1e200)"), None),
}

SCALES = (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9)


def scaled_plate(scale):
    return shown(f"cq.Workplane().rect({4 * scale!r}, {3 * scale!r}).circle({0.7 * scale!r}).extrude({1 * scale!r})")


def far_box(offset):
    return shown(f"cq.Workplane().box(3, 2, 1).translate(({offset!r}, {-offset!r}, {offset!r}))")
