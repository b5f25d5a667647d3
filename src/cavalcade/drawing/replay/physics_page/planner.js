// What the planner wanted: goals, paths, springs, commanded speeds; and obstacles that move.
const planner = scene.planner && (() => {
  const said = scene.planner;
  const flat = (list, unit) => {
    let x = 0, y = 0;
    const out = [];
    for (let k = 0; k < list.length; k += 2) out.push([(x += list[k]) * unit, (y += list[k + 1]) * unit]);
    return out;
  };
  return {
    ...said,
    time: sums(said.time, 1000),
    goals: said.goals.map((goal) => ({ x: sums(goal.x, 100), y: sums(goal.y, 100) })),
    slots: said.slots.map((slots) => flat(slots, 0.001)),
    pathTimes: sums(said.paths.time, 1000),
    lines: said.paths.lines.map((lines) => lines.map((line) => flat(line, 0.01))),
    clock: sums(said.clock, 1000),
    wanted: said.wanted.map((values) => sums(values, 100)),
  };
})();

// Index of the last of the ascending values that is not after v.
function reached(values, v) {
  if (values.length < 2 || v >= values[values.length - 1]) return values.length - 1;
  return before(values, v);
}

const phaseTimes = planner ? planner.phases.map((phase) => phase.t) : [];
const phaseAt = (time) => planner.phases[Math.max(reached(phaseTimes, time + 1e-6), 0)];
const wantedAt = (k, time) => (planner ? planner.wanted[k][Math.max(reached(planner.clock, time), 0)] : null);
const linesAt = (time) => planner.lines[Math.max(reached(planner.pathTimes, time), 0)] || [];
function goalAt(k, time) {
  const i = Math.max(reached(planner.time, time), 0), { x, y } = planner.goals[k];
  return [x[i], y[i]];
}

function along(times, values, time) {
  if (!times.length) return 0;
  const i = Math.max(reached(times, time), 0), j = Math.min(i + 1, times.length - 1);
  if (j === i || time <= times[0]) return values[i];
  return values[i] + (values[j] - values[i]) * Math.min((time - times[i]) / (times[j] - times[i] || 1), 1);
}

const MOVER = [0.60, 0.42, 0.32];
const movers = (planner ? planner.movers : []).map((said) => {
  const { prism, made } = faces();
  prism(said, MOVER);
  return { ...said, end: said.end ?? Infinity, mesh: made() };
});

function drawMovers(time) {
  for (const { mesh: shape, start, end: stop, time: times, x, y } of movers)
    if (time >= start && time < stop) drawMesh(shape, boxed([1, 0, 0], [0, 1, 0], [0, 0, 1], [along(times, x, time), along(times, y, time), 0]), [1, 1, 1]);
}
