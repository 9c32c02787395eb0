"""Build the documentation as a site.

    python scripts/build_docs.py [FOLDER]

The site, by default ``site/``, needs no server and loads nothing from the network. Needs ``pip install
"cadsweep[docs]"``; exit code 1 where a link leads nowhere or a name of the reference is not found.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def main(arguments: list[str]) -> int:
    """Run MkDocs; warnings are errors."""
    root = Path(__file__).parents[1]
    folder = Path(arguments[0] if arguments else root / "site").resolve()
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    command += ["--config-file", str(root / "mkdocs.yml"), "--site-dir", str(folder)]
    # The theme's advertisement of its successor is no warning of ours; the package is imported for the command's page.
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(root)}
    done = subprocess.run(command, check=False, env=environment)
    if done.returncode == 0:
        print(folder / "index.html")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
