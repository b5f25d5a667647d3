// Time, drawing, buttons and keys.
let ratio = window.devicePixelRatio || 1, now = 0, playing = false, speed = 1, asked = false, stamp = 0;
const shown = { paths: true, footholds: true, goals: true, labels: true };
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const ICONS = { play: '<svg viewBox="0 0 16 16"><path d="M3 1.5v13l11-6.5z"/></svg>', pause: '<svg viewBox="0 0 16 16"><path d="M3 2h3.5v12H3zM9.5 2H13v12H9.5z"/></svg>' };

function redraw() {
  if (!asked) { asked = true; requestAnimationFrame(frame); }
}

function frame(when) {
  asked = false;
  if (playing) {
    now = Math.min(now + Math.min((when - stamp) / 1000, 0.1) * speed, plan.end);
    if (now >= plan.end) setPlaying(false);
  }
  stamp = when;
  draw();
  if (playing) redraw();
}

function draw() {
  if (camera.follow >= 0) { const at = poseAt(robots[camera.follow], now); camera.target = [at.x, at.y, at.z - 0.1]; }
  const sky = rgb(css("--sky"));
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(...sky, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
  const view = viewMatrix();
  fed = null;
  gl.useProgram(meshes.made);
  gl.uniformMatrix4fv(meshes.at.view, false, view);
  gl.uniform3fv(meshes.at.eye, eyeAt());
  drawGround();
  for (const robot of robots) drawRobot(robot, now);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  if (shown.footholds) {
    gl.useProgram(dots.made);
    gl.uniformMatrix4fv(dots.at.view, false, view);
    drawMarks(now);
  }
  gl.useProgram(strokes.made);
  gl.uniformMatrix4fv(strokes.at.view, false, view);
  gl.uniform2f(strokes.at.screen, canvas.width / 2, canvas.height / 2);
  if (shown.goals) places.draw(1.2 * ratio);
  drawFootprints(now);
  gl.depthMask(false);
  if (shown.paths) trails.draw(1.5 * ratio, now, 0.3);
  gl.depthMask(true);
  placeTags(view, now);
  fillTeam(now);
  id("seek").value = Math.round(1000 * now / Math.max(plan.end, 1e-6));
  id("clock").innerHTML = `<b>${now.toFixed(2)}</b> <span>/ ${plan.end.toFixed(1)} s</span>`;
}

function setPlaying(on) {
  if (on && now >= plan.end) now = 0;
  playing = on;
  id("play").innerHTML = on ? ICONS.pause : ICONS.play;
  id("play").setAttribute("aria-label", on ? "Pause" : "Play");
  stamp = performance.now();
  redraw();
}

function goTo(time) { now = Math.min(Math.max(time, 0), plan.end); redraw(); }

function setSpeed(value) { speed = value; id("speed").value = String(value); }

function resize() {
  ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  drawBand();
  redraw();
}

function button(where, text, action, pressed) {
  const made = document.createElement("button");
  made.textContent = text;
  if (pressed !== undefined) made.setAttribute("aria-pressed", pressed);
  made.addEventListener("click", () => { action(made); redraw(); });
  id(where).append(made);
}

button("views", "Whole", () => wholeView());
button("views", "Top", () => wholeView(1.55));
button("views", "Side", () => wholeView(0.12));
button("views", "Follow", () => follow((camera.follow + 1) % robots.length));
for (const name of Object.keys(shown)) {
  if (name === "footholds" && !marks.count) continue;
  button("layers", name, (made) => { shown[name] = !shown[name]; made.setAttribute("aria-pressed", shown[name]); }, true);
}
for (const value of SPEEDS) id("speed").append(new Option(`${value} ×`, value));
setSpeed(1);
id("speed").addEventListener("change", (event) => setSpeed(Number(event.target.value)));
id("play").addEventListener("click", () => setPlaying(!playing));
id("seek").addEventListener("input", (event) => goTo(plan.end * event.target.value / 1000));
const setTheme = (name) => { document.documentElement.dataset.theme = name; drawBand(); redraw(); };
id("theme").addEventListener("click", () => setTheme(dark() ? "light" : "dark"));

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
  const step = event.shiftKey ? 0.1 : 1, place = SPEEDS.indexOf(speed);
  const actions = {
    " ": () => setPlaying(!playing),
    ArrowLeft: () => goTo(now - step),
    ArrowRight: () => goTo(now + step),
    ArrowUp: () => setSpeed(SPEEDS[Math.min(place + 1, SPEEDS.length - 1)]),
    ArrowDown: () => setSpeed(SPEEDS[Math.max(place - 1, 0)]),
    Home: () => goTo(0),
    End: () => goTo(plan.end),
    t: () => wholeView(1.55),
    h: () => wholeView(),
    d: () => setTheme(dark() ? "light" : "dark"),
  };
  const action = actions[event.key] || actions[event.key.toLowerCase()] || (/^\d$/.test(event.key) ? () => follow(Number(event.key)) : null);
  if (!action) return;
  event.preventDefault();
  if (event.target.tagName === "BUTTON") event.target.blur();
  action();
  redraw();
});

window.addEventListener("resize", resize);
// `#t=3.2` opens at that time, `#follow=1` beside a robot, `#top` from above.
const said = new URLSearchParams(location.hash.slice(1).replace(/^top$/, "top=1"));
if (window.matchMedia("(prefers-color-scheme: dark)").matches) document.documentElement.dataset.theme = "dark";
resize();
wholeView(said.has("top") ? 1.55 : 0.75);
if (said.has("t")) goTo(Number(said.get("t")) || 0);
if (said.has("follow")) follow(Number(said.get("follow")));
setPlaying(!said.has("t"));
