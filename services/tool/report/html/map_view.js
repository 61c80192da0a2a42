
// The map that can be turned, in the place of the one from above.
function colourOf(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);
}

function showLegend(data) {
  const list = document.getElementById("map-legend");
  const entry = (paint, text) => {
    const item = document.createElement("li");
    const sign = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    sign.setAttribute("viewBox", "0 0 22 10");
    sign.setAttribute("aria-hidden", "true");
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("d", "M0 5h22");
    line.setAttribute("stroke", `var(--${paint})`);
    line.setAttribute("stroke-width", "4");
    if (paint === "truth") line.setAttribute("stroke-dasharray", "6 4");
    sign.append(line);
    item.append(sign, text);
    list.append(item);
  };
  for (const robot of data.robots) entry(robot.paint, `${robot.name}${robot.own ? " (own)" : ""}: ${robot.count} keyframes`);
  const { shown, total } = data.points;
  entry("ink", shown < total ? `${shown} of ${total} map points` : `${total} map points`);
  if (data.truth.length > 0) entry("truth", "truth");
}

// Pointers turn, move and zoom; `redraw` is called after each change.
function listenToPointers(canvas, camera, redraw) {
  const pointers = new Map();
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y) || 1 };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const two = pointers.size === 2 ? spread() : null;
    const dx = event.clientX - before.x, dy = event.clientY - before.y;
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const height = canvas.clientHeight || 1;
    if (two) {
      const now = spread();
      camera.nearer(now.size / two.size);
      camera.pan((now.x - two.x) / height, (now.y - two.y) / height);
    } else if (event.shiftKey || (event.buttons & 6) !== 0) {
      camera.pan(dx / height, dy / height);
    } else {
      camera.turn(-dx * 0.007, dy * 0.007);
    }
    redraw();
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.nearer(Math.exp(-Math.max(-200, Math.min(200, event.deltaY)) * 0.002));
    redraw();
  }, { passive: false });
}

function listenToKeys(canvas, camera, redraw) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const keys = { "+": () => camera.nearer(1.2), "=": () => camera.nearer(1.2), "-": () => camera.nearer(1 / 1.2),
                 t: () => camera.top(), r: () => camera.reset() };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    const key = keys[event.key.toLowerCase()];
    if (arrow && event.shiftKey) camera.pan(-0.06 * arrow[0], -0.06 * arrow[1]);
    else if (arrow) camera.turn(0.1 * arrow[0], -0.1 * arrow[1]);
    else if (key) key();
    else return;
    event.preventDefault();
    redraw();
  });
}

function showMap() {
  const flat = document.getElementById("map-flat"), view = document.getElementById("map-view");
  const why = document.getElementById("map-why");
  const data = JSON.parse(document.getElementById("map-data").textContent);
  if (!data) { why.hidden = true; return; }
  const canvas = document.getElementById("map");
  const gl = canvas.getContext("webgl", { antialias: true });
  if (!gl) { why.textContent = "This browser has no WebGL for the map in three dimensions; this is the map from above."; return; }
  const painter = new Painter(gl, readScene(data));
  const camera = new Camera(data.centre, data.radius);
  const isShown = (kind) => document.getElementById("show-" + kind).checked;
  const draw = () => {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    painter.draw(camera.matrix(width / height), colourOf, isShown, 1.5 * ratio);
  };
  let waits = false;
  const redraw = () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => { waits = false; draw(); });
  };
  flat.hidden = true;
  view.hidden = false;
  document.getElementById("truth-choice").hidden = data.truth.length === 0;
  showLegend(data);
  listenToPointers(canvas, camera, redraw);
  listenToKeys(canvas, camera, redraw);
  const buttons = { "view-top": () => camera.top(), "view-side": () => camera.reset(),
                    "zoom-in": () => camera.nearer(1.3), "zoom-out": () => camera.nearer(1 / 1.3) };
  for (const [id, act] of Object.entries(buttons)) {
    document.getElementById(id).addEventListener("click", () => { act(); redraw(); });
  }
  for (const kind of ["points", "keyframes", "paths", "truth"]) {
    document.getElementById("show-" + kind).addEventListener("change", redraw);
  }
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  canvas.addEventListener("webglcontextlost", () => {
    view.hidden = true;
    flat.hidden = false;
    why.textContent = "The browser took WebGL away; this is the map from above.";
  });
  draw();
}

try {
  showMap();
} catch (error) {
  document.getElementById("map-view").hidden = true;
  document.getElementById("map-flat").hidden = false;
  document.getElementById("map-why").textContent = "The map in three dimensions can't be shown (" + error.message + "); this is the map from above.";
}
