// An orbit camera, or one that looks straight down and shows the plane as a map does. Drag turns (from
// above: moves), right or shift drag moves (turns), wheel and pinch zoom.
const camera = { target: [0, 0, 0], away: 10, turn: 0, lift: 0.8, top: false, follow: null };
const NORTH = -Math.PI / 2, ASIDE = 0.2, HALF_ANGLE = 0.35;
const level = robots.reduce((sum, { start }) => sum + groundAt(start[0], start[1]), 0) / robots.length;

// All that is worth seeing, in the picture's middle and as near as all of it stays there.
function wholeView(lift = 0.95) {
  const [x0, y0, x1, y1] = scene.view.map((v) => v / 1000), corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
  Object.assign(camera, { target: [(x0 + x1) / 2, (y0 + y1) / 2, level], turn: NORTH - (camera.top ? 0 : ASIDE), lift });
  for (camera.away = Math.max(2, Math.hypot(x1 - x0, y1 - y0) / 2); camera.away < 400; camera.away *= 1.02) {
    const matrix = viewMatrix(), seen = corners.map(([x, y]) => apply(matrix, [x, y, level]));
    const [left, low] = [0, 1].map((axis) => Math.min(...seen.map((at) => at[axis]))), [right, high] = [0, 1].map((axis) => Math.max(...seen.map((at) => at[axis])));
    if (Math.max(-left, right) < 0.97 && low > -0.96 && high < 0.9 && seen.every((at) => at[3] > 0)) break;
    pan(-(left + right) / 4 * canvas.clientWidth, (low + high + 0.06) / 4 * canvas.clientHeight);
  }
}

function eyeAt() {
  const { target, away, turn, top } = camera, lift = top ? Math.PI / 2 : camera.lift;
  return add(target, [Math.cos(turn) * Math.cos(lift), Math.sin(turn) * Math.cos(lift), Math.sin(lift)], away);
}

function viewMatrix() {
  const { target, away, turn, top } = camera, aspect = canvas.width / Math.max(canvas.height, 1);
  const up = top || camera.lift > 1.5 ? [-Math.cos(turn), -Math.sin(turn), 0] : [0, 0, 1];
  if (!top) return times(perspective(2 * HALF_ANGLE, aspect, away * 0.02, away * 6 + 60), lookAt(eyeAt(), target, up));
  const high = away * Math.tan(HALF_ANGLE);
  return times(orthographic(high * aspect, high, 1, 99), lookAt(add(target, [0, 0, 50]), target, up));
}

function setTop(on) {
  camera.top = on;
  Object.assign(camera, { turn: NORTH - (on ? 0 : ASIDE), lift: on ? camera.lift : 0.95 });
  if (camera.follow === null) wholeView();
  id("top").setAttribute("aria-pressed", on);
  remember("top", on ? "1" : "");
}

// Stay with a robot (its number) or with all of them ("team"), `away` from it at most.
function follow(who, away = physics ? 2.2 : 3.2) {
  if (who !== null && who !== "team" && !robots[who]) return;
  camera.follow = who;
  if (who !== null) Object.assign(camera, { away: who === "team" ? away : Math.min(camera.away, away), lift: Math.min(camera.lift, 0.45) });
  redraw();
}

// The height of a trunk over a second and a half: what is followed neither trots nor falls into gaps.
function calmHeight(robot) {
  if (!physics) return stateAt(robot, now).place[2];
  const [a] = between(clock, now - 0.75), b = between(clock, now + 0.75)[1];
  let sum = 0;
  for (let k = a; k <= b; k++) sum += robot.place[2][k];
  return sum / (b - a + 1);
}

const meanOf = (group, value) => group.reduce((sum, robot) => sum + value(robot), 0) / group.length;
const teamAt = (time) => { const there = robots.filter((robot) => !lost(robot.index, time)); return there.length ? there : robots; };

function eyesOn(who) {
  const group = who === "team" ? teamAt(now) : [robots[who]];
  return [0, 1].map((axis) => meanOf(group, (robot) => stateAt(robot, now).place[axis])).concat(meanOf(group, calmHeight) - (who === "team" ? 0.18 : 0.1));
}

// From behind, near enough to see the legs, far enough to see all.
function teamView() {
  const middle = (time) => [0, 1].map((axis) => meanOf(robots, (robot) => stateAt(robot, time).place[axis]));
  const [x0, y0] = middle(begin), [x1, y1] = middle(end), [x, y] = eyesOn("team");
  const ahead = Math.hypot(x1 - x0, y1 - y0) > 0.3 ? Math.atan2(y1 - y0, x1 - x0) : stateAt(robots[0], begin).yaw;
  const spread = Math.max(...teamAt(now).map((robot) => Math.hypot(stateAt(robot, now).place[0] - x, stateAt(robot, now).place[1] - y)));
  const narrow = Math.max(1.25 * canvas.height / Math.max(canvas.width, 1), 1);
  if (!camera.top) Object.assign(camera, { turn: ahead + Math.PI - 0.75, lift: 0.5 });
  follow("team", Math.min((2.2 + 2.5 * spread) * narrow, 25));
  if (!camera.top) camera.lift = 0.5;
}

function pan(dx, dy) {
  const per = 2 * Math.tan(HALF_ANGLE) * camera.away / canvas.clientHeight, s = Math.sin(camera.turn), c = Math.cos(camera.turn);
  const flat = camera.top ? 1 : Math.max(Math.sin(camera.lift), 0.25);
  camera.follow = null;
  camera.target = add(camera.target, [(s * dx - c * dy / flat) * per, (-c * dx - s * dy / flat) * per, 0]);
}

const fingers = new Map();
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  canvas.classList.add("drag");
});
for (const kind of ["pointerup", "pointercancel"])
  canvas.addEventListener(kind, (event) => { fingers.delete(event.pointerId); canvas.classList.remove("drag"); });
canvas.addEventListener("pointermove", (event) => {
  const last = fingers.get(event.pointerId);
  if (!last) return;
  const dx = event.clientX - last[0], dy = event.clientY - last[1];
  if (fingers.size === 2) {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
    zoom(apart(last) / apart([event.clientX, event.clientY]));
    pan(dx / 2, dy / 2);
  } else if ((event.shiftKey || Boolean(event.buttons & 2)) !== camera.top) pan(dx, dy);
  else {
    camera.turn -= dx * 0.006;
    if (!camera.top) camera.lift = clamp(camera.lift + dy * 0.005, 0.05, 1.55);
  }
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  redraw();
});
canvas.addEventListener("dblclick", () => { wholeView(); redraw(); });
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const factor = Math.exp(event.deltaY * (event.deltaMode ? 0.03 : 0.001)), aimed = camera.top && camera.follow === null;
  const dx = event.offsetX - canvas.clientWidth / 2, dy = event.offsetY - canvas.clientHeight / 2;
  // What is under the pointer stays there.
  if (aimed) pan(-dx, -dy);
  zoom(factor);
  if (aimed) pan(dx, dy);
  redraw();
}, { passive: false });

function zoom(factor) { camera.away = clamp(camera.away * factor, 0.6, 300); }
