// Feet: on their footholds, or swinging from one to the next.
const smooth = (u) => u * u * (3 - 2 * u);

// Where a foot is, and whether it stands.
function footAt(robot, leg, time, body) {
  const steps = robot.feet[leg];
  let k = 0;
  if (steps.length > 1) {
    let low = 0, high = steps.length - 1;
    while (low < high) { const middle = (low + high + 1) >> 1; if (steps[middle].down <= time) low = middle; else high = middle - 1; }
    k = low;
  }
  const from = steps[k], to = steps[k + 1];
  if (!to || time <= from.up) return { at: from.at, stands: true };
  const u = Math.min(Math.max((time - from.up) / Math.max(to.down - from.up, 1e-6), 0), 1);
  const at = add(from.at, sub(to.at, from.at), smooth(u));
  const arch = Math.sin(Math.PI * u);
  if (body.phase === 2) at[2] += arch * Math.max(0, body.z - 0.75 * robot.legs.h - at[2]);
  else at[2] = Math.max(at[2], from.at[2] + (to.at[2] - from.at[2]) * u) + robot.legs.swing * arch;
  return { at, stands: false };
}

// Where no footholds are known: below the hip.
function belowHip(robot, leg, body) {
  const x = leg < 2 ? robot.legs.x : -robot.legs.x, y = leg % 2 ? -robot.legs.y : robot.legs.y;
  const [px, py] = placed([body.x, body.y, body.yaw], x, y);
  return { at: [px, py, groundAt(px, py)], stands: true };
}

const marks = (() => {
  const place = [], colour = [], when = [];
  for (const robot of robots) {
    if (!robot.feet) continue;
    const paint = rgb(robot.colour).map((v) => v * 0.7);
    for (const steps of robot.feet) for (const step of steps) { place.push(step.at[0], step.at[1], step.at[2] + 0.008); colour.push(...paint); when.push(step.down); }
  }
  return marksOf(place, colour, when);
})();
