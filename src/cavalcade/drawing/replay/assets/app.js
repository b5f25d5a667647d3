// What is shown and how it opens: layers, points of view, keys, the drawing of a moment.
const LAYERS = [
  ["paths", "p", "paths", planned || (run !== null && run.lines.some((lines) => lines.some((line) => line.length > 1)))],
  ["trails", "r", "trails", trails.length],
  ["goals", "g", "goals", scene.individual || formation],
  ["springs", "s", "springs", formation && run.phases.some((phase) => phase.joints.length)],
  ["footholds", "o", "footholds", marks.some((mark) => mark.count)],
  ["forces", "c", "contact forces", physics],
  ["labels", "l", "labels", true],
  ["slots", physics ? "x" : "c", "colour by slot", formation],
];
const shown = Object.fromEntries(LAYERS.map(([name, , , useful]) => [name, Boolean(useful) && name !== "slots"])), buttons = {};

function toggle(name, on = !shown[name]) {
  if (!buttons[name]) return;
  shown[name] = on;
  buttons[name].setAttribute("aria-pressed", on);
  if (name === "slots") layPanels();
  redraw();
}

for (const [name, key, text, useful] of LAYERS) {
  if (!useful) continue;
  buttons[name] = button(id("layers"), text, `${text} (${key.toUpperCase()})`, () => toggle(name));
  buttons[name].setAttribute("aria-pressed", shown[name]);
}

const nextRobot = () => follow((typeof camera.follow === "number" ? camera.follow + 1 : 0) % robots.length);
const VIEWS = [
  ["Top", "The plane from straight above (T)", () => setTop(!camera.top)],
  ["Whole", "All of the way (H)", () => wholeView()],
  ["Side", "From the side", () => { if (camera.top) setTop(false); wholeView(0.12); }],
  ["Team", "Go with the team (F)", () => teamView()],
  ["Follow", "Go with one robot after another (0 to 9)", nextRobot],
];
for (const [text, hint, action] of VIEWS) button(id("views"), text, hint, () => { action(); redraw(); }).id = text.toLowerCase();
id("top").setAttribute("aria-pressed", "false");

const help = id("help"), ask = () => (help.open ? help.close() : help.showModal());
id("ask").addEventListener("click", ask);
help.addEventListener("click", (event) => { if (event.target === help) help.close(); });

// What keys do: how they are called, what for, and the actions of their events.
const KEYS = [
  [["space"], "play, pause", { " ": () => setPlaying(!playing), k: () => setPlaying(!playing) }],
  [["←", "→"], "1 s back, on; with shift 0.1 s", { ArrowLeft: (step) => goTo(now - step), ArrowRight: (step) => goTo(now + step) }],
  [["page ↑", "page ↓"], "5 s back, on", { PageUp: () => goTo(now - 5), PageDown: () => goTo(now + 5) }],
  [[",", "."], "one sample back, on", { ",": () => stepBy(-1), ".": () => stepBy(1) }],
  [["home", "end"], "to the start, the end", { Home: () => goTo(begin), End: () => goTo(end) }],
  [["↑", "↓"], "faster, slower", { ArrowUp: () => faster(1), ArrowDown: () => faster(-1) }],
  [["T"], "straight from above, or in perspective", { t: () => setTop(!camera.top) }],
  [["H"], "all of the way", { h: () => wholeView() }],
  [["F"], "go with the team", { f: () => (camera.follow === "team" ? wholeView() : teamView()) }],
  [["0", "…", "9"], "go with that robot", Object.fromEntries([..."0123456789"].map((key) => [key, () => follow(Number(key))]))],
  ...LAYERS.filter((layer) => layer[3]).map(([name, key, text]) => [[key.toUpperCase()], text, { [key]: () => toggle(name) }]),
  [["D"], "dark, light", { d: turnTheme }],
  [["drag"], "turns, from above moves; with shift or the right button the other way round"],
  [["wheel"], "zooms; a double click shows all"],
];
for (const [keys, text] of KEYS) {
  const name = element("dt", id("keys"));
  for (const key of keys) { element("kbd", name, key); name.append(" "); }
  element("dd", id("keys"), text);
}

const actions = Object.assign({ "?": ask }, ...KEYS.map((entry) => entry[2]));
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || help.open || event.target.tagName === "SELECT") return;
  const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  if (event.target.tagName === "BUTTON") event.target.blur();
  action(event.shiftKey ? 0.1 : 1);
  redraw();
});

function draw() {
  if (camera.follow !== null) camera.target = eyesOn(camera.follow);
  const view = viewMatrix(), radius = clamp(0.9 * camera.away, 2, 60), beside = camera.follow !== null && !camera.top;
  renderSolid(view, eyeAt(), camera.target, radius, rgb(ink.sky), () => {
    drawGround();
    if (!beside || drawing === depths) drawSolids();
    drawMovers(now);
    for (const robot of robots) drawRobot(robot, now);
  });
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  drawLines(view, now);
  if (beside) drawGhosts(camera.target, camera.follow === "team" ? 0.24 : 0.2);
  fillState(now);
  fillTeam(view, now);
  fillFeet(now);
  fillEvents(now);
  fillScale();
  moveCursors(now);
}

// The page opens playing. After `#`, joined by `&`: `t=3.2` opens it at that time, `play=1` playing
// all the same, `speed=4`, `top` from above, `theme=dark`, `follow=1` (or `team`) beside a robot;
// `away`, `lift` and `turn` place the camera; `show` and `hide` name layers: `hide=paths,labels`.
const night = window.matchMedia("(prefers-color-scheme: dark)");
night.addEventListener("change", () => { if (!wish.has("theme")) setTheme(night.matches ? "dark" : "light"); });
document.documentElement.dataset.theme = wish.has("dark") ? "dark" : wish.get("theme") || (night.matches ? "dark" : "light");
readTheme();
layPlaces();
resize();
new ResizeObserver(resize).observe(id("stage"));
setSpeed(Number(wish.get("speed") || 1));
for (const [names, on] of [["show", true], ["hide", false]]) for (const name of (wish.get(names) || "").split(",")) toggle(name, on);
goTo(Number(wish.get("t")) || begin);
if (wish.has("top")) setTop(true);
else if (physics) teamView();
else wholeView();
if (wish.has("follow")) follow(wish.get("follow") === "team" ? "team" : Number(wish.get("follow")));
for (const name of ["away", "lift", "turn"]) if (wish.has(name)) camera[name] = Number(wish.get(name));
const calm = wish.has("t") || window.matchMedia("(prefers-reduced-motion: reduce)").matches;
setPlaying(wish.has("play") ? wish.get("play") === "1" : !calm);
