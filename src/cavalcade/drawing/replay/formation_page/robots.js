// One robot from above: a trunk with feet that trot as far as it really goes.
function drawRobot(k, robot) {
  const long = team[k].length * camera.scale, wide = team[k].width * camera.scale;
  const color = tint(k, robot);
  pen.save();
  pen.translate(sx(robot.x), sy(robot.y));
  pen.rotate(-robot.yaw);
  if (long < 7) {
    pen.beginPath(); pen.arc(0, 0, 4, 0, 7);
    pen.fillStyle = color; pen.fill();
    pen.strokeStyle = ink.ground; pen.lineWidth = 1; pen.stroke();
    pen.restore();
    return;
  }
  const detailed = long > 26;
  if (robot.leads) {
    pen.beginPath(); pen.ellipse(0, 0, 0.66 * long, 0.66 * long, 0, 0, 7);
    pen.fillStyle = color; pen.globalAlpha = 0.16; pen.fill(); pen.globalAlpha = 1;
  }
  if (detailed) {
    const beat = (robot.gone / 0.42) * 2 * Math.PI;
    pen.fillStyle = isDark() ? "#0b0d0f" : "#24292e";
    pen.strokeStyle = color; pen.lineWidth = Math.max(0.6, 0.02 * long);
    for (const [fore, side, shift] of [[1, 1, 0], [-1, -1, 0], [1, -1, Math.PI], [-1, 1, Math.PI]]) {
      const x = fore * 0.31 * long + 0.075 * long * Math.sin(beat + shift), y = side * 0.38 * wide;
      pen.beginPath(); pen.roundRect(x - 0.075 * long, y - 0.11 * wide, 0.15 * long, 0.22 * wide, 0.1 * wide);
      pen.fill(); pen.stroke();
    }
  }
  // The footprint that is checked for contact is exactly this rectangle.
  const deep = detailed ? 0.66 : 1;
  pen.beginPath(); pen.roundRect(-long / 2, -wide / 2, long, wide, 0.18 * wide);
  if (detailed) { pen.strokeStyle = color; pen.globalAlpha = 0.55; pen.lineWidth = 1; pen.stroke(); pen.globalAlpha = 1; }
  pen.beginPath(); pen.roundRect(-0.47 * long, (-wide / 2) * deep, 0.94 * long, wide * deep, 0.24 * wide);
  pen.fillStyle = robot.lost ? ink.ground : color; pen.fill();
  pen.strokeStyle = robot.lost ? color : isDark() ? "#0b0d0f" : "#1b1f24";
  pen.lineWidth = Math.min(1.4, Math.max(0.7, 0.02 * long));
  if (robot.lost) pen.setLineDash([3, 2]);
  pen.stroke(); pen.setLineDash([]);
  pen.beginPath(); pen.roundRect(0.27 * long, -0.21 * wide, 0.17 * long, 0.42 * wide, 0.12 * wide);
  pen.fillStyle = robot.lost ? color : "#ffffffe6"; pen.fill();
  pen.restore();
}
function drawLabel(k, robot, middle) {
  const wide = team[k].width * camera.scale, long = team[k].length * camera.scale;
  if (robot.leads) drawStar(sx(robot.x), sy(robot.y), Math.max(6, Math.min(15, 0.42 * wide + 2)));
  if (!shown.labels || (robot.role < 0 && !robot.lost)) return;
  const text = robot.lost ? "lost" : String(robot.role + 1);
  const inside = wide > 22 && !robot.leads && !robot.lost;
  const size = inside ? Math.min(16, 0.5 * wide) : 12;
  pen.font = `650 ${size}px system-ui, sans-serif`;
  pen.textAlign = "center"; pen.textBaseline = "middle"; pen.lineJoin = "round";
  // Beside the body, on the side away from the team; inside, behind the head.
  let c = Math.cos(robot.yaw), s = Math.sin(robot.yaw), away = -0.06 * long;
  if (!inside) {
    const side = (robot.y - middle.y) * c - (robot.x - middle.x) * s < 0 ? -1 : 1;
    [c, s] = [-s * side, c * side];
    away = wide / 2 + 10;
  }
  const x = sx(robot.x) + away * c, y = sy(robot.y) - away * s;
  pen.lineWidth = 3; pen.strokeStyle = inside ? "#0008" : ink.halo;
  pen.strokeText(text, x, y + 0.5);
  pen.fillStyle = inside ? "#fff" : ink.ink;
  pen.fillText(text, x, y + 0.5);
}
function drawStar(x, y, radius) {
  pen.beginPath();
  for (let i = 0; i < 10; i++) {
    const r = i % 2 ? 0.42 * radius : radius, a = (i * Math.PI) / 5 - Math.PI / 2;
    pen.lineTo(x + r * Math.cos(a), y + r * Math.sin(a));
  }
  pen.closePath();
  pen.fillStyle = "#ffe14d"; pen.fill();
  pen.strokeStyle = "#1b1f24"; pen.lineWidth = 1.2; pen.lineJoin = "round"; pen.stroke();
}
function drawStage(state) {
  if (camera.dirty) drawStill();
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.drawImage(still, 0, 0);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  drawTracks(state.t);
  if (shown.trails) drawTrails(state);
  if (shown.paths) drawPaths(state);
  if (shown.springs) drawSprings(state);
  if (shown.goals) drawGoals(state);
  for (const [k, robot] of state.robots.entries()) drawRobot(k, robot);
  const middle = {
    x: state.robots.reduce((total, robot) => total + robot.x, 0) / team.length,
    y: state.robots.reduce((total, robot) => total + robot.y, 0) / team.length,
  };
  for (const [k, robot] of state.robots.entries()) drawLabel(k, robot, middle);
}
