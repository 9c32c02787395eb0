"""Run the gallery's notebook in a kernel, and turn its interactive view with the mouse in a browser.

    python scripts/check_notebook.py [FOLDER]

Needs the extra ``notebook``, nbclient, ipykernel and Chromium. The notebook is executed as Jupyter would; while its
kernel lives, the view that ``mesh.plot()`` has made (served by trame) is opened in headless Chromium and dragged.
``view.png`` and ``turned.png`` are left in the folder, and ``notebook.ipynb`` with its outputs. Exit code 1 where a
cell fails, no view is made, the picture stays empty, or does not turn.
"""

from __future__ import annotations

import base64
import io
import re
import sys
import tempfile
import time
from pathlib import Path

import nbformat
import numpy as np
from nbclient import NotebookClient
from PIL import Image

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
from tests.view.view_browser import Page, opened  # noqa: E402

NOTEBOOK = ROOT / "models" / "plate.ipynb"


def view_address(notebook: nbformat.NotebookNode) -> str | None:
    """Where the view of the last cell that has one is served."""
    text = "\n".join(str(output.get("data", {})) for cell in notebook.cells for output in cell.get("outputs", []))
    widgets = str(notebook.metadata.get("widgets", ""))
    found = re.findall(r"src=\\?[\"'](http://[^\"'\\]+)", text + widgets)
    return found[-1] if found else None


def main() -> int:
    """Execute, look, say what was found."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(ROOT)}})
    with client.setup_kernel():
        for index, cell in enumerate(notebook.cells):
            client.execute_cell(cell, index)
        client.set_widgets_metadata()
        nbformat.write(notebook, folder / "notebook.ipynb")
        address = view_address(notebook)
        if address is None:
            print("no view: is the extra 'notebook' installed?")
            return 1
        with tempfile.TemporaryDirectory() as profile, opened(address, profile) as page:
            page.wait_for("document.querySelector('canvas') !== null || document.querySelector('img') !== null")
            first = settled(page, folder / "view.png")
            press = {"button": "left", "buttons": 1, "clickCount": 1}
            page.call("Input.dispatchMouseEvent", type="mousePressed", x=320, y=240, **press)
            for x in range(330, 460, 10):
                page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=240, **press)
            page.call("Input.dispatchMouseEvent", type="mouseReleased", x=450, y=240, **press)
            second = settled(page, folder / "turned.png")
    n_colors = len(np.unique(first.reshape(-1, 3), axis=0))
    turned = float((first != second).any(axis=2).mean())
    print(f"{folder}: {n_colors} colours, {turned:.0%} of the pixels change when it is dragged")
    return 0 if n_colors > 50 and turned > 0.02 else 1


def settled(page: Page, path: Path, seconds: float = 90.0) -> np.ndarray:
    """The picture of a page that does not change any more and is not plain, as an array, and as a file."""
    before, end = np.empty(0), time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(3.0)
        data = base64.b64decode(page.call("Page.captureScreenshot")["data"])
        pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
        path.write_bytes(data)
        loading = page.evaluate("document.body.innerText.includes('Loading')")
        if not loading and pixels.shape == before.shape and (pixels == before).all() and pixels.min() < pixels.max():
            break
        before = pixels
    return pixels


if __name__ == "__main__":
    sys.exit(main())
