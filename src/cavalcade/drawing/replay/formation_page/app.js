// Time, keys and pointers.
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
const wish = new URLSearchParams(location.hash.slice(1));
const clockState = { t: begin, speed: 1, playing: false, last: 0, dirty: true };

const LAYERS = [
  ["paths", "p", "paths"], ["trails", "t", "trails"], ["goals", "g", "goals"], ["springs", "s", "springs"],
  ["labels", "l", "slots"], ["roles", "c", "colour by slot"], ["follow", "f", "follow"],
];
const buttons = {};
for (const [name, key, text] of LAYERS) {
  const button = element("button", byId("layers"), text);
  button.title = `${text} (${key.toUpperCase()})`;
  button.addEventListener("click", () => toggle(name));
  buttons[name] = button;
}
function toggle(name, value = !shown[name]) {
  shown[name] = value;
  buttons[name].setAttribute("aria-pressed", String(value));
  if (name === "follow" && !value) fit();
  if (name === "follow" && value) follow(stateAt(clockState.t), 1);
  refresh();
}
function refresh() { clockState.dirty = true; }
function relay() { for (const chart of charts) chart.dirty = true; camera.dirty = true; refresh(); }

const ICON = {
  play: '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M3 1.5v13l11-6.5z"/></svg>',
  pause: '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M2.5 1.5h4v13h-4zM9.5 1.5h4v13h-4z"/></svg>',
};
function play(on = !clockState.playing) {
  if (on && clockState.t >= finish - 1e-6) clockState.t = begin;
  clockState.playing = on && finish > begin;
  clockState.last = performance.now();
  byId("play").innerHTML = clockState.playing ? ICON.pause : ICON.play;
  byId("play").setAttribute("aria-label", clockState.playing ? "Pause" : "Play");
  refresh();
}
function seek(t) {
  clockState.t = Math.min(finish, Math.max(begin, t));
  if (shown.follow) follow(stateAt(clockState.t), 1);
  refresh();
}
function speed(index) {
  const at = Math.min(SPEEDS.length - 1, Math.max(0, index));
  clockState.speed = SPEEDS[at];
  byId("speed").selectedIndex = at;
}
function theme(name) {
  document.documentElement.dataset.theme = name;
  readTheme();
  relay();
}
for (const value of SPEEDS) element("option", byId("speed"), `${value}×`);
byId("speed").addEventListener("change", (event) => { speed(event.target.selectedIndex); event.target.blur(); });
byId("play").addEventListener("click", () => play());
byId("seek").addEventListener("input", (event) => seek(begin + ((finish - begin) * event.target.value) / 1000));
byId("theme").addEventListener("click", () => theme(isDark() ? "light" : "dark"));
byId("ask").addEventListener("click", () => byId("help").showModal());
byId("help").addEventListener("click", (event) => { if (event.target === byId("help")) byId("help").close(); });
element("b", byId("clock"));
element("span", byId("clock"), ` / ${finish.toFixed(1)} s`);

const STEP = () => times[Math.min(1, times.length - 1)] - times[0] || 0.05;
const KEYS = [
  [["Space"], "play or pause", [" ", "k"], () => play()],
  [["←", "→"], "one second back or on; with Shift five", [], null],
  [[",", "."], "one frame back or on", [], null],
  [["Home", "End"], "to the start or the end", [], null],
  [["↑", "↓"], "faster or slower", [], null],
  [["F"], "follow the team", [], null],
  [["0"], "see the whole arena again", ["0"], () => { toggle("follow", false); fit(); }],
  [["P", "T", "G", "S", "L"], "paths, trails, goals, springs, slot numbers", [], null],
  [["C"], "colour by robot or by slot", [], null],
  [["D"], "light or dark", ["d"], () => theme(isDark() ? "light" : "dark")],
  [["?"], "these keys", ["?"], () => byId("help").showModal()],
];
for (const [keys, text] of KEYS) {
  const name = element("dt", byId("keys"));
  for (const key of keys) { element("kbd", name, key); name.append(" "); }
  element("dd", byId("keys"), text);
}
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help").open || event.target.tagName === "SELECT") return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (key === " " && event.target.tagName === "BUTTON" && event.target.id !== "play") return;
  const far = event.shiftKey ? 5 : 1, index = SPEEDS.indexOf(clockState.speed);
  const moves = {
    ArrowLeft: () => seek(clockState.t - far), ArrowRight: () => seek(clockState.t + far),
    ",": () => { play(false); seek(clockState.t - STEP()); }, ".": () => { play(false); seek(clockState.t + STEP()); },
    Home: () => seek(begin), End: () => seek(finish),
    ArrowUp: () => speed(index + 1), ArrowDown: () => speed(index - 1),
  };
  const layer = LAYERS.find((entry) => entry[1] === key);
  const action = moves[key] || KEYS.find((entry) => entry[2].includes(key))?.[3] || (layer && (() => toggle(layer[0])));
  if (!action) return;
  event.preventDefault();
  action();
});

// Drag to move, wheel or pinch to zoom, double click for the whole arena.
const fingers = new Map();
function zoom(factor, x, y) {
  const wx = camera.x + (x - width / 2) / camera.scale, wy = camera.y - (y - height / 2) / camera.scale;
  camera.scale = Math.min(2000, Math.max(1, camera.scale * factor));
  camera.x = wx - (x - width / 2) / camera.scale;
  camera.y = wy + (y - height / 2) / camera.scale;
  camera.fitted = false;
  camera.dirty = true;
  refresh();
}
view.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.offsetX, event.offsetY);
}, { passive: false });
view.addEventListener("pointerdown", (event) => {
  view.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  view.classList.add("drag");
});
view.addEventListener("pointermove", (event) => {
  const old = fingers.get(event.pointerId);
  if (!old) return;
  const now = [event.offsetX, event.offsetY], other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
  fingers.set(event.pointerId, now);
  if (other) {
    const was = Math.hypot(old[0] - other[0], old[1] - other[1]), is = Math.hypot(now[0] - other[0], now[1] - other[1]);
    zoom(is / (was || 1), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    return;
  }
  if (shown.follow && Math.hypot(now[0] - old[0], now[1] - old[1]) > 1) {
    shown.follow = false;
    buttons.follow.setAttribute("aria-pressed", "false");
  }
  camera.x -= (now[0] - old[0]) / camera.scale;
  camera.y += (now[1] - old[1]) / camera.scale;
  camera.fitted = false;
  camera.dirty = true;
  refresh();
});
for (const kind of ["pointerup", "pointercancel"])
  view.addEventListener(kind, (event) => { fingers.delete(event.pointerId); view.classList.toggle("drag", fingers.size > 0); });
view.addEventListener("dblclick", () => { toggle("follow", false); fit(); });
for (const chart of charts) {
  const jump = (event) => {
    if (event.buttons !== 1 || !chart.width) return;
    seek(begin + ((event.offsetX - LEFT) / (chart.width - LEFT - RIGHT)) * (finish - begin));
  };
  chart.canvas.addEventListener("pointerdown", (event) => { chart.canvas.setPointerCapture(event.pointerId); jump(event); });
  chart.canvas.addEventListener("pointermove", jump);
}

function render() {
  clockState.dirty = false;
  const state = stateAt(clockState.t);
  if (shown.follow && clockState.playing) follow(state, 0.12);
  drawStage(state);
  drawStatus(state);
  drawCharts(state.t);
  drawBand(state.t);
  const part = Math.round(((state.t - begin) / (finish - begin || 1)) * 1000);
  if (+byId("seek").value !== part) byId("seek").value = part;
  byId("seek").setAttribute("aria-valuetext", `${state.t.toFixed(1)} seconds`);
}
function frame(now) {
  if (clockState.playing) {
    const dt = Math.min(0.1, (now - clockState.last) / 1000);
    clockState.last = now;
    clockState.t = Math.min(finish, clockState.t + dt * clockState.speed);
    if (clockState.t >= finish) play(false);
    refresh();
  }
  if (clockState.dirty) render();
  requestAnimationFrame(frame);
}

const darkWish = matchMedia("(prefers-color-scheme: dark)");
darkWish.addEventListener("change", (event) => theme(event.matches ? "dark" : "light"));
document.documentElement.dataset.theme = wish.get("theme") || (darkWish.matches ? "dark" : "light");
readTheme();
resize();
fit();
for (const [name] of LAYERS) toggle(name, shown[name]);
// Drawn at once: a canvas that gets a new size is empty until then.
const laidOut = new ResizeObserver(() => { resize(); relay(); render(); });
for (const part of [byId("stage"), byId("line"), document.querySelector("aside")]) laidOut.observe(part);
speed(SPEEDS.indexOf(+(wish.get("speed") || 1)) < 0 ? 3 : SPEEDS.indexOf(+(wish.get("speed") || 1)));
for (const name of (wish.get("show") || "").split(",")) if (name in shown) toggle(name, true);
for (const name of (wish.get("hide") || "").split(",")) if (name in shown) toggle(name, false);
seek(+(wish.get("t") || begin));
play(wish.has("play") ? wish.get("play") === "1" : !wish.has("t") && !matchMedia("(prefers-reduced-motion: reduce)").matches);
requestAnimationFrame(frame);
