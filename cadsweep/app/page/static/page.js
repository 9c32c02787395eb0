// What a browser alone can do: lines of sight, keys, files, the clipboard, light and dark.
(function () {
  "use strict";
  const pull = (name, ...args) => window.trame.trigger(name, args);
  const view = () => window.trame.refs.view;

  // The line of sight through a pixel, and the width of what is seen where the camera looks.
  function sight(event, element) {
    const camera = view().getCamera();
    const box = element.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    const sub = (a, b) => a.map((v, i) => v - b[i]);
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unit = (a) => { const n = Math.hypot(...a); return a.map((v) => v / n); };
    const ahead = sub(camera.focalPoint, camera.position);
    const distance = Math.hypot(...ahead);
    const forward = unit(ahead), right = unit(cross(forward, camera.viewUp)), up = cross(right, forward);
    const half = distance * Math.tan((camera.viewAngle * Math.PI) / 360);
    const wide = (half * box.width) / box.height;
    const through = camera.focalPoint.map((v, i) => v + x * wide * right[i] + y * half * up[i]);
    const end = through.map((v, i) => camera.position[i] + 50 * (v - camera.position[i]));
    return [camera.position, end, 2 * half * Math.max(1, Math.min(2, box.width / box.height))];
  }

  // A part that is known is not drawn yet: there is no camera, and nothing is picked, before the scene has come.
  let n_drawn = 0, looked = "";
  const every = (one) => [one, ...(one.dependencies || []).flatMap(every)];
  function drawn(scene) {
    const parts = every(scene), camera = parts.find((one) => /Camera$/.test(one.type));
    if (camera && looked !== JSON.stringify(camera.properties.position)) { // another part: the view keeps its camera by itself
      looked = JSON.stringify(camera.properties.position);
      view().setCamera({ ...camera.properties, centerOfRotation: camera.properties.focalPoint });
    }
    n_drawn = parts.filter((one) => /Actor$/.test(one.type)).length;
    document.querySelector("#view").dataset.drawn = n_drawn;
  }

  let down = null, hovering = null, waiting = false, last = 0;
  function watch(element) {
    if (element.dataset.watched) return;
    element.dataset.watched = "yes";
    element.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY, e.button]; }, true);
    element.addEventListener("pointerup", (e) => {
      const still = down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 4 && down[2] === 0;
      down = null;
      if (still && e.button === 0 && n_drawn) pull("pick_at", ...sight(e, element), e.shiftKey || e.ctrlKey || e.metaKey);
    }, true);
    element.addEventListener("pointermove", (e) => {
      hovering = down ? null : e;
      if (!waiting && hovering) { waiting = true; setTimeout(hover, Math.max(0, 80 - (Date.now() - last)), element); }
    });
    element.addEventListener("pointerleave", () => { hovering = null; pull("hover", ""); });
  }
  async function hover(element) {
    const event = hovering;
    last = Date.now();
    try { if (event && n_drawn) await pull("hover_at", ...sight(event, element)); } finally { waiting = false; }
  }

  const typing = (e) => ["INPUT", "SELECT", "TEXTAREA"].includes(e.target.tagName);
  const keys = {
    Escape: () => pull("pick_none"), f: () => pull("pick_kind", "face"), e: () => pull("pick_kind", "edge"),
    s: () => pull("pick_kind", "solid"), t: () => pull("pick_tangent"), k: () => pull("pick_alike"),
    m: () => pull("mesh"), "0": () => view().resetCamera(), "?": () => pull("help"),
    "1": () => tab("ask"), "2": () => tab("mesh"), "3": () => tab("look"), "4": () => tab("take"),
  };
  const tab = (name) => window.trame.state.set("tab", name);
  document.addEventListener("keydown", (e) => {
    if (e.key === "Escape" && typing(e)) { e.target.blur(); return; }
    if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === "z" && !typing(e)) {
      e.preventDefault(); pull(e.shiftKey ? "redo" : "undo"); return;
    }
    if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === "y" && !typing(e)) { e.preventDefault(); pull("redo"); return; }
    if (e.ctrlKey || e.metaKey || e.altKey || typing(e) || !keys[e.key]) return;
    e.preventDefault();
    keys[e.key]();
  });

  const actions = {
    drawn,
    async handUp(event, trigger) {
      const file = event.target.files[0];
      event.target.value = "";
      if (!file) return;
      const answer = await fetch(`hand-up?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
      if (!answer.ok) { pull("say", await answer.text()); return; }
      pull(trigger, (await answer.json()).key);
    },
    async copy(text) {
      try { await navigator.clipboard.writeText(text); } catch (error) {
        const field = document.createElement("textarea");
        field.value = text; document.body.append(field); field.select();
        document.execCommand("copy"); field.remove();
      }
      pull("say", "Copied.");
    },
    async take(name) {
      pull("say", `Writing ${name} ...`);
      const answer = await fetch(`make?name=${encodeURIComponent(name)}`, { method: "POST" });
      if (!answer.ok) { pull("say", await answer.text(), "error"); return; }
      const link = document.createElement("a");
      link.href = `.${(await answer.json()).address}`; link.download = name; link.click();
      pull("say", `${name} is written: it is among your browser's downloads.`);
    },
    picture() {
      view().captureImage("image/png").then((image) => {
        const link = document.createElement("a"), address = URL.createObjectURL(image);
        link.href = address; link.download = `${window.trame.state.get("stem") || "part"}.png`; link.click();
        setTimeout(() => URL.revokeObjectURL(address), 60000);
      });
    },
    reset() { view().resetCamera(); },
  };

  function follow() { // what the state says beyond the template
    const state = window.trame.state;
    const look = () => { document.documentElement.dataset.theme = state.get("theme"); };
    state.addListener(look);
    look();
  }
  window.cadsweep_page = {
    install(app) {
      app.config.globalProperties.$page = actions;
      app.directive("watch", { mounted: watch });
      app.directive("scroll", { updated(el, b) { if (b.value && b.value !== b.oldValue) el.scrollIntoView({ block: "nearest" }); } });
      const wait = setInterval(() => { if (window.trame?.state?.addListener) { clearInterval(wait); follow(); } }, 50);
    },
  };
})();
