// The track: what the robots did, sample by sample.
const clock = sums(scene.time, 1000);

const robots = scene.robots.map((said, index) => ({
  ...said, index, body: scene.bodies[said.body],
  place: said.place.map(column),
  turn: new Int16Array(bytes(said.turn)),
  joints: new Int16Array(bytes(said.joints)),
  forces: new Int16Array(bytes(said.forces)),
  load: new Uint8Array(bytes(said.load)),
  fell: (scene.falls.find(([, who]) => who === index) || [Infinity])[0],
  contacts: scene.contacts.filter(([, who]) => who === index),
}));

const ANGLE = 2e-4, FORCE = 0.1, TOUCH = 2;
const upward = (robot, k, leg) => robot.forces[12 * k + 3 * leg + 2] * FORCE;

// What a robot does at each sample: 0 stands, 1 walks, 2 flies. It walks while a foot has been in
// the air within a third of a second; it flies when no foot has carried for two samples.
for (const robot of robots) {
  const count = clock.length, last = new Float64Array(count), next = new Float64Array(count), does = new Uint8Array(count);
  const up = (k) => [0, 1, 2, 3].filter((leg) => upward(robot, k, leg) < TOUCH).length;
  let seen = -Infinity;
  for (let k = 0; k < count; k++) last[k] = seen = up(k) ? clock[k] : seen;
  seen = Infinity;
  for (let k = count - 1; k >= 0; k--) next[k] = seen = up(k) ? clock[k] : seen;
  for (let k = 0; k < count; k++) {
    if (clock[k] - last[k] < 0.33 && next[k] - clock[k] < 0.33) does[k] = 1;
    if (k && up(k) === 4 && (up(k - 1) === 4 || (k + 1 < count && up(k + 1) === 4))) does[k] = 2;
  }
  robot.does = does;
  robot.spans = [];
  for (let k = 0; k < count; k++) {
    const open = robot.spans[robot.spans.length - 1];
    if (open && open[0] === does[k]) open[2] = clock[k]; else { if (open) open[2] = clock[k]; robot.spans.push([does[k], clock[k], clock[k]]); }
  }
}

// The sample before a time, the one after, and how far it is between them.
function between(time) {
  const last = clock.length - 1, k = last ? before(clock, time) : 0, n = Math.min(k + 1, last);
  return [k, n, n > k ? Math.min(Math.max((time - clock[k]) / (clock[n] - clock[k]), 0), 1) : 0];
}
