// What the page carries as `scene`: whole numbers back to metres, seconds and radians.
const scene = JSON.parse(document.getElementById("scene").textContent);
const { begin, end } = scene;
const id = (name) => document.getElementById(name);
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

function element(tag, parent, text = "", kind = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  made.className = kind;
  parent.append(made);
  return made;
}

function button(parent, text, title, action) {
  const made = element("button", parent, text);
  made.title = title;
  made.addEventListener("click", action);
  return made;
}

// What is told in words needs no picture.
id("name").textContent = scene.name;
id("outcome").textContent = scene.outcome.text;
id("outcome").classList.add(scene.outcome.good ? "good" : "bad");
for (const [name, value] of scene.facts) { element("dt", id("numbers"), name); element("dd", id("numbers"), value); }
id("facts").hidden = !scene.facts.length;

function sums(steps, unit) {
  const out = new Float64Array(steps.length);
  let total = 0;
  steps.forEach((step, k) => { total += step; out[k] = total / unit; });
  return out;
}

// Points [x, y] out of x, y, dx, dy, dx, dy, ...
function pairs(steps, unit) {
  const out = [];
  let x = 0, y = 0;
  for (let k = 0; k < steps.length; k += 2) out.push([(x += steps[k]) / unit, (y += steps[k + 1]) / unit]);
  return out;
}

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
  return out.buffer;
}

// A column that was written as 65535 steps of its range.
function column({ low, step, data }) {
  return Float32Array.from(new Uint16Array(bytes(data)), (v) => low + v * step);
}

function placed(origin, x, y) {
  const c = Math.cos(origin[2]), s = Math.sin(origin[2]);
  return [origin[0] + c * x - s * y, origin[1] + s * x + c * y];
}

// Index of the last of the ascending values that is not after v; 0 before the first one.
const itself = (value) => value;
function reached(values, v, of = itself) {
  let low = 0, high = values.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (of(values[middle]) <= v) low = middle; else high = middle - 1;
  }
  return low;
}

// That index, the next one, and how far v is between them.
function between(values, v) {
  const k = reached(values, v), n = Math.min(k + 1, values.length - 1), span = values[n] - values[k];
  return [k, n, span > 0 ? clamp((v - values[k]) / span, 0, 1) : 0];
}

// The ys at x, where they are known at xs.
function along(xs, ys, x) {
  if (!xs.length) return 0;
  const [k, n, f] = between(xs, x);
  return ys[k] + f * (ys[n] - ys[k]);
}

// Points out of x, y, x, y, ... in mm.
const points = (list) => Array.from({ length: list.length / 2 }, (_, k) => [list[2 * k] / 1000, list[2 * k + 1] / 1000]);
const border = points(scene.border);

const terrain = scene.terrain && (() => {
  const t = scene.terrain, x = t.x.map((v) => v / 1000), y = t.y.map((v) => v / 1000);
  const whole = new Uint16Array(bytes(t.heights)), bits = new Uint8Array(bytes(t.blocked));
  const height = Float32Array.from(whole, (v) => t.low + v * t.span / 65000);
  const blocked = (k) => (bits[k >> 3] >> (7 - (k & 7))) & 1;
  return { x, y, height, blocked, origin: t.origin, low: t.low, span: t.span };
})();

// Height of the ground at a place of the map frame.
function groundAt(px, py) {
  if (!terrain) return 0;
  const o = terrain.origin, dx = px - o[0], dy = py - o[1], c = Math.cos(o[2]), s = Math.sin(o[2]);
  const { x, y, height } = terrain, n = x.length;
  const [i, i1, a] = between(x, c * dx + s * dy), [j, j1, b] = between(y, c * dy - s * dx);
  return (height[j * n + i] * (1 - a) + height[j * n + i1] * a) * (1 - b) + (height[j1 * n + i] * (1 - a) + height[j1 * n + i1] * a) * b;
}

const onGround = ([x, y], lift = 0.012) => [x, y, groundAt(x, y) + lift];

// What the planner wanted and what happened; null where nothing was recorded.
const run = scene.run && (() => {
  const said = scene.run, { series } = said;
  return {
    ...said,
    time: sums(said.time, 1000),
    poses: said.poses && said.poses.map(({ x, y, a }) => ({ x: sums(x, 1000), y: sums(y, 1000), a: sums(a, 1000) })),
    goals: said.goals.map((list) => pairs(list, 100)),
    slots: said.slots.map((list) => pairs(list, 1000)),
    phaseTimes: said.phases.map((phase) => phase.t),
    pathTimes: sums(said.paths.time, 1000),
    lines: said.paths.lines.map((lines) => lines.map((line) => pairs(line, 100))),
    series: series && {
      time: sums(series.time, 1000),
      obstacle: series.obstacle.map((line) => sums(line, 100)),
      neighbour: series.neighbour.map((line) => sums(line, 100)),
    },
  };
})();
const formation = run !== null && !scene.individual && run.phases.some((phase) => phase.state !== "inactive");

const phaseAt = (time) => (run ? run.phases[reached(run.phaseTimes, time + 1e-6)] : null);
const leads = (k, time) => formation && scene.robots.length > 1 && phaseAt(time).leader === k;
const lost = (k, time) => formation && phaseAt(time).lost[k] === 1;

// Where the planner sends a robot; a goal that jumps does not slide.
function goalAt(k, time) {
  const [i, n, f] = between(run.time, time), a = run.goals[k][i], b = run.goals[k][n];
  if (Math.hypot(b[0] - a[0], b[1] - a[1]) > 0.35) return f < 0.5 ? a : b;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])];
}
