// Lines on the ground and between robots: trails, paths, goals, springs; and where feet came down.
const WHITE = [1, 1, 1], WALK = rgb("#d7191c"), FLY = rgb("#1f5fe0"), LEADER = rgb("#ffd21f");
const edges = new Strokes(), places = new Strokes(), prints = new Strokes(), routes = new Strokes();
const paths = new Strokes(), wishes = new Strokes(), springs = new Strokes();

// The map's border, starts and goals of single robots, in the colours of the theme.
function layPlaces() {
  edges.clear();
  if (!terrain) edges.ring(border.map((at) => onGround(at, 0.006)), rgb(ink.soft));
  edges.upload();
  places.clear();
  for (const robot of scene.individual ? robots : []) {
    const [x, y, yaw] = robot.goal, paint = deepOf(robot.index), half = robot.size[0] / 2;
    places.ring(outline(robot, ...robot.start), paint);
    places.ring(outline(robot, x, y, yaw), paint, 0.11);
    places.lay([placed(robot.goal, 0.2 * half, 0), placed(robot.goal, half, 0)], paint);
  }
  places.upload();
}

// Trajectories of a plan: walking red, flight blue.
for (const { path: p, legs } of planned ? robots : []) {
  for (let k = 0; p && k + 1 < p.t.length; k++) {
    const lift = legs ? 0 : 0.05, a = [p.x[k], p.y[k], p.z[k] + lift], way = sub([p.x[k + 1], p.y[k + 1], p.z[k + 1] + lift], a), length = Math.hypot(...way);
    const n = length > 1e-4 ? Math.ceil(length / 0.25) : 0;
    for (let i = 0; i < n; i++)
      routes.piece(add(a, way, i / n), add(a, way, (i + 1) / n), p.phase[k] === 2 ? FLY : WALK, p.t[k] + (i + 1) / n * (p.t[k + 1] - p.t[k]));
  }
}
routes.upload();

// Where robots went, a few points a second.
const trails = planned || !clock ? [] : robots.map((robot) => {
  const [x, y] = physics ? robot.place : [robot.pose.x, robot.pose.y], trail = new Strokes();
  let from = 0;
  for (let k = 1; k < clock.length; k++) {
    if (clock[k] - clock[from] < 0.12 && k + 1 < clock.length) continue;
    if (Math.hypot(x[k] - x[from], y[k] - y[from]) > 0.004) trail.piece(onGround([x[from], y[from]], 0.008), onGround([x[k], y[k]], 0.008), WHITE, clock[k]);
    from = k;
  }
  return trail.upload();
});

// Footholds of a plan, or where feet came down in physics.
const marks = robots.map((robot) => {
  const place = [], when = [];
  if (planned) for (const step of (robot.feet || []).flat()) { place.push(...add(step.at, [0, 0, 0.008])); when.push(step.down); }
  const flying = [true, true, true, true];
  for (let k = 0; physics && k < clock.length; k++)
    for (let leg = 0; leg < 4; leg++) {
      const down = upward(robot, k, leg) >= TOUCH;
      if (down && flying[leg]) {
        const [x, y, z] = stateAt(robot, clock[Math.min(k + 1, clock.length - 1)]).feet[leg];
        place.push(x, y, z - robot.body.radius + 0.006); when.push(clock[k]);
      }
      flying[leg] = !down;
    }
  return { parts: buffers({ place, when }), count: when.length };
});

function drawLines(view, time) {
  if (shown.footholds) robots.forEach((robot, k) => drawMarks(marks[k], view, time, scaled(paintOf(k), dark() ? 1 : 0.7), ...(physics ? [0.032, 5] : [])));
  useStrokes(view);
  edges.draw(1.2);
  if (shown.trails) trails.forEach((trail, k) => {
    trail.draw(1.1, { now: time, faint: 0, strength: 0.55, tint: paintOf(k) });
    trail.draw(2, { now: time, since: time - 3, faint: 0, tint: paintOf(k) });
  });
  if (shown.goals) { places.draw(1.3); drawWishes(time); }
  drawFootprints(time);
  if (shown.paths) { routes.draw(1.5, { now: time, faint: 0.3 }); drawPaths(time); }
  if (shown.springs) drawSprings(time);
}

// Outlines of the bodies, and a ring around the leader.
function drawFootprints(time) {
  prints.clear();
  robots.forEach((robot, k) => {
    const { place: [x, y], yaw } = stateAt(robot, time);
    if (!physics) prints.ring(outline(robot, x, y, yaw, 0.02), scaled(paintOf(k), 0.6));
    if (leads(k, time)) for (const radius of [0.66, 0.68]) prints.circle([x, y], radius * robot.size[0], LEADER, 0.018);
  });
  prints.upload().draw(1.4);
}

let laid = null;
function drawPaths(time) {
  const lines = run && !planned ? run.lines[reached(run.pathTimes, time)] || [] : [], key = [lines, phaseAt(time), ink.ink, shown.slots];
  if (!laid || key.some((part, k) => part !== laid[k])) {
    laid = key;
    paths.clear();
    lines.forEach((line, k) => { if (line.length > 1 && !lost(k, time)) paths.lay(line, deepOf(k), leads(k, time) ? 0.18 : 0.09); });
    paths.upload();
  }
  paths.draw(1.5);
}

// A formation's goal with its slots, and where the planner sends each robot.
function drawWishes(time) {
  if (!formation || phaseAt(time).state === "inactive") return;
  const { goal, slots, roles } = phaseAt(time), soft = rgb(ink.soft);
  wishes.clear();
  if (goal) {
    const from = ([u, v]) => placed(goal, u, v);
    for (const [u, v] of run.slots[slots] || [])
      for (const [du, dv] of [[0.07, 0], [0, 0.07]]) wishes.lay([from([u - du, v - dv]), from([u + du, v + dv])], soft);
    wishes.lay([from([-0.1, 0]), from([0.22, 0])], soft);
    wishes.lay([from([0.13, 0.07]), from([0.22, 0]), from([0.13, -0.07])], soft);
  }
  roles.forEach((role, k) => { if (role >= 0) for (const radius of [0.1, 0.025]) wishes.circle(goalAt(k, time), radius, deepOf(k)); });
  wishes.upload().draw(1.7);
}

// Coils between joined robots whose wire keeps its length: pressed together they get wide.
function drawSprings(time) {
  if (!formation) return;
  const { joints, slots, roles } = phaseAt(time), set = run.slots[slots] || [], paint = rgb(ink.soft);
  springs.clear();
  for (const [a, b] of joints) {
    const p = stateAt(robots[a], time).place, way = sub(stateAt(robots[b], time).place, p), length = Math.hypot(...way) || 1;
    const u = set[roles[a]], v = set[roles[b]], rest = (u && v && Math.hypot(u[0] - v[0], u[1] - v[1])) || length;
    const side = unit([-way[1], way[0], 0]), ends = Math.min(0.3, 0.3 * length), turns = Math.max(3, Math.round(5 * rest));
    const swing = 0.04 * clamp(2.2 - 1.2 * length / rest, 0.2, 1.6), line = [p];
    for (let n = 0; n <= 2 * turns; n++) {
      const f = (ends + (length - 2 * ends) * n / (2 * turns)) / length, out = n === 0 || n === 2 * turns ? 0 : n % 2 ? swing : -swing;
      line.push(add(add(p, way, f), side, out));
    }
    line.push(add(p, way));
    for (let n = 0; n + 1 < line.length; n++) springs.piece(line[n], line[n + 1], paint);
  }
  springs.upload().draw(1.1);
}
