// Robots: a body, a head and four legs of two links, or a plain box or disc.
function drawRobot(robot, time) {
  const body = poseAt(robot, time), paint = rgb(robot.colour), [length, width, height] = robot.size;
  const c = Math.cos(body.yaw), s = Math.sin(body.yaw);
  if (!robot.legs) {
    const base = groundAt(body.x, body.y), half = Math.min(0.5 * height, 0.2);
    const shape = robot.round ? disc : cube;
    drawMesh(shape, boxed([c * length / 2, s * length / 2, 0], [-s * width / 2, c * width / 2, 0], [0, 0, half], [body.x, body.y, base + half]), paint);
    const nose = 0.3 * length;
    drawMesh(cube, boxed([c * 0.12 * length, s * 0.12 * length, 0], [-s * 0.12 * width, c * 0.12 * width, 0], [0, 0, 0.03], [body.x + c * nose, body.y + s * nose, base + 2 * half + 0.01]), [0.15, 0.16, 0.18]);
    return;
  }
  const { x: hx, y: hy, link } = robot.legs;
  const feet = [0, 1, 2, 3].map((leg) => robot.feet ? footAt(robot, leg, time, body) : belowHip(robot, leg, body));
  let pitch = Math.atan2(0.5 * (feet[0].at[2] + feet[1].at[2] - feet[2].at[2] - feet[3].at[2]), 2 * hx);
  pitch = Math.max(-0.5, Math.min(0.5, body.phase ? 0.4 * pitch : pitch));
  const x = [c * Math.cos(pitch), s * Math.cos(pitch), Math.sin(pitch)], y = [-s, c, 0], z = cross(x, y), at = [body.x, body.y, body.z];
  const long = 0.42 * length, wide = Math.min(hy + 0.035, 0.45 * width), tall = 0.055;
  drawMesh(cube, boxed(scaled(x, long), scaled(y, wide), scaled(z, tall), add(at, z, 0.02)), paint);
  drawMesh(cube, boxed(scaled(x, 0.05), scaled(y, 0.7 * wide), scaled(z, 0.045), add(add(at, x, long + 0.03), z, 0.045)), [0.13, 0.14, 0.16]);
  const limbs = paint.map((v) => 0.25 + 0.5 * v);
  for (let leg = 0; leg < 4; leg++) {
    const left = leg % 2 ? -1 : 1, hip = add(add(at, x, leg < 2 ? hx : -hx), y, left * (hy + 0.02));
    const foot = add(feet[leg].at, [0, 0, 0.02]), away = sub(foot, hip), far = Math.hypot(...away);
    const bend = Math.sqrt(Math.max(link * link - 0.25 * far * far, 0.0002));
    const knee = add(add(hip, away, 0.5), unit(cross(away, y)), -bend);
    const back = dot(sub(knee, hip), x) > dot(scaled(away, 0.5), x) ? add(add(hip, away, 0.5), unit(cross(away, y)), bend) : knee;
    limb(hip, back, 0.024, limbs, y);
    limb(back, foot, 0.017, scaled(limbs, 0.8), y);
    drawMesh(cube, boxed([0.022, 0, 0], [0, 0.022, 0], [0, 0, 0.022], foot), feet[leg].stands ? [0.1, 0.1, 0.11] : [0.95, 0.95, 0.95]);
  }
}
