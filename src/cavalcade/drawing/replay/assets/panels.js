// Everything around the picture: state, team, one robot's feet, events, tags, scale.
const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };

id("state").hidden = !run;
id("feet").hidden = !physics;

// What the colours of the time line mean, as far as they occur.
const doing = (kind) => robots.some((robot) => (robot.spans || []).some((span) => span[0] === kind));
for (const [kind, text, useful] of [
  [physics ? "own" : "walk", robots.some((robot) => robot.legs) ? "walking" : "driving", physics || planned],
  ["fly", "flight", doing(2)], ["turn", "turning", planned && doing(3)], ["rest", "standing", physics || planned],
  ["touch", "unwanted contact", physics && scene.contacts.length], ["fall", "fallen", physics && scene.falls.length],
]) if (useful) { const key = element("span", id("legend"), "", "key"); element("i", key, "", kind); key.append(text); }

const STATES = { partial: "Partial Goal", final: "Final Goal", resolving: "resolving a deadlock" };
function fillState(time) {
  if (!run) return;
  const phase = phaseAt(time), words = [], eta = run.paths.eta[reached(run.pathTimes, time)];
  if (formation) {
    words.push(phase.arrived ? "arrived" : STATES[phase.state] || phase.state);
    if (run.waypoints > 1 && phase.state !== "inactive") words.push(`goal ${Math.min(phase.waypoint + 1, run.waypoints)} of ${run.waypoints}`);
    if (phase.leader >= 0 && robots.length > 1) words.push(`robot ${phase.leader} leads`);
    if (phase.state === "partial" && eta !== null && eta !== undefined) words.push(`ETA ${(eta / 10).toFixed(1)} s`);
  }
  if (phase.message) words.push(phase.message);
  put(id("state"), words.join(" · "));
  id("state").hidden = !words.length;
  const note = run.notes.findLast(([when]) => when <= time && time < when + 4);
  id("note").classList.toggle("on", Boolean(note));
  if (note) put(id("note"), note[1]);
}

// What a robot ran into within the last second.
function alarmAt(robot, time) {
  if (time >= robot.fell) return "fallen";
  const hit = robot.contacts.find(([when]) => when <= time && time < when + 1);
  return hit ? `${hit[2]} – ${hit[3]}` : "";
}

// The columns of the team's table: head, alignment, text at a time, whether it is of use.
const { series } = run || {}, wanted = scene.commands && { time: sums(scene.commands.time, 1000), speed: scene.commands.speed.map((list) => sums(list, 100)) };
const clearAt = (k, time) => series.obstacle[k][reached(series.time, time)];
const slotAt = (k, time) => (lost(k, time) ? "lost" : phaseAt(time).roles[k] < 0 ? "–" : `${phaseAt(time).roles[k]}${leads(k, time) ? " ★" : ""}`);
const COLUMNS = [
  ["robot", "", (k) => String(k), true],
  ["slot", "", slotAt, formation],
  ["does", "does", (k, time, state) => state.does, physics || planned],
  ["m/s", "n", (k, time, state) => state.speed.toFixed(2), true],
  ["wanted", "n", (k, time) => wanted.speed[k][reached(wanted.time, time)].toFixed(2), Boolean(wanted)],
  ["clear", "n clear", (k, time) => clearAt(k, time).toFixed(2), Boolean(series)],
  ["parked", "n", (k) => (robots[k].path ? `${robots[k].path.end.toFixed(1)} s` : "–"), planned],
].filter((entry) => entry[3]);
for (const [head, kind] of [["", ""], ...COLUMNS]) element("th", id("heads"), head, kind).title = head === "clear" ? "distance to the nearest obstacle, m" : "";
const rows = robots.map((robot, k) => {
  const row = element("tr", id("robots")), chip = element("i", element("td", row));
  row.title = `${robot.model}: click to follow`;
  row.addEventListener("click", () => follow(camera.follow === k ? null : k));
  return { row, chip, cells: COLUMNS.map(([, kind]) => element("td", row, "", kind)) };
});

// A tag with its number above each robot and below where it is sent.
const tags = robots.map(() => element("b", id("labels"))), goalTags = robots.map(() => element("i", id("labels")));
function placeTag(tag, matrix, place, seen, down) {
  const [x, y, , w] = apply(matrix, place), inside = seen && w > 0 && Math.abs(x) < 1.05 && Math.abs(y) < 1.05;
  tag.style.display = inside ? "" : "none";
  if (inside) tag.style.transform = `translate(${(x + 1) / 2 * canvas.clientWidth}px, ${(1 - y) / 2 * canvas.clientHeight}px) translate(-50%, ${down}%)`;
}

function fillTeam(view, time) {
  robots.forEach((robot, k) => {
    const state = stateAt(robot, time), { row, chip, cells } = rows[k], alarm = alarmAt(robot, time), colour = colourOf(k);
    chip.style.background = colour;
    COLUMNS.forEach(([head, kind, text], i) => {
      put(cells[i], text(k, time, state));
      if (head === "does") cells[i].className = state.tone;
      if (head === "clear") cells[i].classList.toggle("bad", clearAt(k, time) < run.radius);
    });
    row.classList.toggle("on", camera.follow === k);
    row.classList.toggle("alarm", alarm !== "");
    row.classList.toggle("lost", lost(k, time));
    const tag = tags[k], gone = lost(k, time) ? "lost" : leads(k, time) ? "★" : "";
    put(tag, [k, gone, alarm].filter((word) => word !== "").join(" "));
    tag.style.background = colour;
    tag.classList.toggle("alarm", alarm !== "");
    tag.classList.toggle("leads", leads(k, time));
    // From above the tag stands beside the body.
    const up = camera.top ? [-Math.cos(camera.turn) * 0.2, -Math.sin(camera.turn) * 0.2, 0] : [0, 0, physics ? 0.2 : 0.28];
    placeTag(tag, view, add(state.place, up), shown.labels, -110);
    const role = formation && phaseAt(time).state !== "inactive" ? phaseAt(time).roles[k] : -1;
    if (role >= 0) { put(goalTags[k], String(robots[k].index)); goalTags[k].style.color = colour; }
    placeTag(goalTags[k], view, role >= 0 ? onGround(goalAt(k, time)) : [0, 0, 0], role >= 0 && shown.labels && shown.goals, 35);
  });
}

// The feet of the robot that is followed, or of the first one: dark where they carry much.
const LEGS = ["FL", "FR", "RL", "RR"], WINDOW = 2, AHEAD = 0.5;
function fillFeet(time) {
  if (!physics) return;
  const robot = robots[typeof camera.follow === "number" ? camera.follow : 0], state = stateAt(robot, time);
  const { pen, width, height, fill } = canvasOf("gait"), lane = height / 4, left = 22, scale = (width - left) / WINDOW, start = time - WINDOW + AHEAD;
  put(id("feetname"), `Robot ${robot.index}`);
  pen.font = "11px system-ui, sans-serif";
  pen.textBaseline = "middle";
  const [from] = between(clock, start), to = between(clock, time + AHEAD)[1], half = 0.5 * robot.body.weight, colour = colourOf(robot.index);
  LEGS.forEach((leg, i) => {
    const top = i * lane + 2, thick = lane - 4;
    pen.globalAlpha = 1;
    pen.fillStyle = ink.soft;
    pen.fillText(leg, 0, top + thick / 2);
    fill(ink.page, left, top, width - left, thick);
    for (let k = Math.max(from, 1); k <= to; k++) {
      const force = upward(robot, k, i);
      if (force < TOUCH) continue;
      const x0 = Math.max(left + (clock[k - 1] - start) * scale, left), x1 = Math.min(left + (clock[k] - start) * scale, width);
      pen.globalAlpha = Math.min(0.25 + 0.75 * force / half, 1);
      if (x1 > x0) fill(colour, x0, top, x1 - x0, thick);
    }
  });
  pen.globalAlpha = 1;
  fill(ink.ink, left + (WINDOW - AHEAD) * scale - 0.5, 0, 1.2, height);
  const [x, y, z] = state.place, degrees = (v) => `${(v * 180 / Math.PI).toFixed(1)}°`;
  put(id("height"), `${(z - groundAt(x, y)).toFixed(3)} m`);
  put(id("lean"), `${degrees(state.roll)}, ${degrees(state.pitch)}`);
  put(id("load"), `${state.load} % of the limit`);
  id("bar").style.width = `${Math.min(state.load, 100)}%`;
  id("bar").classList.toggle("full", state.load >= 99);
}

// What happened when: falls, unwanted contacts, the notes of the run.
const MOST = 200, told = [
  ...(scene.falls || []).map(([time, who]) => ({ time, who, kind: "fall", text: "falls" })),
  ...(scene.contacts || []).map(([time, who, part, other]) => ({ time, who, kind: "touch", text: `${part} touches ${other}` })),
  ...(run ? run.notes : []).map(([time, text]) => ({ time, who: -1, kind: "note", text })),
].sort((a, b) => a.time - b.time);
const happened = told.slice(0, MOST).map(({ time, who, kind, text }) => {
  const row = element("li", id("log"), "", kind);
  element("time", row, `${time.toFixed(1)} s`);
  const chip = element("i", row);
  if (who >= 0) chip.style.background = palette(who);
  element("span", row, text);
  row.addEventListener("click", () => { goTo(time - 0.3); if (who >= 0) follow(who); });
  return row;
});
id("events").hidden = !told.length;
if (told.length > MOST) id("log").append(`and ${told.length - MOST} more`);

let current = -2;
function fillEvents(time) {
  let last = -1;
  while (last + 1 < happened.length && told[last + 1].time <= time + 1e-6) last++;
  if (last === current) return;
  current = last;
  happened.forEach((row, k) => { row.classList.toggle("past", k <= last); row.classList.toggle("now", k === last); });
  if (last >= 0) happened[last].scrollIntoView({ block: "nearest" });
}

// A bar of a round length; only from above has the picture one scale.
function fillScale() {
  const pixels = canvas.clientHeight / (2 * Math.tan(HALF_ANGLE) * camera.away), metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((m) => m * pixels > 48) || 200;
  id("scale").hidden = !camera.top;
  put(id("metres"), `${metres} m`);
  id("ruler").style.width = `${metres * pixels}px`;
}
