// Drawing a plan, its buttons, and how it opens.
const shown = { paths: true, footholds: true, goals: true, labels: true }, moreKeys = {};
const level = robots.flatMap((robot) => [groundAt(...robot.start), groundAt(...robot.goal)]).reduce((sum, z) => sum + z, 0) / (2 * robots.length);
const bounds = (() => {
  const xs = [], ys = [];
  for (const robot of robots) {
    xs.push(robot.start[0], robot.goal[0]); ys.push(robot.start[1], robot.goal[1]);
    if (robot.path) { xs.push(...robot.path.x); ys.push(...robot.path.y); }
  }
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
})();

function known(who) { return robots[who] !== undefined; }

function eyesOn(who) { const at = poseAt(robots[who], now); return [at.x, at.y, at.z - 0.1]; }

function drawSolid(time) {
  for (const robot of robots) drawRobot(robot, time);
}

function drawOver(view, time) {
  if (shown.footholds) drawMarks(marks, view, time);
  useStrokes(view);
  if (shown.goals) places.draw(1.2 * ratio);
  drawFootprints(time);
  if (shown.paths) trails.draw(1.5 * ratio, time, 0.3);
  robots.forEach((robot, k) => { const at = poseAt(robot, time); placeTag(k, view, [at.x, at.y, at.z + 0.28]); });
  fillTeam(time);
}

button("views", "Whole", () => wholeView());
button("views", "Top", () => wholeView(1.55));
button("views", "Side", () => wholeView(0.12));
button("views", "Follow", () => follow(((camera.follow ?? -1) + 1) % robots.length));
for (const name of Object.keys(shown)) if (name !== "footholds" || marks.count) layerButton(name);
begin(() => {});
