// Thick lines: paths (walking red, flight blue), starts and goals, footprints.
class Strokes {
  constructor() { this.clear(); }

  clear() { this.rows = { place: [], other: [], side: [], colour: [], when: [] }; }

  piece(a, b, colour, when = -1) {
    const { place, other, side, colour: paint, when: times } = this.rows;
    for (const [at, to, x, y] of [[a, b, 1, 1], [a, b, -1, 1], [b, a, 1, -1], [b, a, 1, -1], [a, b, -1, 1], [b, a, -1, -1]]) {
      place.push(...at); other.push(...to); side.push(x, y); paint.push(...colour); times.push(when);
    }
  }

  ring(points, colour, dash = 0) {
    points.forEach((at, k) => {
      const to = points[(k + 1) % points.length];
      if (!dash) { this.piece(at, to, colour); return; }
      const length = Math.hypot(...sub(to, at)), n = Math.max(1, Math.round(length / dash));
      for (let i = 0; i < n; i++) this.piece(add(at, sub(to, at), i / n), add(at, sub(to, at), (i + 0.55) / n), colour);
    });
  }

  upload() {
    this.free();
    const size = { place: 3, other: 3, side: 2, colour: 3, when: 1 };
    this.parts = Object.fromEntries(Object.entries(this.rows).map(([name, values]) => [name, [buffer(values), size[name]]]));
    this.count = this.rows.when.length;
    return this;
  }

  free() { if (this.parts) Object.values(this.parts).forEach(([made]) => gl.deleteBuffer(made)); }

  draw(width, now = 0, faint = 1) {
    if (!this.count) return;
    feed(strokes, this.parts);
    gl.uniform1f(strokes.at.width, width);
    gl.uniform1f(strokes.at.now, now);
    gl.uniform1f(strokes.at.faint, faint);
    gl.drawArrays(gl.TRIANGLES, 0, this.count);
  }
}

// A footprint's outline on the ground.
function outline(robot, x, y, yaw, lift = 0.015) {
  const [length, width] = robot.size, c = Math.cos(yaw), s = Math.sin(yaw), points = [];
  const corner = (u, v) => { const px = x + c * u - s * v, py = y + s * u + c * v; points.push([px, py, groundAt(px, py) + lift]); };
  if (robot.round) for (let k = 0; k < 28; k++) corner(length / 2 * Math.cos(k * Math.PI / 14), length / 2 * Math.sin(k * Math.PI / 14));
  else {
    const n = terrain ? 5 : 1;
    const side = (u0, v0, u1, v1) => { for (let k = 0; k < n; k++) corner(u0 + k / n * (u1 - u0), v0 + k / n * (v1 - v0)); };
    const a = length / 2, b = width / 2;
    side(a, b, -a, b); side(-a, b, -a, -b); side(-a, -b, a, -b); side(a, -b, a, b);
  }
  // Not down into gaps that the body is over.
  const top = Math.max(...points.map((at) => at[2]));
  for (const at of points) at[2] = Math.max(at[2], top - 0.2);
  return points;
}

const WALK = rgb("#d7191c"), FLY = rgb("#1f5fe0");
const trails = new Strokes(), places = new Strokes(), prints = new Strokes();
for (const robot of robots) {
  const p = robot.path, paint = rgb(robot.colour), lift = robot.legs ? 0 : 0.05;
  for (let k = 0; p && k + 1 < p.t.length; k++) {
    const a = [p.x[k], p.y[k], p.z[k] + lift], b = [p.x[k + 1], p.y[k + 1], p.z[k + 1] + lift];
    const colour = p.phase[k] === 2 ? FLY : WALK, n = Math.max(1, Math.ceil(Math.hypot(...sub(b, a)) / 0.25));
    for (let i = 0; i < n && Math.hypot(...sub(b, a)) > 1e-4; i++)
      trails.piece(add(a, sub(b, a), i / n), add(a, sub(b, a), (i + 1) / n), colour, p.t[k] + (i + 1) / n * (p.t[k + 1] - p.t[k]));
  }
  places.ring(outline(robot, ...robot.start), paint);
  places.ring(outline(robot, ...robot.goal), paint, 0.11);
  const [gx, gy, ga] = robot.goal, tip = 0.5 * robot.size[0], c = Math.cos(ga), s = Math.sin(ga);
  const from = [gx + c * 0.2 * tip, gy + s * 0.2 * tip], to = [gx + c * tip, gy + s * tip];
  places.piece([...from, groundAt(...from) + 0.015], [...to, groundAt(...to) + 0.015], paint);
}
trails.upload();
places.upload();

function drawFootprints(time) {
  prints.clear();
  for (const robot of robots) {
    const at = poseAt(robot, time);
    prints.ring(outline(robot, at.x, at.y, at.yaw, 0.02), rgb(robot.colour).map((v) => v * 0.55));
  }
  prints.upload().draw(1.4 * ratio);
}
