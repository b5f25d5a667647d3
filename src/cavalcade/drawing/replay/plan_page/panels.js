// Everything around the picture: title, team, facts, timeline.
fillFacts();
if (!robots.some((robot) => robot.legs)) id("going").textContent = "driving";
if (!robots.some((robot) => robot.path && robot.path.spans.some((s) => s[0] === 2))) id("flightkey").remove();

const rows = robots.map((robot) => {
  const row = document.createElement("tr"), cells = [0, 1, 2, 3, 4].map(() => row.insertCell());
  const chip = document.createElement("i");
  chip.style.background = robot.colour;
  cells[0].append(chip);
  cells[1].textContent = robot.index;
  cells[3].className = cells[4].className = "n";
  cells[4].textContent = robot.path ? `${robot.path.end.toFixed(1)} s` : "–";
  row.title = "Follow this robot";
  row.addEventListener("click", () => follow(camera.follow === robot.index ? null : robot.index));
  id("robots").append(row);
  return { row, cells };
});

function fillTeam(time) {
  robots.forEach((robot, k) => {
    const { row, cells } = rows[k], does = doing(robot, time);
    cells[2].textContent = does;
    cells[2].className = does === "flight" ? "f" : ["walks", "drives", "turns", "take-off", "landing"].includes(does) ? "w" : "r";
    cells[3].textContent = poseAt(robot, time).speed.toFixed(2);
    row.classList.toggle("on", camera.follow === k);
  });
}

// A lane per robot: grey stands, red walks, blue flies.
function drawBand() {
  const band = id("band"), width = band.clientWidth * ratio, height = band.clientHeight * ratio;
  band.width = width; band.height = height;
  const pen = band.getContext("2d"), lanes = Math.max(robots.length, 1), room = height - 6 * ratio;
  const tall = Math.min(room / lanes, 12 * ratio), top = (height - tall * lanes) / 2, scale = (width - 8 * ratio) / Math.max(end, 1e-6);
  const colours = [css("--rest"), css("--walk"), css("--fly"), css("--turn")];
  robots.forEach((robot, k) => {
    const y = top + k * tall, thick = Math.max(tall - (tall > 3 * ratio ? ratio : 0), 1);
    for (const [kind, from, to] of robot.path ? robot.path.spans : []) {
      pen.fillStyle = colours[kind];
      pen.fillRect(4 * ratio + from * scale, y, Math.max((to - from) * scale, 1), thick);
    }
    if (robot.path) {
      pen.fillStyle = colours[0];
      pen.fillRect(4 * ratio + robot.path.end * scale, y + 0.35 * thick, (end - robot.path.end) * scale, Math.max(0.3 * thick, 1));
    }
  });
}
