"""Makes .venv-readers: packages that read decks of other codes, some of which want another numpy than this one.

    python scripts/make_readers.py

``tests/io/test_deck_readers.py`` judges what is written by them, where the environment is there.
"""

from __future__ import annotations

import subprocess
import sys
import venv
from pathlib import Path

PACKAGES = ("pyNastran", "mapdl-archive", "lsdyna-mesh-reader", "meshio", "pymech")
FOLDER = Path(__file__).parents[1] / ".venv-readers"

if __name__ == "__main__":
    venv.create(FOLDER, with_pip=True, clear=True)
    subprocess.run([FOLDER / "bin" / "python", "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    sys.stderr.write(f"made {FOLDER}\n")
