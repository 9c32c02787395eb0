"""Add to ``cadsweep/signatures.txt`` the signatures of compiled loops that some tests need.

    python scripts/record_signatures.py tests/cad tests/stacks ...      arguments of pytest

``setup.py`` compiles what that file lists, so that no user waits for it. A signature that is not there is compiled
when it is needed; one that nobody needs any more is taken out by hand.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from cadsweep.compiled import kept_loops

LIST = Path(__file__).parents[1] / "cadsweep" / "signatures.txt"


_ARRAY = re.compile(r"Array\((\w+), (\d), '([ACF])', False, aligned=True\)")


def shown(types: tuple[object, ...]) -> str:
    """Types as numba reads them, arrays by their axes: ``float64[:, ::1]``."""

    def axes(found: re.Match[str]) -> str:
        each = [":"] * int(found[2])
        if found[3] != "A":
            each[-1 if found[3] == "C" else 0] = "::1"
        return f"{found[1]}[{', '.join(each)}]"

    return _ARRAY.sub(axes, repr(types))


def main() -> int:
    """Run the tests in this process, and see what was asked of the loops."""
    failed = pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:xdist", *sys.argv[1:]])
    lines = set(LIST.read_text().splitlines()) if LIST.exists() else set()
    for loop in kept_loops:
        function = loop.py_func
        if function.__module__.startswith("cadsweep."):
            lines |= {f"{function.__module__}:{function.__name__} {shown(types)}" for types in loop.signatures}
    # A loop that is called with a literal is called by another one, which has it inside.
    lines = {line for line in lines if "Literal" not in line}
    LIST.write_text("".join(f"{line}\n" for line in sorted(lines)))
    print(f"{LIST}: {len(lines)} signatures")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
