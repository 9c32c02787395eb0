"""Compile what ``cadsweep/signatures.txt`` lists, so that nobody waits for it.

    python scripts/compile_kernels.py            into numba's cache: ``install.sh`` does it for a checkout
    python scripts/compile_kernels.py PACKAGE    into PACKAGE/machine_code, for the oldest processor that
                                                 ``cadsweep/compiled.py`` names: ``setup.py`` does it for a wheel

numpy, scipy and numba are enough; a part is not meshed.
"""

from __future__ import annotations

import importlib
import os
import platform
import shutil
import sys
import tempfile
from pathlib import Path


def main() -> int:
    """Compile each loop for each of its signatures."""
    folder = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
    root = folder or Path(__file__).resolve().parents[1] / "cadsweep"
    sys.path.insert(0, str(root.parent))
    if folder is not None:
        kept = tempfile.TemporaryDirectory()  # not beside the modules, where the wheel would take it along
        os.environ["NUMBA_CACHE_DIR"] = kept.name
        shutil.rmtree(folder / "machine_code", ignore_errors=True)  # of an earlier build in the same folder
        (folder / "machine_code").mkdir()
        from cadsweep.processor import BASELINE

        # numba looks at these when it is imported.
        os.environ["NUMBA_CPU_NAME"], os.environ["NUMBA_CPU_FEATURES"] = BASELINE[platform.machine()]

    from numba import types

    from cadsweep.compiled import put_machine_code

    for line in (root / "signatures.txt").read_text().splitlines():
        home, _, asked = line.partition(" ")
        module, _, name = home.partition(":")
        loop = getattr(importlib.import_module(module), name)
        signature = eval(asked, {**vars(types), "bool": types.boolean})
        if folder is None:
            loop.compile(signature)
        else:
            put_machine_code(loop, signature, folder / "machine_code")
    return 0


if __name__ == "__main__":
    sys.exit(main())
