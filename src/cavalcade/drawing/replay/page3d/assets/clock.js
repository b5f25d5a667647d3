// Time, the frame loop, the bar below and the keys. The page gives `shown` (its layers),
// `drawSolid(time)`, `drawOver(view, time)`, `drawBand()` and `moreKeys`.
let ratio = window.devicePixelRatio || 1, now = 0, playing = false, speed = 1, asked = false, stamp = 0;
const end = scene.end, SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const ICONS = { play: '<svg viewBox="0 0 16 16"><path d="M3 1.5v13l11-6.5z"/></svg>', pause: '<svg viewBox="0 0 16 16"><path d="M3 2h3.5v12H3zM9.5 2H13v12H9.5z"/></svg>' };

function redraw() {
  if (!asked) { asked = true; requestAnimationFrame(frame); }
}

function frame(when) {
  asked = false;
  if (playing) {
    now = Math.min(now + Math.min((when - stamp) / 1000, 0.1) * speed, end);
    if (now >= end) setPlaying(false);
  }
  stamp = when;
  draw();
  if (playing) redraw();
}

function draw() {
  if (camera.follow !== null) camera.target = eyesOn(camera.follow);
  const view = viewMatrix(), radius = Math.min(Math.max(0.9 * camera.away, 2), 60);
  renderSolid(view, eyeAt(), camera.target, radius, rgb(css("--sky")), () => {
    drawGround();
    if (camera.follow === null || drawing === depths) drawSolids();
    drawSolid(now);
  });
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  drawOver(view, now);
  if (camera.follow !== null) drawGhosts(camera.target, camera.follow === "team" ? 0.24 : 0.2);
  id("seek").value = Math.round(1000 * now / Math.max(end, 1e-6));
  id("clock").innerHTML = `<b>${now.toFixed(2)}</b> <span>/ ${end.toFixed(1)} s</span>`;
}

function setPlaying(on) {
  if (on && now >= end) now = 0;
  playing = on;
  id("play").innerHTML = on ? ICONS.pause : ICONS.play;
  id("play").setAttribute("aria-label", on ? "Pause" : "Play");
  stamp = performance.now();
  redraw();
}

function goTo(time) { now = Math.min(Math.max(time, 0), end); redraw(); }

function setSpeed(value) { speed = value; id("speed").value = String(value); }

function resize() {
  ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  drawBand();
  redraw();
}

function button(where, text, action, pressed, hint) {
  const made = document.createElement("button");
  made.textContent = text;
  if (hint) made.title = hint;
  if (pressed !== undefined) made.setAttribute("aria-pressed", pressed);
  made.addEventListener("click", () => { action(made); redraw(); });
  id(where).append(made);
  return made;
}

function layerButton(name) {
  return button("layers", name, (made) => { shown[name] = !shown[name]; made.setAttribute("aria-pressed", shown[name]); }, shown[name]);
}

for (const value of SPEEDS) id("speed").append(new Option(`${value} ×`, value));
setSpeed(1);
id("speed").addEventListener("change", (event) => setSpeed(Number(event.target.value)));
id("play").addEventListener("click", () => setPlaying(!playing));
id("seek").addEventListener("input", (event) => goTo(end * event.target.value / 1000));
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
    End: () => goTo(end),
    t: () => wholeView(1.55),
    h: () => wholeView(),
    d: () => setTheme(dark() ? "light" : "dark"),
    ...moreKeys,
  };
  const action = actions[event.key] || actions[event.key.toLowerCase()] || (/^\d$/.test(event.key) ? () => follow(Number(event.key)) : null);
  if (!action) return;
  event.preventDefault();
  if (event.target.tagName === "BUTTON") event.target.blur();
  action();
  redraw();
});

// A tag with a number above each robot.
const tags = robots.map((robot) => {
  const tag = document.createElement("b");
  tag.textContent = robot.index;
  tag.style.background = robot.colour;
  id("labels").append(tag);
  return tag;
});

function placeTag(k, matrix, place) {
  const [x, y, , w] = apply(matrix, place);
  const seen = w > 0 && Math.abs(x) < 1.05 && Math.abs(y) < 1.05 && shown.labels;
  tags[k].style.display = seen ? "" : "none";
  if (seen) tags[k].style.transform = `translate(${(x + 1) / 2 * canvas.clientWidth}px, ${(1 - y) / 2 * canvas.clientHeight}px) translate(-50%, -110%)`;
}

function fillFacts() {
  id("name").textContent = scene.name;
  id("outcome").textContent = scene.outcome.text;
  id("outcome").classList.add(scene.outcome.good ? "good" : "bad");
  for (const [name, value] of scene.facts) {
    const term = document.createElement("dt"), said = document.createElement("dd");
    term.textContent = name; said.textContent = value;
    id("numbers").append(term, said);
  }
}

// The page opens playing, in the view that `open` makes. After `#`, joined by `&`: `t=3.2` opens it
// at that time, `follow=1` (or `team`) beside a robot, `top=1` from above, `dark=1` in the dark;
// `away`, `lift` and `turn` place the camera, `hide=paths,labels` leaves layers out.
function begin(open) {
  const said = new URLSearchParams(location.hash.slice(1).replace(/(^|&)(top|dark)(?=&|$)/g, "$1$2=1"));
  if (said.has("dark") || window.matchMedia("(prefers-color-scheme: dark)").matches) document.documentElement.dataset.theme = "dark";
  window.addEventListener("resize", resize);
  resize();
  if (said.has("t")) goTo(Number(said.get("t")) || 0);
  if (said.has("top")) wholeView(1.55);
  else { wholeView(); if (!said.has("follow")) open(); }
  if (said.has("follow")) follow(said.get("follow") === "team" ? "team" : Number(said.get("follow")));
  for (const name of ["away", "lift", "turn"]) if (said.has(name)) camera[name] = Number(said.get(name));
  for (const name of (said.get("hide") || "").split(",")) if (name in shown) shown[name] = false;
  setPlaying(!said.has("t"));
}
