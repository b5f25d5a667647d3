// What stands around the arena: status, team, distances over time, the time line.
const byId = (id) => document.getElementById(id);
const STATES = {
  inactive: "inactive", partial: "Partial Goal", final: "Final Goal", resolving: "resolving a deadlock",
  paused: "paused", stuck: "stuck", infeasible: "infeasible",
};
function element(tag, parent, text = "") {
  const node = document.createElement(tag);
  node.textContent = text;
  parent.append(node);
  return node;
}
byId("name").textContent = run.name;
byId("outcome").textContent = run.outcome.text;
byId("outcome").classList.add(run.outcome.good ? "good" : "bad");
for (const [name, value] of run.numbers) { element("dt", byId("numbers"), name); element("dd", byId("numbers"), value); }
byId("facts").hidden = run.numbers.length === 0;
byId("pairs").hidden = team.length < 2;

const rows = team.map((robot, k) => {
  const row = element("tr", byId("robots"));
  const cells = Array.from({ length: 5 }, () => element("td", row));
  const swatch = element("i", cells[0]);
  cells[1].textContent = `${k}`;
  cells[1].title = robot.model;
  cells[3].className = cells[4].className = "n";
  return { row, cells, swatch };
});
const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };

function drawStatus(state) {
  const { phase } = state;
  const pill = byId("state");
  const words = [phase.arrived ? "arrived" : STATES[phase.state] || phase.state];
  if (run.waypoints > 1 && phase.state !== "inactive") words.push(`goal ${Math.min(phase.waypoint + 1, run.waypoints)} of ${run.waypoints}`);
  if (phase.leader >= 0 && team.length > 1) words.push(`robot ${phase.leader} leads`);
  if (state.eta != null && phase.state === "partial") words.push(`ETA ${(state.eta / 10).toFixed(1)} s`);
  if (phase.message) words.push(phase.message);
  const text = words.join(" · ");
  if (pill.dataset.text !== text || pill.dataset.theme !== document.documentElement.dataset.theme) {
    pill.dataset.text = text; pill.dataset.theme = document.documentElement.dataset.theme;
    pill.textContent = "";
    if (phase.leader >= 0) element("i", pill).style.background = tint(phase.leader, state.robots[phase.leader]);
    pill.append(text);
    pill.title = text;
  }
  put(byId("clock").firstChild, state.t.toFixed(1));
  const at = before(series.time, state.t);
  for (const [k, robot] of state.robots.entries()) {
    const { row, cells, swatch } = rows[k];
    swatch.style.background = tint(k, robot);
    put(cells[2], robot.lost ? "lost" : robot.role < 0 ? "–" : robot.leads ? `${robot.role + 1} ★ leader` : `${robot.role + 1}`);
    put(cells[3], robot.speed.toFixed(2));
    const clear = series.obstacle[k]?.[at];
    put(cells[4], clear == null ? "–" : clear.toFixed(2));
    cells[4].classList.toggle("low", clear != null && clear < run.radius);
    row.classList.toggle("lost", robot.lost);
  }
  const note = run.notes.findLast(([t]) => t <= state.t && state.t < t + 4);
  byId("note").classList.toggle("on", Boolean(note));
  if (note) put(byId("note"), note[1]);
}

// A chart is drawn once per size and theme; only the cursor moves.
const charts = [
  { canvas: byId("obstacles"), lines: series.obstacle, limit: run.radius },
  { canvas: byId("neighbours"), lines: series.neighbour, limit: 2 * run.radius },
].map((chart) => ({ ...chart, ctx: chart.canvas.getContext("2d"), base: document.createElement("canvas"), dirty: true }));
const LEFT = 26, RIGHT = 4, TOP = 5, BOTTOM = 14;

function layChart(chart) {
  const box = chart.canvas.getBoundingClientRect();
  chart.width = box.width; chart.height = box.height;
  if (!box.width || !chart.lines.length) return;
  for (const canvas of [chart.canvas, chart.base]) {
    canvas.width = Math.round(box.width * ratio); canvas.height = Math.round(box.height * ratio);
  }
  const ctx = chart.base.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  const all = chart.lines.flatMap((line) => Array.from(line)).sort((a, b) => a - b);
  const high = Math.max(1.1 * all[Math.floor(0.985 * (all.length - 1))], 2.2 * chart.limit);
  const px = (t) => LEFT + ((t - begin) / (finish - begin || 1)) * (box.width - LEFT - RIGHT);
  const py = (v) => TOP + (1 - v / high) * (box.height - TOP - BOTTOM);
  chart.px = px;
  ctx.fillStyle = ink.limitfill;
  ctx.fillRect(LEFT, py(chart.limit), box.width - LEFT - RIGHT, py(0) - py(chart.limit));
  ctx.font = "10.5px system-ui, sans-serif"; ctx.textBaseline = "middle"; ctx.textAlign = "right";
  ctx.strokeStyle = ink.line; ctx.fillStyle = ink.soft; ctx.lineWidth = 1;
  const step = [0.25, 0.5, 1, 2, 5, 10, 20].find((s) => high / s <= 4.2) || 50;
  for (let v = 0; v < high; v += step) {
    ctx.beginPath(); ctx.moveTo(LEFT, py(v)); ctx.lineTo(box.width - RIGHT, py(v)); ctx.stroke();
    ctx.fillText(String(+v.toFixed(2)), LEFT - 4, py(v));
  }
  ctx.textAlign = "center"; ctx.textBaseline = "bottom";
  const tick = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600].find((s) => (finish - begin) / s <= Math.max(2, box.width / 55)) || 1200;
  for (let t = Math.ceil(begin / tick) * tick; t <= finish + 1e-6; t += tick)
    ctx.fillText(`${t}${t + tick > finish + 1e-6 ? " s" : ""}`, Math.min(px(t), box.width - RIGHT - 9), box.height);
  ctx.save();
  ctx.beginPath(); ctx.rect(LEFT, 0, box.width - LEFT - RIGHT, box.height - BOTTOM + 1); ctx.clip();
  ctx.lineJoin = "round"; ctx.lineWidth = 1.5;
  for (const [k, line] of chart.lines.entries()) {
    ctx.beginPath();
    for (let i = 0; i < line.length; i++) ctx.lineTo(px(series.time[i]), py(line[i]));
    ctx.strokeStyle = colorOf(k); ctx.stroke();
  }
  ctx.restore();
  ctx.strokeStyle = ink.limit; ctx.setLineDash([5, 3]);
  ctx.beginPath(); ctx.moveTo(LEFT, py(chart.limit)); ctx.lineTo(box.width - RIGHT, py(chart.limit)); ctx.stroke();
  ctx.setLineDash([]);
  chart.dirty = false;
}
function drawCharts(t) {
  for (const chart of charts) {
    if (chart.dirty) layChart(chart);
    if (!chart.width || !chart.px) continue;
    const { ctx } = chart;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, chart.canvas.width, chart.canvas.height);
    ctx.drawImage(chart.base, 0, 0);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = ink.ink;
    ctx.fillRect(chart.px(t) - 0.75, TOP - 3, 1.5, chart.height - TOP - BOTTOM + 4);
  }
}
// The time line: who leads when, what happened when, how far the replay is.
function drawBand(t) {
  const canvas = byId("band"), box = canvas.getBoundingClientRect(), ctx = canvas.getContext("2d");
  if (canvas.width !== Math.round(box.width * ratio)) canvas.width = Math.round(box.width * ratio);
  if (canvas.height !== Math.round(box.height * ratio)) canvas.height = Math.round(box.height * ratio);
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, box.width, box.height);
  // The slider's thumb is 14 px wide: its middle runs from 7 px to 7 px before the end.
  const px = (time) => 7 + ((time - begin) / (finish - begin || 1)) * (box.width - 14);
  const middle = box.height / 2, now = px(t);
  ctx.save();
  ctx.beginPath(); ctx.roundRect(5, middle - 4, box.width - 10, 8, 4); ctx.clip();
  for (let pass = 0; pass < 2; pass++) {
    if (pass) { ctx.beginPath(); ctx.rect(0, 0, now, box.height); ctx.clip(); }
    ctx.fillStyle = ink.card; ctx.globalAlpha = 1; ctx.fillRect(0, middle - 4, box.width, 8);
    ctx.globalAlpha = pass ? 1 : 0.38;
    for (const [i, phase] of phases.entries()) {
      const from = i ? px(phase.t) : 0, to = i + 1 < phases.length ? px(phases[i + 1].t) : box.width;
      ctx.fillStyle = phase.leader >= 0 ? colorOf(shown.roles ? phase.roles[phase.leader] : phase.leader) : ink.soft;
      ctx.fillRect(from, middle - 4, to - from + 0.5, 8);
    }
  }
  ctx.restore();
  ctx.fillStyle = ink.ink;
  for (const [time] of run.notes) {
    const x = px(time);
    ctx.beginPath(); ctx.moveTo(x, middle - 6); ctx.lineTo(x - 4, middle - 13); ctx.lineTo(x + 4, middle - 13); ctx.fill();
  }
}
