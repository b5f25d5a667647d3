// Thick lines, and the outline of a robot's footprint.
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

function useStrokes(view) {
  gl.useProgram(strokes.made);
  gl.uniformMatrix4fv(strokes.at.view, false, view);
  gl.uniform2f(strokes.at.screen, canvas.width / 2, canvas.height / 2);
}

// Dots on the ground that are there from their `when` on, for as long as is said, s.
function marksOf(place, colour, when) {
  return { parts: { place: [buffer(place), 3], colour: [buffer(colour), 3], when: [buffer(when), 1] }, count: when.length };
}

function drawMarks(marks, view, time, size = 0.045, stay = Infinity) {
  if (!marks.count) return;
  gl.useProgram(dots.made);
  gl.uniformMatrix4fv(dots.at.view, false, view);
  feed(dots, marks.parts);
  gl.uniform1f(dots.at.now, time);
  gl.uniform1f(dots.at.since, stay < time ? time - stay : -1);
  gl.uniform1f(dots.at.size, size * canvas.height / 0.73);
  gl.drawArrays(gl.POINTS, 0, marks.count);
}
