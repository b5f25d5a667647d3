// Where all links of a robot are at a time: its trunk and joints between two samples, then one
// link after the other.
function rotated(axis, angle) {
  const h = angle / 2, s = Math.sin(h);
  return turnOf([Math.cos(h), s * axis[0], s * axis[1], s * axis[2]]);
}

function linksOf(body, place, quaternion, joints) {
  const at = [place], turn = [turnOf(quaternion)];
  body.links.forEach(({ parent, offset, axis }, k) => {
    at.push(add(at[parent], turned(turn[parent], offset)));
    turn.push(turnedBy(turn[parent], rotated(axis, joints[k])));
  });
  const feet = body.feet.map(({ link, offset }) => add(at[link], turned(turn[link], offset)));
  return { at, turn, feet };
}

function stateAt(robot, time) {
  if (robot.known && robot.known.time === time) return robot.known;
  const [k, n, f] = between(time), mix = (values, size, i) => values[size * k + i] + f * (values[size * n + i] - values[size * k + i]);
  const place = robot.place.map((values) => values[k] + f * (values[n] - values[k]));
  const raw = [0, 1, 2, 3].map((i) => mix(robot.turn, 4, i)), size = Math.hypot(...raw);
  const joints = Array.from({ length: 12 }, (_, i) => mix(robot.joints, 12, i) * ANGLE);
  const forces = [0, 1, 2, 3].map((leg) => [0, 1, 2].map((i) => mix(robot.forces, 12, 3 * leg + i) * FORCE));
  const { at, turn, feet } = linksOf(robot.body, place, raw.map((v) => v / size), joints), [x, y, z] = turn[0];
  robot.known = {
    time, at, turn, feet, forces, place,
    yaw: Math.atan2(x[1], x[0]), pitch: -Math.asin(Math.min(Math.max(x[2], -1), 1)), roll: Math.atan2(y[2], z[2]),
    speed: speedAt(robot, time), load: robot.load[n], does: time >= robot.fell ? 3 : robot.does[f < 0.5 ? k : n],
  };
  return robot.known;
}

// Over the ground, over a step's length or so, so that the trot does not show.
function speedAt(robot, time) {
  const [a] = between(time - 0.2), [b] = between(time + 0.2), [x, y] = robot.place;
  return b > a ? Math.hypot(x[b] - x[a], y[b] - y[a]) / (clock[b] - clock[a]) : 0;
}

// Where each foot came down, for the marks on the ground.
const marks = (() => {
  const place = [], colour = [], when = [];
  for (const robot of robots) {
    const paint = rgb(robot.colour).map((v) => v * 0.7), flying = [true, true, true, true];
    for (let k = 0; k < clock.length; k++)
      for (let leg = 0; leg < 4; leg++) {
        const down = upward(robot, k, leg) >= TOUCH;
        if (down && flying[leg]) {
          const [x, y, z] = stateAt(robot, clock[Math.min(k + 1, clock.length - 1)]).feet[leg];
          place.push(x, y, z - robot.body.radius + 0.006); colour.push(...paint); when.push(clock[k]);
        }
        flying[leg] = !down;
      }
  }
  return marksOf(place, colour, when);
})();
