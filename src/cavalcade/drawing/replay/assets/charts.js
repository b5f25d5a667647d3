// Distances over time, and the time line. They are drawn once per size and theme; a cursor moves.
function canvasOf(name) {
  const box = id(name), pen = box.getContext("2d"), width = box.clientWidth, height = box.clientHeight;
  const across = Math.max(Math.round(width * ratio), 1), down = Math.max(Math.round(height * ratio), 1);
  if (box.width !== across || box.height !== down) { box.width = across; box.height = down; }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height, fill: (colour, ...box) => { pen.fillStyle = colour; pen.fillRect(...box); } };
}

const LEFT = 26, RIGHT = 4, TOP = 5, BOTTOM = 14;
const charts = series ? [{ name: "obstacle", limit: run.radius }, { name: "neighbour", limit: 2 * run.radius }].filter(({ name }) => series[name].length) : [];
for (const name of ["obstacle", "neighbour"]) id(`${name}s`).hidden = !charts.some((chart) => chart.name === name);
for (const { name } of charts) {
  const jump = (event) => { if (event.buttons === 1) goTo(begin + (event.offsetX - LEFT) / (id(name).clientWidth - LEFT - RIGHT) * (end - begin)); };
  id(name).addEventListener("pointerdown", (event) => { id(name).setPointerCapture(event.pointerId); jump(event); });
  id(name).addEventListener("pointermove", jump);
}

function layChart({ name, limit }) {
  const { pen, width, height, fill } = canvasOf(name), lines = series[name], all = lines.flatMap((line) => Array.from(line)).sort((a, b) => a - b);
  const high = Math.max(1.1 * all[Math.floor(0.985 * (all.length - 1))], 2.2 * limit);
  const px = (t) => LEFT + (t - begin) / (end - begin || 1) * (width - LEFT - RIGHT), py = (v) => TOP + (1 - v / high) * (height - TOP - BOTTOM);
  fill(ink.badfill, LEFT, py(limit), width - LEFT - RIGHT, py(0) - py(limit));
  pen.font = "10.5px system-ui, sans-serif"; pen.textBaseline = "middle"; pen.textAlign = "right";
  pen.strokeStyle = ink.line; pen.fillStyle = ink.soft; pen.lineWidth = 1;
  const level = (v) => { pen.beginPath(); pen.moveTo(LEFT, py(v)); pen.lineTo(width - RIGHT, py(v)); pen.stroke(); };
  const step = [0.25, 0.5, 1, 2, 5, 10, 20].find((s) => high / s <= 4.2) || 50;
  for (let v = 0; v < high; v += step) { level(v); pen.fillText(String(v), LEFT - 4, py(v)); }
  pen.textAlign = "center"; pen.textBaseline = "bottom";
  const tick = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600].find((s) => (end - begin) / s <= Math.max(2, width / 55)) || 1200;
  for (let t = Math.ceil(begin / tick) * tick; t <= end + 1e-6; t += tick)
    pen.fillText(`${t}${t + tick > end + 1e-6 ? " s" : ""}`, Math.min(px(t), width - RIGHT - 9), height);
  pen.save();
  pen.beginPath(); pen.rect(LEFT, 0, width - LEFT - RIGHT, height - BOTTOM + 1); pen.clip();
  pen.lineJoin = "round"; pen.lineWidth = 1.5;
  lines.forEach((line, k) => {
    pen.beginPath();
    line.forEach((v, i) => pen.lineTo(px(series.time[i]), py(v)));
    pen.strokeStyle = palette(k); pen.stroke();
  });
  // Where several run together, each is on top in turns.
  const near = 1.5 * high / (height - TOP - BOTTOM), turn = (i) => Math.floor(40 * (series.time[i] - begin) / (end - begin || 1));
  lines.forEach((line, k) => {
    pen.beginPath();
    for (let i = 1; i < line.length; i++) {
      const beside = lines.map((other) => Number(Math.abs(other[i] - line[i]) < near)), count = (some) => some.reduce((a, b) => a + b, 0);
      if (count(beside) < 2 || turn(i) % count(beside) !== count(beside.slice(0, k))) continue;
      pen.moveTo(px(series.time[i - 1]), py(line[i - 1])); pen.lineTo(px(series.time[i]), py(line[i]));
    }
    pen.strokeStyle = palette(k); pen.stroke();
  });
  pen.restore();
  pen.strokeStyle = ink.bad; pen.setLineDash([5, 3]); level(limit); pen.setLineDash([]);
}

// A lane per robot: walking, standing, flight; red ticks are unwanted contacts. Under a formation a
// line in the leader's colour; dark triangles are notes.
function layBand() {
  const { pen, width, height, fill } = canvasOf("band"), x = (time) => 4 + (time - begin) * (width - 8) / Math.max(end - begin, 1e-6);
  const lanes = robots.filter((robot) => robot.spans), led = formation && robots.length > 1, room = height - (led && lanes.length ? 14 : 6);
  const tall = Math.min(room / Math.max(lanes.length, 1), 12), top = (room - tall * lanes.length) / 2 + 3;
  lanes.forEach((robot, k) => {
    const y = top + k * tall, thick = Math.max(tall - (tall > 3 ? 1 : 0), 1);
    const kinds = [ink.rest, physics ? palette(robot.index) : ink.walk, ink.fly, ink.turn];
    const thin = (colour, from, to) => fill(colour, x(from), y + 0.3 * thick, Math.max(x(to) - x(from), 1), Math.max(0.4 * thick, 1));
    for (const [kind, from, to] of robot.spans) {
      pen.globalAlpha = physics && kind === 1 ? 0.78 : 1;
      if (physics && !kind) thin(kinds[kind], from, to); else fill(kinds[kind], x(from), y, Math.max(x(to) - x(from), 1), thick);
    }
    pen.globalAlpha = 1;
    if (robot.path) thin(ink.rest, robot.path.end, end);
    if (robot.fell < Infinity) fill(ink.bad, x(robot.fell), y, x(end) - x(robot.fell), thick);
    for (const [when] of robot.contacts) {
      fill(ink.card, x(when) - 2, y, 4, thick);
      fill(ink.bad, x(when) - 1, y - 1, 2, thick + 2);
    }
  });
  const [y, thick] = lanes.length ? [height - 8, 4] : [height / 2 - 4, 8];
  if (led || !lanes.length) (run ? run.phases : [{ t: begin, leader: -1 }]).forEach(({ t, leader, roles }, k, all) => {
    const from = k ? x(t) : 4, to = k + 1 < all.length ? x(all[k + 1].t) : width - 4;
    fill(leader >= 0 && led ? palette(shown.slots ? Math.max(roles[leader], 0) : leader) : ink.rest, from, y, to - from + 0.5, thick);
  });
  pen.fillStyle = ink.ink;
  for (const [when] of run ? run.notes : []) {
    pen.beginPath(); pen.moveTo(x(when) - 4, 0); pen.lineTo(x(when) + 4, 0); pen.lineTo(x(when), 7); pen.fill();
  }
}

function layPanels() {
  charts.forEach(layChart);
  layBand();
}

function moveCursors(time) {
  for (const { name } of charts) {
    const wide = id(name).clientWidth - LEFT - RIGHT;
    id(name).nextElementSibling.style.transform = `translateX(${LEFT + (time - begin) / (end - begin || 1) * wide}px)`;
  }
}
