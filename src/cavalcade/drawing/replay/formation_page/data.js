// The run: decoding what the file carries, and its state at any time.
const run = JSON.parse(document.getElementById("run").textContent);
const sum = (list) => { let total = 0; return list.map((step) => (total += step)); };
const scaled = (list, unit) => Float64Array.from(sum(list), (v) => v * unit);
const points = (flat, unit) => {
  let x = 0, y = 0;
  const out = new Float64Array(flat.length);
  for (let i = 0; i < flat.length; i += 2) {
    out[i] = (x += flat[i]) * unit;
    out[i + 1] = (y += flat[i + 1]) * unit;
  }
  return out;
};

const times = scaled(run.time, 0.001);
const team = run.robots.map((robot, k) => ({
  ...robot,
  x: scaled(run.pose[k].x, 0.001),
  y: scaled(run.pose[k].y, 0.001),
  yaw: scaled(run.pose[k].a, 0.001),
  goalX: scaled(run.goals[k].x, 0.01),
  goalY: scaled(run.goals[k].y, 0.01),
}));
for (const robot of team) {
  // How far it has gone, for its gait; turning on the spot moves feet as well.
  robot.gone = new Float64Array(times.length);
  for (let i = 1; i < times.length; i++) {
    const way = Math.hypot(robot.x[i] - robot.x[i - 1], robot.y[i] - robot.y[i - 1]);
    robot.gone[i] = robot.gone[i - 1] + way + 0.25 * Math.abs(robot.yaw[i] - robot.yaw[i - 1]);
  }
}
const begin = times[0], finish = times[times.length - 1];
const arena = {
  border: points(run.arena.border, 0.001),
  walls: run.arena.walls.map((ring) => points(ring, 0.001)),
  unknown: run.arena.unknown.map((ring) => points(ring, 0.001)),
  shapes: run.arena.shapes.map((ring) => points(ring, 0.001)),
};
const tracks = run.tracks.map((track) => ({
  ring: points(track.ring, 0.001),
  start: track.start, end: track.end ?? Infinity,
  time: track.time, x: track.x, y: track.y,
}));
const phases = run.phases;  // each holds from its `t` on
const slotSets = run.slots.map((flat) => points(flat, 0.001));
const pathTimes = scaled(run.paths.time, 0.001);
const paths = run.paths.lines.map((lines) => lines.map((line) => points(line, 0.01)));
const series = {
  time: scaled(run.series.time, 0.001),
  obstacle: run.series.obstacle.map((line) => scaled(line, 0.01)),
  neighbour: run.series.neighbour.map((line) => scaled(line, 0.01)),
};

// Index of the last entry that is not after t.
function before(list, t, read = (entry) => entry) {
  let low = 0, high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (read(list[middle]) <= t) low = middle; else high = middle - 1;
  }
  return low;
}
const mix = (a, b, part) => a + (b - a) * part;
function lookup(xs, ys, x) {
  if (!xs.length) return 0;
  const i = before(xs, x);
  if (x <= xs[0] || i >= xs.length - 1) return ys[i];
  return mix(ys[i], ys[i + 1], (x - xs[i]) / (xs[i + 1] - xs[i] || 1));
}

// Everything at time t: interpolated poses and goals, phase, paths.
function stateAt(t) {
  const i = Math.min(before(times, t), Math.max(times.length - 2, 0));
  const j = Math.min(i + 1, times.length - 1);
  const part = j > i ? Math.min(1, Math.max(0, (t - times[i]) / (times[j] - times[i] || 1))) : 0;
  const phase = phases[before(phases, t + 1e-6, (entry) => entry.t)];
  const robots = team.map((robot, k) => {
    const jump = Math.hypot(robot.goalX[j] - robot.goalX[i], robot.goalY[j] - robot.goalY[i]) > 0.35;
    const near = jump ? (part < 0.5 ? 0 : 1) : part;
    const dt = times[j] - times[i] || 1;
    return {
      x: mix(robot.x[i], robot.x[j], part),
      y: mix(robot.y[i], robot.y[j], part),
      yaw: mix(robot.yaw[i], robot.yaw[j], part),
      gone: mix(robot.gone[i], robot.gone[j], part),
      speed: Math.hypot(robot.x[j] - robot.x[i], robot.y[j] - robot.y[i]) / dt,
      goalX: mix(robot.goalX[i], robot.goalX[j], near),
      goalY: mix(robot.goalY[i], robot.goalY[j], near),
      role: phase.roles[k],
      leads: phase.leader === k && team.length > 1,
      lost: phase.lost[k] === 1,
    };
  });
  const key = pathTimes.length ? before(pathTimes, t) : -1;
  return { t, index: i, phase, robots, lines: key >= 0 ? paths[key] : [], eta: key >= 0 ? run.paths.eta[key] : null };
}
