// Paths (walking red, flight blue), starts and goals, footprints.
const WALK = rgb("#d7191c"), FLY = rgb("#1f5fe0");
const trails = new Strokes(), places = new Strokes(), prints = new Strokes();
for (const robot of robots) {
  const p = robot.path, paint = rgb(robot.colour), lift = robot.legs ? 0 : 0.05;
  for (let k = 0; p && k + 1 < p.t.length; k++) {
    const a = [p.x[k], p.y[k], p.z[k] + lift], b = [p.x[k + 1], p.y[k + 1], p.z[k + 1] + lift];
    const colour = p.phase[k] === 2 ? FLY : WALK, n = Math.max(1, Math.ceil(Math.hypot(...sub(b, a)) / 0.25));
    for (let i = 0; i < n && Math.hypot(...sub(b, a)) > 1e-4; i++)
      trails.piece(add(a, sub(b, a), i / n), add(a, sub(b, a), (i + 1) / n), colour, p.t[k] + (i + 1) / n * (p.t[k + 1] - p.t[k]));
  }
  places.ring(outline(robot, ...robot.start), paint);
  places.ring(outline(robot, ...robot.goal), paint, 0.11);
  const [gx, gy, ga] = robot.goal, tip = 0.5 * robot.size[0], c = Math.cos(ga), s = Math.sin(ga);
  const from = [gx + c * 0.2 * tip, gy + s * 0.2 * tip], to = [gx + c * tip, gy + s * tip];
  places.piece([...from, groundAt(...from) + 0.015], [...to, groundAt(...to) + 0.015], paint);
}
trails.upload();
places.upload();

function drawFootprints(time) {
  prints.clear();
  for (const robot of robots) {
    const at = poseAt(robot, time);
    prints.ring(outline(robot, at.x, at.y, at.yaw, 0.02), rgb(robot.colour).map((v) => v * 0.55));
  }
  prints.upload().draw(1.4 * ratio);
}
