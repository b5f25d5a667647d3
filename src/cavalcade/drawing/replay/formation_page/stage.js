// The arena and the team on a canvas. Metres, y up; the camera turns them into pixels.
const LIGHT = run.colors.light, DARK = run.colors.dark;
const view = document.getElementById("view");
const pen = view.getContext("2d");
const still = document.createElement("canvas");
const camera = { x: 0, y: 0, scale: 50, dirty: true };
const shown = { trails: true, paths: true, goals: true, springs: true, labels: true, roles: false, follow: false };
let width = 0, height = 0, ratio = 1, ink = {};

const isDark = () => document.documentElement.dataset.theme === "dark";
const colorOf = (k) => (isDark() ? DARK : LIGHT)[k % LIGHT.length];
const tint = (k, robot) => (robot.lost ? ink.soft : colorOf(shown.roles ? Math.max(robot.role, 0) : k));
const sx = (x) => width / 2 + (x - camera.x) * camera.scale;
const sy = (y) => height / 2 - (y - camera.y) * camera.scale;

function readTheme() {
  const css = getComputedStyle(document.documentElement);
  for (const key of ["ink", "soft", "ground", "wall", "shape", "unknown", "grid", "beyond", "mover", "moverfill", "limit", "limitfill", "line", "card", "halo", "accent"])
    ink[key] = css.getPropertyValue("--" + key).trim();
  camera.dirty = true;
}
function boundsOf(flat) {
  const b = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < flat.length; i += 2) {
    b[0] = Math.min(b[0], flat[i]); b[1] = Math.min(b[1], flat[i + 1]);
    b[2] = Math.max(b[2], flat[i]); b[3] = Math.max(b[3], flat[i + 1]);
  }
  return b;
}
const home = run.view.map((v) => v / 1000);
function fit() {
  const [x0, y0, x1, y1] = home;
  const top = height > 300 ? 40 : 12;  // room for the layer buttons
  camera.scale = Math.max(1, Math.min((width - 24) / (x1 - x0), (height - top - 12) / (y1 - y0)));
  camera.x = (x0 + x1) / 2;
  camera.y = (y0 + y1) / 2 + (top - 12) / 2 / camera.scale;
  camera.fitted = true;
  camera.dirty = true;
}
function follow(state, soft) {
  const there = state.robots.filter((robot) => !robot.lost);
  const group = there.length ? there : state.robots;
  const xs = group.map((r) => r.x), ys = group.map((r) => r.y);
  const x = (Math.min(...xs) + Math.max(...xs)) / 2, y = (Math.min(...ys) + Math.max(...ys)) / 2;
  const span = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)) + 4.0;
  const scale = Math.min(width, height) / span;
  camera.x = mix(camera.x, x, soft);
  camera.y = mix(camera.y, y, soft);
  camera.scale = mix(camera.scale, scale, soft * 0.5);
  camera.fitted = false;
  camera.dirty = true;
}
function resize() {
  const box = view.getBoundingClientRect();
  const fitted = camera.fitted !== false;
  ratio = window.devicePixelRatio || 1;
  width = Math.max(1, box.width); height = Math.max(1, box.height);
  const across = Math.round(width * ratio), down = Math.round(height * ratio);
  if (view.width !== across || view.height !== down) {
    view.width = still.width = across;
    view.height = still.height = down;
  }
  if (fitted) fit();
  camera.dirty = true;
}
function trace(ctx, flat, dx = 0, dy = 0) {
  ctx.moveTo(sx(flat[0] + dx), sy(flat[1] + dy));
  for (let i = 2; i < flat.length; i += 2) ctx.lineTo(sx(flat[i] + dx), sy(flat[i + 1] + dy));
}
function fillRings(ctx, rings, color) {
  ctx.beginPath();
  for (const ring of rings) { trace(ctx, ring); ctx.closePath(); }
  ctx.fillStyle = color;
  ctx.fill("evenodd");
}
function drawStill() {
  const ctx = still.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.fillStyle = ink.beyond;
  ctx.fillRect(0, 0, width, height);
  fillRings(ctx, [arena.border], ink.ground);
  const b = boundsOf(arena.border);
  ctx.save();
  ctx.beginPath(); trace(ctx, arena.border); ctx.closePath(); ctx.clip();
  const step = [1, 2, 5, 10, 20, 50, 100].find((s) => s * camera.scale > 34) || 200;
  ctx.strokeStyle = ink.grid; ctx.lineWidth = 1;
  ctx.beginPath();
  for (let x = Math.ceil(b[0] / step) * step; x <= b[2]; x += step) { ctx.moveTo(sx(x), sy(b[1])); ctx.lineTo(sx(x), sy(b[3])); }
  for (let y = Math.ceil(b[1] / step) * step; y <= b[3]; y += step) { ctx.moveTo(sx(b[0]), sy(y)); ctx.lineTo(sx(b[2]), sy(y)); }
  ctx.stroke();
  fillRings(ctx, arena.unknown, ink.unknown);
  fillRings(ctx, arena.walls, ink.wall);
  for (const ring of arena.shapes) fillRings(ctx, [ring], ink.shape);
  ctx.restore();
  ctx.beginPath(); trace(ctx, arena.border); ctx.closePath();
  ctx.strokeStyle = ink.wall; ctx.lineWidth = 2.5; ctx.stroke();
  drawScaleBar(ctx);
  camera.dirty = false;
}
function drawScaleBar(ctx) {
  const metres = [0.5, 1, 2, 5, 10, 20, 50, 100].find((m) => m * camera.scale > 48) || 200;
  const long = metres * camera.scale, x = width - 28 - long, y = height - 26;
  const text = metres + " m";
  ctx.font = "600 12px system-ui, sans-serif";
  const room = ctx.measureText(text).width + 8;
  ctx.fillStyle = ink.halo;
  ctx.beginPath(); ctx.roundRect(x - room - 8, y - 12, long + room + 16, 20, 6); ctx.fill();
  ctx.strokeStyle = ctx.fillStyle = ink.ink; ctx.lineWidth = 1.5;
  ctx.beginPath(); ctx.moveTo(x, y - 6); ctx.lineTo(x, y); ctx.lineTo(x + long, y); ctx.lineTo(x + long, y - 6); ctx.stroke();
  ctx.textAlign = "right"; ctx.textBaseline = "middle";
  ctx.fillText(text, x - 6, y - 2);
}
function drawTracks(t) {
  for (const track of tracks) {
    if (t < track.start || t >= track.end) continue;
    const dx = lookup(track.time, track.x, t), dy = lookup(track.time, track.y, t);
    const moving = track.time.length > 1 && t < track.time[track.time.length - 1] && t >= track.time[0];
    const born = Math.min(1, (t - track.start) / 0.4 + (track.start <= begin ? 1 : 0.15));
    pen.save();
    pen.globalAlpha = born;
    pen.beginPath(); trace(pen, track.ring, dx, dy); pen.closePath();
    pen.fillStyle = ink.moverfill; pen.fill();
    pen.strokeStyle = ink.mover; pen.lineWidth = 1.8; pen.setLineDash(moving ? [5, 3] : []); pen.stroke();
    pen.restore();
  }
}
function drawTrails(state) {
  pen.lineJoin = pen.lineCap = "round";
  for (const [k, robot] of team.entries()) {
    const now = state.robots[k];
    const recent = before(times, state.t - 3);
    for (const [first, alpha, thick] of [[0, 0.42, 1.4], [recent, 0.95, 2.4]]) {
      pen.beginPath(); pen.moveTo(sx(robot.x[first]), sy(robot.y[first]));
      for (let i = first + 1; i <= state.index; i++) pen.lineTo(sx(robot.x[i]), sy(robot.y[i]));
      pen.lineTo(sx(now.x), sy(now.y));
      pen.globalAlpha = alpha; pen.lineWidth = thick; pen.strokeStyle = tint(k, now); pen.stroke();
    }
  }
  pen.globalAlpha = 1;
}
function drawPaths(state) {
  for (const [k, line] of state.lines.entries()) {
    const robot = state.robots[k];
    if (!line || line.length < 4 || robot.lost) continue;
    pen.beginPath(); trace(pen, line);
    pen.strokeStyle = tint(k, robot);
    pen.lineWidth = robot.leads ? 2 : 1.4;
    pen.globalAlpha = robot.leads ? 0.95 : 0.75;
    pen.setLineDash(robot.leads ? [9, 5] : [2, 4]);
    pen.stroke();
  }
  pen.setLineDash([]); pen.globalAlpha = 1;
}
function drawGoals(state) {
  const { goal, slots } = state.phase;
  if (goal && state.phase.state !== "inactive") {
    const [x, y, a] = goal, c = Math.cos(a), s = Math.sin(a), set = slotSets[slots] || [];
    pen.strokeStyle = ink.soft; pen.fillStyle = ink.soft; pen.lineWidth = 1.5;
    for (let i = 0; i < set.length; i += 2) {
      const px = sx(x + c * set[i] - s * set[i + 1]), py = sy(y + s * set[i] + c * set[i + 1]);
      pen.beginPath(); pen.moveTo(px - 5, py); pen.lineTo(px + 5, py); pen.moveTo(px, py - 5); pen.lineTo(px, py + 5); pen.stroke();
    }
    pen.save(); pen.translate(sx(x), sy(y)); pen.rotate(-a);
    pen.beginPath(); pen.moveTo(-6, 0); pen.lineTo(14, 0); pen.stroke();
    pen.beginPath(); pen.moveTo(20, 0); pen.lineTo(11, 4.5); pen.lineTo(11, -4.5); pen.fill();
    pen.restore();
  }
  if (state.phase.state === "inactive") return;
  const size = Math.min(7, Math.max(4, 0.07 * camera.scale));
  for (const [k, robot] of state.robots.entries()) {
    if (robot.role < 0) continue;
    pen.beginPath(); pen.arc(sx(robot.goalX), sy(robot.goalY), size, 0, 7);
    pen.fillStyle = ink.ground; pen.fill();
    pen.strokeStyle = tint(k, robot); pen.lineWidth = 2.2; pen.stroke();
  }
}
// A coil whose wire keeps its length: pressed together it gets thick, drawn out it gets flat.
function drawSprings(state) {
  const set = slotSets[state.phase.slots] || [];
  pen.strokeStyle = ink.ink; pen.lineJoin = "round"; pen.globalAlpha = 0.6; pen.lineWidth = 1.2;
  for (const [a, b] of state.phase.joints) {
    const p = state.robots[a], q = state.robots[b];
    const x0 = sx(p.x), y0 = sy(p.y), dx = sx(q.x) - x0, dy = sy(q.y) - y0, pixels = Math.hypot(dx, dy);
    const i = 2 * p.role, j = 2 * q.role;
    const rest = (i >= 0 && j >= 0 && Math.hypot(set[i] - set[j], set[i + 1] - set[j + 1])) || pixels / camera.scale;
    const ends = Math.min(0.32 * camera.scale, 0.3 * pixels);
    const coil = pixels - 2 * ends, turns = Math.max(3, Math.round(7 * rest));
    const stretch = pixels / camera.scale / (rest || 1);
    const swing = camera.scale * 0.055 * Math.min(1.6, Math.max(0.15, 2.2 - 1.2 * stretch));
    pen.beginPath(); pen.moveTo(x0, y0);
    if (camera.scale > 28 && coil > 8) {
      const ux = dx / pixels, uy = dy / pixels;
      for (let n = 0; n <= 2 * turns; n++) {
        const along = ends + (coil * n) / (2 * turns);
        const side = n === 0 || n === 2 * turns ? 0 : n % 2 ? swing : -swing;
        pen.lineTo(x0 + ux * along - uy * side, y0 + uy * along + ux * side);
      }
    }
    pen.lineTo(x0 + dx, y0 + dy);
    pen.stroke();
  }
  pen.globalAlpha = 1;
}
