// Where all links of a robot in physics are: its trunk, then one link after the other.
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

// The robots, each with its kind of motion: `track` of physics, `path` of a plan, recorded `poses`.
const ANGLE = 2e-4, FORCE = 0.1, TOUCH = 2, STRIDE = 0.42;
const physics = Boolean(scene.bodies), planned = scene.tick !== undefined;
const clock = physics ? sums(scene.time, 1000) : run && run.time;
const robots = scene.robots.map((said, index) => {
  const robot = { ...said, index, fell: Infinity, contacts: [], spans: null };
  if (physics) return tracked(robot);
  if (planned) return routed(robot);
  return { ...robot, ...recorded(robot) };
});

function tracked(robot) {
  const { place, turn, joints, forces, load } = robot.track;
  Object.assign(robot, {
    body: scene.bodies[robot.body],
    place: place.map(column),
    turn: new Int16Array(bytes(turn)),
    joints: new Int16Array(bytes(joints)),
    forces: new Int16Array(bytes(forces)),
    load: new Uint8Array(bytes(load)),
    fell: (scene.falls.find(([, who]) => who === robot.index) || [Infinity])[0],
    contacts: scene.contacts.filter(([, who]) => who === robot.index),
  });
  return Object.assign(robot, activity(robot));
}

function upward(robot, k, leg) { return robot.forces[12 * k + 3 * leg + 2] * FORCE; }

// What a robot in physics does at each sample: 0 stands, 1 walks, 2 flies. It walks while a foot
// has been in the air within a third of a second; it flies when no foot has carried for two samples.
function activity(robot) {
  const count = clock.length, last = new Float64Array(count), next = new Float64Array(count), does = new Uint8Array(count), spans = [];
  const up = (k) => [0, 1, 2, 3].filter((leg) => upward(robot, k, leg) < TOUCH).length;
  let seen = -Infinity;
  for (let k = 0; k < count; k++) last[k] = seen = up(k) ? clock[k] : seen;
  seen = Infinity;
  for (let k = count - 1; k >= 0; k--) next[k] = seen = up(k) ? clock[k] : seen;
  for (let k = 0; k < count; k++) {
    if (clock[k] - last[k] < 0.33 && next[k] - clock[k] < 0.33) does[k] = 1;
    if (k && up(k) === 4 && (up(k - 1) === 4 || (k + 1 < count && up(k + 1) === 4))) does[k] = 2;
    const open = spans[spans.length - 1];
    if (open) open[2] = clock[k];
    if (!open || open[0] !== does[k]) spans.push([does[k], clock[k], clock[k]]);
  }
  return { does, spans };
}

function routed(robot) {
  const p = robot.path, said = robot.feet;
  robot.path = p && { t: sums(p.t, 1000), x: sums(p.x, 1000), y: sums(p.y, 1000), z: sums(p.z, 1000), a: sums(p.a, 1000), phase: p.p, end: p.end };
  robot.spans = p ? p.spans : [];
  if (!said) return robot;
  const down = new Uint16Array(bytes(said.down)), up = new Uint16Array(bytes(said.up)), place = new Int16Array(bytes(said.place));
  let next = 0;
  robot.feet = said.count.map((count) => Array.from({ length: count }, () => {
    const step = { down: down[next] * scene.tick, up: up[next] * scene.tick, at: [0, 1, 2].map((i) => said.base[i] + place[3 * next + i] / 200) };
    next++;
    return step;
  }));
  return robot;
}

// Recorded poses have no feet: a trot is put under them. Its steps count the metres gone instead of
// seconds, so that feet rest when the robot does; turning on the spot moves feet as well.
function recorded(robot) {
  if (!run) return {};
  const { x, y, a } = run.poses[robot.index], gone = new Float64Array(x.length);
  for (let k = 1; k < x.length; k++) gone[k] = gone[k - 1] + Math.hypot(x[k] - x[k - 1], y[k] - y[k - 1]) + 0.25 * Math.abs(a[k] - a[k - 1]);
  if (!robot.legs) return { pose: { x, y, a }, gone };
  const total = gone[gone.length - 1];
  const feet = [0, 1, 2, 3].map((leg) => {
    const shift = leg === 0 || leg === 3 ? 0 : 0.5, steps = [];
    for (let n = -1; (n - 1 - shift) * STRIDE <= total; n++) {
      const from = (n - shift) * STRIDE, middle = from + STRIDE / 4;
      steps.push({ down: from, up: from + STRIDE / 2, at: below(robot, leg, along(gone, x, middle), along(gone, y, middle), along(gone, a, middle)) });
    }
    return steps;
  });
  return { pose: { x, y, a }, gone, feet };
}

// The ground below a hip.
function below(robot, leg, x, y, yaw) {
  const { x: hx, y: hy } = robot.legs;
  return onGround(placed([x, y, yaw], leg < 2 ? hx : -hx, leg % 2 ? -hy : hy), 0);
}

// A foot on its foothold or on its way to the next one.
function footAt(robot, leg, time, state) {
  if (!robot.feet || !robot.feet[leg].length) return { at: below(robot, leg, ...state.place.slice(0, 2), state.yaw), stands: true };
  const steps = robot.feet[leg], when = robot.gone ? state.gone : time;
  const last = reached(steps, when, (step) => step.down), from = steps[last], to = steps[last + 1];
  if (!to || when <= from.up) return { at: from.at, stands: true };
  const u = clamp((when - from.up) / Math.max(to.down - from.up, 1e-6), 0, 1), arch = Math.sin(Math.PI * u);
  const at = add(from.at, sub(to.at, from.at), u * u * (3 - 2 * u));
  if (state.phase === 2) at[2] += arch * Math.max(0, state.place[2] - 0.75 * robot.legs.h - at[2]);
  else at[2] = Math.max(at[2], from.at[2] + (to.at[2] - from.at[2]) * u) + robot.legs.swing * arch * (robot.gone ? Math.min(state.speed / 0.15, 1) : 1);
  return { at, stands: false };
}

// A robot at a time: `place` of its body, yaw, speed over ground, and what it `does` with its tone.
function stateAt(robot, time) {
  if (!robot.known || robot.known.time !== time) robot.known = { time, ...(physics ? trackAt : robot.path ? pathAt : poseAt)(robot, time) };
  return robot.known;
}

function trackAt(robot, time) {
  const [k, n, f] = between(clock, time), mix = (values, size, i) => values[size * k + i] + f * (values[size * n + i] - values[size * k + i]);
  const place = robot.place.map((values) => values[k] + f * (values[n] - values[k]));
  const raw = [0, 1, 2, 3].map((i) => mix(robot.turn, 4, i)), size = Math.hypot(...raw);
  const joints = Array.from({ length: 12 }, (_, i) => mix(robot.joints, 12, i) * ANGLE);
  const forces = [0, 1, 2, 3].map((leg) => [0, 1, 2].map((i) => mix(robot.forces, 12, 3 * leg + i) * FORCE));
  const links = linksOf(robot.body, place, raw.map((v) => v / size), joints), [x, y, z] = links.turn[0];
  // Over a step's length or so, so that the trot does not show.
  const [a] = between(clock, time - 0.2), b = between(clock, time + 0.2)[1], [px, py] = robot.place;
  const does = time >= robot.fell ? 3 : robot.does[f < 0.5 ? k : n];
  return {
    ...links, forces, place, load: robot.load[n],
    yaw: Math.atan2(x[1], x[0]), pitch: -Math.asin(clamp(x[2], -1, 1)), roll: Math.atan2(y[2], z[2]),
    speed: b > a ? Math.hypot(px[b] - px[a], py[b] - py[a]) / (clock[b] - clock[a]) : 0,
    does: ["stands", "walks", "flies", "fallen"][does], tone: ["rest", "", "fly", "bad"][does],
  };
}

function pathAt(robot, time) {
  const p = robot.path, [k, n, f] = between(p.t, time), span = p.t[n] - p.t[k], mix = (v) => v[k] + f * (v[n] - v[k]);
  const moving = time < p.end && span > 0, phase = moving ? p.phase[k] : 0;
  const here = robot.spans.find((s) => time < s[2]), kind = here ? here[0] : 1;
  let does = ["stands", robot.legs ? "walks" : "drives", "flight", "turns"][kind];
  if (time >= p.end) does = "parked"; else if (phase) does = ["", "take-off", "flight", "landing"][phase];
  return {
    place: [mix(p.x), mix(p.y), mix(p.z)], yaw: mix(p.a), phase, does,
    speed: moving ? Math.hypot(p.x[n] - p.x[k], p.y[n] - p.y[k], p.z[n] - p.z[k]) / span : 0,
    tone: does === "flight" ? "fly" : does === "stands" || does === "parked" ? "rest" : "walk",
  };
}

// Along the recorded poses, or where it started.
function poseAt(robot, time) {
  const high = (x, y) => groundAt(x, y) + (robot.legs ? robot.legs.h : 0);
  if (!robot.pose) return { place: [robot.start[0], robot.start[1], high(...robot.start)], yaw: robot.start[2], phase: 0, speed: 0, does: planned ? "no path" : "", tone: "rest" };
  const { x, y, a } = robot.pose, [k, n, f] = between(clock, time), mix = (v) => v[k] + f * (v[n] - v[k]);
  const speed = n > k ? Math.hypot(x[n] - x[k], y[n] - y[k]) / (clock[n] - clock[k]) : 0;
  return { place: [mix(x), mix(y), high(mix(x), mix(y))], yaw: mix(a), gone: mix(robot.gone), phase: 0, speed, does: speed > 0.02 ? "moves" : "stands", tone: "rest" };
}
