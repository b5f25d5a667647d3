// The robots of the plan, and where they are at a time.
const robots = scene.robots.map((said, index) => {
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
      steps.push({ down: down[next] * scene.tick, up: up[next] * scene.tick, at: [0, 1, 2].map((i) => said.base[i] + place[3 * next + i] / 200) });
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
