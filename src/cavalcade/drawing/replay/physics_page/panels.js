// Everything around the picture: facts, team, one robot's feet, timeline.
fillFacts();
const DOES = ["stands", "walks", "flies", "fallen"];
if (!robots.some((robot) => robot.does.includes(2))) id("flightkey").remove();
if (!scene.contacts.length) id("touchkey").remove();
if (!scene.falls.length) id("fallkey").remove();
if (!planner) id("wantedhead").textContent = "";

const rows = robots.map((robot) => {
  const row = document.createElement("tr"), cells = [0, 1, 2, 3, 4].map(() => row.insertCell());
  const chip = document.createElement("i");
  chip.style.background = robot.colour;
  cells[0].append(chip);
  cells[1].textContent = robot.index;
  cells[3].className = cells[4].className = "n";
  row.title = "Follow this robot";
  row.addEventListener("click", () => follow(camera.follow === robot.index ? null : robot.index));
  id("robots").append(row);
  return { row, cells };
});

function fillTeam(time) {
  robots.forEach((robot, k) => {
    const state = stateAt(robot, time), { row, cells } = rows[k], wanted = wantedAt(k, time), alarm = alarmAt(robot, time);
    cells[2].textContent = DOES[state.does];
    cells[2].className = ["r", "w", "f", "bad"][state.does];
    cells[3].textContent = state.speed.toFixed(2);
    cells[4].textContent = wanted === null ? "" : wanted.toFixed(2);
    row.classList.toggle("on", camera.follow === k);
    row.classList.toggle("alarm", alarm !== "");
    tags[k].textContent = alarm ? `${k}  ${alarm}` : k;
    tags[k].classList.toggle("alarm", alarm !== "");
    tags[k].classList.toggle("leads", planner !== null && !planner.individual && robots.length > 1 && phaseAt(time).leader === k);
  });
}

// The feet of the robot that is followed, or of the first one: dark where they carry much.
const LEGS = ["FL", "FR", "RL", "RR"], WINDOW = 2, AHEAD = 0.5;
function fillFeet(time) {
  const robot = robots[typeof camera.follow === "number" ? camera.follow : 0], state = stateAt(robot, time);
  const box = id("gait"), wide = Math.max(Math.round(box.clientWidth * ratio), 1), tall = Math.max(Math.round(box.clientHeight * ratio), 1);
  if (box.width !== wide || box.height !== tall) { box.width = wide; box.height = tall; }
  const pen = box.getContext("2d"), lane = tall / 4, left = 22 * ratio, scale = (wide - left) / WINDOW, start = time - WINDOW + AHEAD;
  id("feetname").textContent = `Robot ${robot.index}`;
  pen.clearRect(0, 0, wide, tall);
  pen.font = `${11 * ratio}px system-ui, sans-serif`;
  pen.textBaseline = "middle";
  const [from] = between(start), [, to] = between(time + AHEAD), half = 0.5 * robot.body.weight;
  LEGS.forEach((leg, i) => {
    const top = i * lane + 2 * ratio, thick = lane - 4 * ratio;
    pen.globalAlpha = 1;
    pen.fillStyle = css("--soft");
    pen.fillText(leg, 0, top + thick / 2);
    pen.fillStyle = css("--page");
    pen.fillRect(left, top, wide - left, thick);
    pen.fillStyle = robot.colour;
    for (let k = Math.max(from, 1); k <= to; k++) {
      const force = upward(robot, k, i);
      if (force < TOUCH) continue;
      const x0 = Math.max(Math.round(left + (clock[k - 1] - start) * scale), left), x1 = Math.min(Math.round(left + (clock[k] - start) * scale), wide);
      pen.globalAlpha = Math.min(0.25 + 0.75 * force / half, 1);
      if (x1 > x0) pen.fillRect(x0, top, x1 - x0, thick);
    }
  });
  pen.globalAlpha = 1;
  pen.fillStyle = css("--ink");
  pen.fillRect(left + (WINDOW - AHEAD) * scale - ratio / 2, 0, 1.2 * ratio, tall);
  const [x, y, z] = state.place, degrees = (v) => `${(v * 180 / Math.PI).toFixed(1)}°`;
  id("height").textContent = `${(z - groundAt(x, y)).toFixed(3)} m`;
  id("lean").textContent = `${degrees(state.roll)}, ${degrees(state.pitch)}`;
  id("load").textContent = `${state.load} % of the limit`;
  id("bar").style.width = `${Math.min(state.load, 100)}%`;
  id("bar").classList.toggle("full", state.load >= 99);
}

// A lane per robot: its colour walks, grey stands, blue flies, red ticks are unwanted contacts.
function drawBand() {
  const band = id("band"), width = band.clientWidth * ratio, height = band.clientHeight * ratio;
  band.width = width; band.height = height;
  const pen = band.getContext("2d"), lanes = Math.max(robots.length, 1), room = height - 6 * ratio;
  const tall = Math.min(room / lanes, 12 * ratio), top = (height - tall * lanes) / 2, scale = (width - 8 * ratio) / Math.max(end, 1e-6), x = (time) => 4 * ratio + time * scale;
  robots.forEach((robot, k) => {
    const y = top + k * tall, thick = Math.max(tall - (tall > 3 * ratio ? ratio : 0), 1);
    for (const [does, from, to] of robot.spans) {
      pen.globalAlpha = does === 1 ? 0.78 : 1;
      pen.fillStyle = does === 0 ? css("--rest") : does === 1 ? robot.colour : css("--fly");
      pen.fillRect(x(from), does ? y : y + 0.3 * thick, Math.max(x(to) - x(from), 1), does ? thick : 0.4 * thick);
    }
    pen.globalAlpha = 1;
    if (robot.fell < Infinity) {
      pen.fillStyle = css("--bad");
      pen.fillRect(x(robot.fell), y, x(end) - x(robot.fell), thick);
    }
    for (const [when] of robot.contacts) {
      pen.fillStyle = css("--card");
      pen.fillRect(x(when) - 2 * ratio, y, 4 * ratio, thick);
      pen.fillStyle = css("--bad");
      pen.fillRect(x(when) - ratio, y - ratio, 2 * ratio, thick + 2 * ratio);
    }
  });
  pen.fillStyle = css("--ink");
  for (const [when] of planner ? planner.notes : []) {
    pen.beginPath(); pen.moveTo(x(when) - 3.5 * ratio, 0); pen.lineTo(x(when) + 3.5 * ratio, 0); pen.lineTo(x(when), 5 * ratio); pen.fill();
  }
}
