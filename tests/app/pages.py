"""A page of ``cadsweep open`` in a headless Chromium, and what a user does on it."""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time

from ..view.view_browser import find_browser, opened

__all__ = ["find_browser", "served", "visited"]


@contextlib.contextmanager
def served(*arguments, idle="20", **environment):
    """The command, and the address that it printed; it is interrupted in the end, and must end well."""
    process = subprocess.Popen(
        [sys.executable, "-m", "cadsweep", "open", *map(str, arguments), "--no-browser", "--idle", idle],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,  env=os.environ | {"PYTHONUNBUFFERED": "1", **environment},
    )  # fmt: skip
    try:
        ready, _, _ = select.select([process.stdout], [], [], 60)
        address = process.stdout.readline().strip() if ready else ""
        assert address.startswith("http://127.0.0.1:"), (address, process.poll() is not None and process.stderr.read())
        yield process, address
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            raise


class Visitor:
    """A user at one page."""

    def __init__(self, page):
        self.page = page
        page.call("Emulation.setDeviceMetricsOverride", width=1280, height=720, deviceScaleFactor=1, mobile=False)
        page.wait_for("!!window.trame && !!document.querySelector('header.bar')")

    def state(self, name):
        return self.page.evaluate(f"trame.state.get({json.dumps(name)})")

    def wait(self, expression, seconds=120):
        self.page.wait_for(expression, seconds)

    def wait_state(self, name, value, seconds=120):
        self.wait(f"JSON.stringify(trame.state.get({json.dumps(name)})) === {json.dumps(json.dumps(value))}", seconds)

    def wait_drawn(self):
        """Wait until a part is not only known to the page, but drawn on it: with its faces and its edges."""
        self.wait_state("phase", "part")
        self.wait("document.querySelector('#view').dataset.drawn >= 2")

    def wait_enabled(self, selector):
        """Wait for what can be pressed: a click on what cannot yet be is lost."""
        self.wait(f"(e => !!e && !e.disabled)(document.querySelector({json.dumps(selector)}))")

    def press(self, selector):
        self.wait_enabled(selector)
        self.page.evaluate(f"document.querySelector({json.dumps(selector)}).click()")

    def type(self, selector, text):
        self.wait_enabled(selector)
        self.page.evaluate(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.value = {json.dumps(str(text))};"
            "e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); })()"
        )

    def key(self, text):
        self.page.evaluate(
            f"document.dispatchEvent(new KeyboardEvent('keydown', {{key: {json.dumps(text)}, bubbles: true}}))"
        )

    def click_at(self, x, y, modifiers=0):
        """A click of the real mouse, in pixels of the page."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.page.call(
                "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="none" if kind == "mouseMoved" else "left",
                clickCount=0 if kind == "mouseMoved" else 1, modifiers=modifiers,
            )  # fmt: skip

    def where(self, point):
        """The pixel in which a point of the model is seen."""
        return self.page.evaluate(
            """(() => { const p = POINT, c = trame.refs.view.getCamera();
            const b = document.querySelector('#view').getBoundingClientRect();
            const sub = (a, b) => a.map((v, i) => v - b[i]), dot = (a, b) => a[0]*b[0] + a[1]*b[1] + a[2]*b[2];
            const cross = (a, b) => [a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0]];
            const unit = (a) => { const n = Math.hypot(...a); return a.map((v) => v / n); };
            const f = unit(sub(c.focalPoint, c.position)), r = unit(cross(f, c.viewUp)), u = cross(r, f);
            const d = sub(p, c.position);
            const k = b.height / 2 / Math.tan(c.viewAngle * Math.PI / 360) / dot(d, f);
            return [b.left + b.width / 2 + k * dot(d, r), b.top + b.height / 2 - k * dot(d, u)]; })()""".replace(
                "POINT", json.dumps([float(v) for v in point])
            )
        )

    def look_from(self, direction):
        """Turn the camera, so that the middle of what is seen is looked at along a direction."""
        self.page.evaluate(
            """(() => { const v = trame.refs.view, c = v.getCamera(), d = WAY, n = Math.hypot(...d);
            const far = Math.hypot(...c.position.map((p, i) => p - c.focalPoint[i]));
            v.setCamera({...c, position: c.focalPoint.map((p, i) => p - far * d[i] / n),
                viewUp: [0.01, 0.02, 1]}); })()""".replace("WAY", json.dumps([float(v) for v in direction]))
        )

    def saves_to(self, folder):
        """Have what is downloaded put in a folder."""
        folder.mkdir()
        self.folder = folder
        self.page.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))

    def save(self, suffix, name):
        """Choose a format, press the button, and wait for the file."""
        self.type("#format", suffix)
        self.wait_state("format", suffix)
        self.press("#take-mesh")
        return self.saved(self.folder / name)

    def saved(self, path, seconds=60):
        """Wait for a download."""
        end = time.monotonic() + seconds
        while not path.exists():
            assert time.monotonic() < end, f"{path.name} was not saved; {self.state('message')}"
            time.sleep(0.05)
        return path

    def copied(self, selector):
        """What is in the clipboard after a button was pressed."""
        self.page.call("Browser.grantPermissions", permissions=["clipboardReadWrite", "clipboardSanitizedWrite"])
        self.page.evaluate("navigator.clipboard.writeText('')")
        self.press(selector)
        self.wait("navigator.clipboard.readText().then((text) => text.length > 0)")
        return self.page.evaluate("navigator.clipboard.readText()")

    def picture(self, path):
        import base64

        path.write_bytes(base64.b64decode(self.page.call("Page.captureScreenshot")["data"]))

    def outside(self):
        """Addresses that the page asked for, of other servers than its own."""
        own = self.page.evaluate("location.host")
        return [u for u in self.page.requests() if not u.startswith(("data:", "blob:", "about:")) and own not in u]


@contextlib.contextmanager
def visited(address, profile):
    """A user at the address, in a browser of its own."""
    with opened(address, profile) as page:
        yield Visitor(page)
