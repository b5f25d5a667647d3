// Thick lines and dots. Their colours are multiplied by a tint when they are drawn.
class Strokes {
  constructor() { this.clear(); }

  clear() { this.rows = { place: [], other: [], side: [], colour: [], when: [] }; }

  piece(a, b, colour, when = -1) {
    const { place, other, side, colour: paint, when: times } = this.rows;
    for (const [at, to, x, y] of [[a, b, 1, 1], [a, b, -1, 1], [b, a, 1, -1], [b, a, 1, -1], [a, b, -1, 1], [b, a, -1, -1]]) {
      place.push(...at); other.push(...to); side.push(x, y); paint.push(...colour); times.push(when);
    }
  }

  // Around the points; dashes have about that length, m.
  ring(points, colour, dash = 0) {
    points.forEach((at, k) => {
      const way = sub(points[(k + 1) % points.length], at), n = dash ? Math.max(1, Math.round(Math.hypot(...way) / dash)) : 1;
      for (let i = 0; i < n; i++) this.piece(add(at, way, i / n), add(at, way, (i + (dash ? 0.55 : 1)) / n), colour);
    });
  }

  // Along points [x, y] on the ground.
  lay(points, colour, dash = 0) {
    for (let k = 0; k + 1 < points.length; k++) {
      const a = points[k], b = points[k + 1], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      const n = Math.max(1, Math.ceil(length / (dash || (terrain ? 0.1 : Infinity))));
      const at = (f) => onGround([a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])]);
      for (let i = 0; i < n; i++) this.piece(at(i / n), at((i + (dash ? 0.55 : 1)) / n), colour);
    }
  }

  circle([x, y], radius, colour, lift = 0.012) {
    this.ring(circle(radius).map(([u, v]) => onGround([x + u, y + v], lift)), colour);
  }

  upload() {
    if (this.parts) Object.values(this.parts).forEach((made) => gl.deleteBuffer(made));
    this.parts = buffers(this.rows);
    this.count = this.rows.when.length;
    return this;
  }

  draw(width, { now = 0, since = -2, faint = 1, strength = 1, tint = [1, 1, 1] } = {}) {
    if (!this.count) return;
    feed(strokes, this.parts);
    setUniforms(strokes, { width: width * ratio, now, since, faint, strength, tint });
    gl.drawArrays(gl.TRIANGLES, 0, this.count);
  }
}

function useStrokes(view) {
  gl.useProgram(strokes.made);
  setUniforms(strokes, { view, screen: [canvas.width / 2, canvas.height / 2] });
}

const circle = (radius) => Array.from({ length: 28 }, (_, k) => [radius * Math.cos(k * Math.PI / 14), radius * Math.sin(k * Math.PI / 14)]);

// A footprint's outline on the ground.
function outline(robot, x, y, yaw, lift = 0.015) {
  const [length, width] = robot.size, points = [];
  const corner = (u, v) => points.push(onGround(placed([x, y, yaw], u, v), lift));
  if (robot.round) for (const [u, v] of circle(length / 2)) corner(u, v);
  else {
    const n = terrain ? 5 : 1, a = length / 2, b = width / 2;
    const side = (u0, v0, u1, v1) => { for (let k = 0; k < n; k++) corner(u0 + k / n * (u1 - u0), v0 + k / n * (v1 - v0)); };
    side(a, b, -a, b); side(-a, b, -a, -b); side(-a, -b, a, -b); side(a, -b, a, b);
  }
  // Not down into gaps that the body is over.
  const top = Math.max(...points.map((at) => at[2]));
  for (const at of points) at[2] = Math.max(at[2], top - 0.2);
  return points;
}

// Dots that are there from their `when` on, for as long as is said, s.
function drawMarks({ parts, count }, view, time, tint, size = 0.045, stay = Infinity) {
  if (!count) return;
  gl.useProgram(dots.made);
  feed(dots, parts);
  const since = stay < time ? time - stay : -1;
  setUniforms(dots, { view, tint, now: time, since, size: size * canvas.height / 0.73 / (camera.top ? camera.away : 1) });
  gl.drawArrays(gl.POINTS, 0, count);
}
