// Drawing a run in physics, its buttons, and how it opens.
const shown = { forces: true, steps: true, trails: true, paths: true, goals: true, springs: true, labels: true };
const middle = (pick) => [0, 1].map((axis) => robots.reduce((sum, robot) => sum + robot.place[axis][pick], 0) / robots.length);
const bounds = (() => {
  const out = [Infinity, Infinity, -Infinity, -Infinity];
  const take = (x, y) => { out[0] = Math.min(out[0], x); out[1] = Math.min(out[1], y); out[2] = Math.max(out[2], x); out[3] = Math.max(out[3], y); };
  for (const robot of robots) {
    robot.place[0].forEach((x, k) => take(x, robot.place[1][k]));
    if (robot.goal) take(robot.goal[0], robot.goal[1]);
  }
  return out;
})();
const level = robots.reduce((sum, robot) => sum + groundAt(robot.place[0][0], robot.place[1][0]), 0) / robots.length;

function known(who) { return who === "team" || robots[who] !== undefined; }

// The height of a trunk over a second and a half: what is followed neither trots nor falls into gaps.
function calmHeight(robot) {
  const [a] = between(now - 0.75), [b] = between(now + 0.75), heights = robot.place[2];
  let sum = 0;
  for (let k = a; k <= b; k++) sum += heights[k];
  return sum / (b - a + 1);
}

function eyesOn(who) {
  if (who !== "team") { const { place: [x, y] } = stateAt(robots[who], now); return [x, y, calmHeight(robots[who]) - 0.1]; }
  const mean = (value) => robots.reduce((sum, robot) => sum + value(robot), 0) / robots.length;
  return [mean((robot) => stateAt(robot, now).place[0]), mean((robot) => stateAt(robot, now).place[1]), mean(calmHeight) - 0.18];
}

// From behind, near enough to see the legs, far enough to see all.
function teamView() {
  const [x0, y0] = middle(0), [x1, y1] = middle(clock.length - 1);
  const ahead = Math.hypot(x1 - x0, y1 - y0) > 0.3 ? Math.atan2(y1 - y0, x1 - x0) : stateAt(robots[0], 0).yaw;
  const [x, y] = eyesOn("team"), spread = Math.max(...robots.map((robot) => Math.hypot(stateAt(robot, now).place[0] - x, stateAt(robot, now).place[1] - y)));
  Object.assign(camera, { turn: ahead + Math.PI - 0.75, lift: 0.5 });
  const narrow = Math.max(1.25 * canvas.height / Math.max(canvas.width, 1), 1);
  follow("team", Math.min((2.2 + 2.5 * spread) * narrow, 14));
}

const moreKeys = {
  f: () => teamView(),
  c: () => { shown.forces = !shown.forces; layers.forces.setAttribute("aria-pressed", shown.forces); },
  "?": () => { id("help").hidden = !id("help").hidden; },
  Escape: () => { id("help").hidden = true; },
};

function drawSolid(time) {
  drawMovers(time);
  for (const robot of robots) drawRobot(robot, time);
}

function drawOver(view, time) {
  if (shown.steps) drawMarks(marks, view, time, 0.032, 5);
  useStrokes(view);
  if (shown.trails) trails.draw(1.3 * ratio, time, 0);
  gl.uniform1f(strokes.at.faint, 1);
  if (shown.goals) { places.draw(1.3 * ratio); if (planner) drawWishes(time); }
  if (planner && shown.paths) drawPaths(time);
  if (planner && shown.springs) drawSprings(time);
  robots.forEach((robot, k) => placeTag(k, view, add(stateAt(robot, time).place, [0, 0, 0.2])));
  fillTeam(time);
  fillFeet(time);
  fillEvents(time);
}

button("views", "Team", () => teamView(), undefined, "Go with the team (F)");
button("views", "Follow", () => follow((typeof camera.follow === "number" ? camera.follow + 1 : 0) % robots.length, 2.2), undefined, "Go with one robot after another (0 to 9)");
button("views", "Whole", () => wholeView(), undefined, "All of the way (H)");
button("views", "Top", () => wholeView(1.55), undefined, "From above (T)");
button("views", "?", () => moreKeys["?"](), undefined, "Keys (?)");
const useful = {
  goals: planner !== null || robots.some((robot) => robot.goal),
  paths: planner !== null && planner.lines.some((lines) => lines.some((line) => line.length > 1)),
  springs: planner !== null && planner.phases.some((phase) => phase.joints.length),
};
const layers = {};
for (const name of Object.keys(shown)) if (useful[name] !== false) layers[name] = layerButton(name);
id("help").addEventListener("click", () => { id("help").hidden = true; });
begin(teamView);
