// The plan out of the page: whole numbers back to metres, seconds and radians.
const plan = JSON.parse(document.getElementById("plan").textContent);

function sums(steps, unit) {
  const out = new Float64Array(steps.length);
  let total = 0;
  steps.forEach((step, k) => { total += step; out[k] = total / unit; });
  return out;
}

function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) out[k] = raw.charCodeAt(k);
  return out.buffer;
}

function placed(origin, x, y) {
  const c = Math.cos(origin[2]), s = Math.sin(origin[2]);
  return [origin[0] + c * x - s * y, origin[1] + s * x + c * y];
}

const border = [];
for (let k = 0; k < plan.border.length; k += 2) border.push([plan.border[k] / 1000, plan.border[k + 1] / 1000]);

const terrain = plan.terrain && (() => {
  const t = plan.terrain, x = t.x.map((v) => v / 1000), y = t.y.map((v) => v / 1000);
  const whole = new Uint16Array(bytes(t.heights)), bits = new Uint8Array(bytes(t.blocked));
  const height = Float32Array.from(whole, (v) => t.low + v * t.span / 65000);
  const blocked = (k) => (bits[k >> 3] >> (7 - (k & 7))) & 1;
  return { x, y, height, blocked, origin: t.origin, low: t.low, span: t.span };
})();

function before(values, v) {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= v) low = middle; else high = middle;
  }
  return low;
}

// Height of the ground at a place of the map frame.
function groundAt(px, py) {
  if (!terrain) return 0;
  const o = terrain.origin, dx = px - o[0], dy = py - o[1], c = Math.cos(o[2]), s = Math.sin(o[2]);
  const u = c * dx + s * dy, v = c * dy - s * dx, { x, y, height } = terrain;
  const i = before(x, u), j = before(y, v), i1 = Math.min(i + 1, x.length - 1), j1 = Math.min(j + 1, y.length - 1);
  const a = i1 > i ? Math.min(Math.max((u - x[i]) / (x[i1] - x[i]), 0), 1) : 0;
  const b = j1 > j ? Math.min(Math.max((v - y[j]) / (y[j1] - y[j]), 0), 1) : 0;
  const n = x.length;
  return (height[j * n + i] * (1 - a) + height[j * n + i1] * a) * (1 - b) + (height[j1 * n + i] * (1 - a) + height[j1 * n + i1] * a) * b;
}

const robots = plan.robots.map((said, index) => {
  const p = said.path;
  const path = p && { t: sums(p.t, 1000), x: sums(p.x, 1000), y: sums(p.y, 1000), z: sums(p.z, 1000), a: sums(p.a, 1000), phase: p.p, spans: p.spans, end: p.end };
  return { ...said, index, path, feet: readFeet(said.feet) };
});

function readFeet(said) {
  if (!said) return null;
  const down = new Uint16Array(bytes(said.down)), up = new Uint16Array(bytes(said.up)), place = new Int16Array(bytes(said.place));
  let next = 0;
  return said.count.map((count) => {
    const steps = [];
    for (let k = 0; k < count; k++, next++)
      steps.push({ down: down[next] * plan.tick, up: up[next] * plan.tick, at: [0, 1, 2].map((i) => said.base[i] + place[3 * next + i] / 200) });
    return steps;
  });
}

// Where a robot is at a time: x, y, z, yaw, phase and speed.
function poseAt(robot, time) {
  const p = robot.path;
  if (!p) return { x: robot.start[0], y: robot.start[1], z: groundAt(robot.start[0], robot.start[1]) + (robot.legs ? robot.legs.h : 0), yaw: robot.start[2], phase: 0, speed: 0 };
  const last = p.t.length - 1;
  const k = last ? before(p.t, time) : 0, n = Math.min(k + 1, last);
  const span = p.t[n] - p.t[k], f = span > 0 ? Math.min(Math.max((time - p.t[k]) / span, 0), 1) : 0;
  const mix = (v) => v[k] + f * (v[n] - v[k]);
  const moving = time < p.end && span > 0;
  const speed = moving ? Math.hypot(p.x[n] - p.x[k], p.y[n] - p.y[k], p.z[n] - p.z[k]) / span : 0;
  return { x: mix(p.x), y: mix(p.y), z: mix(p.z), yaw: mix(p.a), phase: moving ? p.phase[k] : 0, speed };
}

function doing(robot, time) {
  if (!robot.path) return "no path";
  if (time >= robot.path.end) return "parked";
  const phase = poseAt(robot, time).phase;
  if (phase) return ["", "take-off", "flight", "landing"][phase];
  const span = robot.path.spans.find((s) => time < s[2]);
  return span && span[0] === 0 ? "stands" : span && span[0] === 3 ? "turns" : robot.legs ? "walks" : "drives";
}
