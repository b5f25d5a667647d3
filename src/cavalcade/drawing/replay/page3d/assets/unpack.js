// What the page carries as `scene`: whole numbers back to metres, seconds and radians.
const scene = JSON.parse(document.getElementById("scene").textContent);
const id = (name) => document.getElementById(name);
const dark = () => document.documentElement.dataset.theme === "dark";
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

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

// A column that was written as 65535 steps of its range.
function column({ low, step, data }) {
  return Float32Array.from(new Uint16Array(bytes(data)), (v) => low + v * step);
}

function placed(origin, x, y) {
  const c = Math.cos(origin[2]), s = Math.sin(origin[2]);
  return [origin[0] + c * x - s * y, origin[1] + s * x + c * y];
}

const border = [];
for (let k = 0; k < scene.border.length; k += 2) border.push([scene.border[k] / 1000, scene.border[k + 1] / 1000]);

const terrain = scene.terrain && (() => {
  const t = scene.terrain, x = t.x.map((v) => v / 1000), y = t.y.map((v) => v / 1000);
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
