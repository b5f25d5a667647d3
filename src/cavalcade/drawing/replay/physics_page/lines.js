// Lines on the ground and between robots: ways, paths, goals, springs.
const INK = () => rgb(css("--ink")), SOFT = () => rgb(css("--soft"));
const colours = robots.map((robot) => rgb(robot.colour)), deep = colours.map((colour) => scaled(colour, 0.72));
const onGround = ([x, y], lift = 0.012) => [x, y, groundAt(x, y) + lift];

function lay(target, points, paint, dash = 0) {
  for (let k = 0; k + 1 < points.length; k++) {
    const a = points[k], b = points[k + 1], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    const n = Math.max(1, Math.ceil(length / (dash || (terrain ? 0.1 : Infinity))));
    const at = (f) => onGround([a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])]);
    for (let i = 0; i < n; i++) target.piece(at(i / n), at((i + (dash ? 0.55 : 1)) / n), paint);
  }
}

function disc2(target, [x, y], radius, paint, lift = 0.012) {
  const count = 28;
  target.ring(Array.from({ length: count }, (_, k) => onGround([x + radius * Math.cos(2 * Math.PI * k / count), y + radius * Math.sin(2 * Math.PI * k / count)], lift)), paint);
}

// Where the trunks went, a few points a second.
const trails = new Strokes();
for (const robot of robots) {
  const [x, y] = robot.place;
  let from = 0;
  for (let k = 1; k < clock.length; k++) {
    if (clock[k] - clock[from] < 0.12 && k + 1 < clock.length) continue;
    if (Math.hypot(x[k] - x[from], y[k] - y[from]) > 0.004) trails.piece(onGround([x[from], y[from]], 0.008), onGround([x[k], y[k]], 0.008), colours[robot.index], clock[k]);
    from = k;
  }
}
trails.upload();

const places = new Strokes(), paths = new Strokes(), wishes = new Strokes(), springs = new Strokes();
for (const robot of robots) {
  if (!robot.goal) continue;
  const [x, y, yaw] = robot.goal, c = Math.cos(yaw), s = Math.sin(yaw), half = 0.5 * robot.size[0];
  places.ring(outline(robot, x, y, yaw), deep[robot.index], 0.11);
  lay(places, [[x + 0.2 * c * half, y + 0.2 * s * half], [x + c * half, y + s * half]], deep[robot.index]);
}
places.upload();

let laid = null;
function drawPaths(time) {
  const lines = linesAt(time);
  if (laid !== lines) {
    laid = lines;
    paths.clear();
    lines.forEach((line, k) => { if (line.length > 1) lay(paths, line, deep[k], 0.09); });
    paths.upload();
  }
  paths.draw(1.4 * ratio);
}

function drawWishes(time) {
  const phase = phaseAt(time), soft = SOFT();
  wishes.clear();
  if (!planner.individual && phase.state !== "inactive") {
    if (phase.goal) {
      const [x, y, a] = phase.goal, c = Math.cos(a), s = Math.sin(a), turn = ([u, v]) => [x + c * u - s * v, y + s * u + c * v];
      for (const [u, v] of planner.slots[phase.slots] || [])
        for (const [du, dv] of [[0.07, 0], [0, 0.07]]) lay(wishes, [turn([u - du, v - dv]), turn([u + du, v + dv])], soft);
      lay(wishes, [turn([-0.1, 0]), turn([0.22, 0])], soft);
      lay(wishes, [turn([0.13, 0.07]), turn([0.22, 0]), turn([0.13, -0.07])], soft);
    }
    robots.forEach((robot, k) => { if (phase.roles[k] >= 0) { const at = goalAt(k, time); disc2(wishes, at, 0.1, deep[k]); disc2(wishes, at, 0.025, deep[k]); } });
  }
  wishes.upload().draw(1.5 * ratio);
}

// Coils between joined robots, level with their trunks: pressed together they get wide.
function drawSprings(time) {
  const phase = phaseAt(time), ink = SOFT(), set = planner.slots[phase.slots] || [];
  springs.clear();
  for (const [a, b] of phase.joints) {
    const p = stateAt(robots[a], time).place, q = stateAt(robots[b], time).place, way = sub(q, p), length = Math.hypot(...way) || 1;
    const u = set[phase.roles[a]], v = set[phase.roles[b]], rest = u && v ? Math.hypot(u[0] - v[0], u[1] - v[1]) : length;
    const side = unit([-way[1], way[0], 0]), ends = Math.min(0.3, 0.3 * length), turns = Math.max(3, Math.round(7 * rest));
    const swing = 0.035 * Math.min(1.6, Math.max(0.2, 2.2 - 1.2 * length / (rest || 1)));
    const line = [p];
    for (let n = 0; n <= 2 * turns; n++) {
      const f = (ends + (length - 2 * ends) * n / (2 * turns)) / length, out = n === 0 || n === 2 * turns ? 0 : n % 2 ? swing : -swing;
      line.push(add(add(p, way, f), side, out));
    }
    line.push(q);
    for (let n = 0; n + 1 < line.length; n++) springs.piece(line[n], line[n + 1], ink);
  }
  springs.upload().draw(1.1 * ratio);
}
