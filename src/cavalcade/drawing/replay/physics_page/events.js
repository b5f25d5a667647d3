// What happened when: falls, unwanted contacts, the planner's notes.
const said = [
  ...scene.falls.map(([time, who]) => ({ time, who, kind: "fall", text: "falls" })),
  ...scene.contacts.map(([time, who, part, other]) => ({ time, who, kind: "touch", text: `${part} touches ${other}` })),
  ...(planner ? planner.notes : []).map(([time, text]) => ({ time, who: -1, kind: "note", text })),
].sort((a, b) => a.time - b.time);

const MOST = 200, happened = said.slice(0, MOST).map((event) => {
  const row = document.createElement("li"), when = document.createElement("time"), chip = document.createElement("i"), text = document.createElement("span");
  when.textContent = `${event.time.toFixed(1)} s`;
  if (event.who >= 0) chip.style.background = robots[event.who].colour;
  text.textContent = event.text;
  row.className = event.kind;
  row.append(when, chip, text);
  row.addEventListener("click", () => { goTo(event.time - 0.3); if (event.who >= 0) follow(event.who); });
  id("log").append(row);
  return row;
});
if (!said.length) id("events").hidden = true;
if (said.length > MOST) id("log").append(`and ${said.length - MOST} more`);

let current = -2;
function fillEvents(time) {
  let last = -1;
  while (last + 1 < happened.length && said[last + 1].time <= time + 1e-6) last++;
  if (last === current) return;
  current = last;
  happened.forEach((row, k) => { row.classList.toggle("past", k <= last); row.classList.toggle("now", k === last); });
  if (last >= 0) happened[last].scrollIntoView({ block: "nearest" });
}

// What a robot ran into within the last second.
function alarmAt(robot, time) {
  if (time >= robot.fell) return "fallen";
  const hit = robot.contacts.find(([when]) => when <= time && time < when + 1);
  return hit ? `${hit[2]} – ${hit[3]}` : "";
}
