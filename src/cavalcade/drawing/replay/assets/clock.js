// Time, the frame loop, the bar below, the theme. The page gives `draw()` and `layPanels()`.
let ratio = window.devicePixelRatio || 1, now = begin, playing = false, speed = 1, asked = false, stamp = 0;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16];
const ICONS = { play: '<svg viewBox="0 0 16 16"><path d="M3 1.5v13l11-6.5z"/></svg>', pause: '<svg viewBox="0 0 16 16"><path d="M3 2h3.5v12H3zM9.5 2H13v12H9.5z"/></svg>' };

function redraw() {
  if (!asked) { asked = true; requestAnimationFrame(frame); }
}

function frame(when) {
  asked = false;
  if (playing) {
    now = Math.min(now + clamp((when - stamp) / 1000, 0, 0.1) * speed, end);
    if (now >= end) setPlaying(false);
  }
  stamp = when;
  draw();
  const part = Math.round(1000 * (now - begin) / Math.max(end - begin, 1e-6));
  if (Number(id("seek").value) !== part) id("seek").value = part;
  id("seek").setAttribute("aria-valuetext", `${now.toFixed(1)} seconds`);
  id("clock").innerHTML = `<b>${now.toFixed(2)}</b> <span>/ ${end.toFixed(1)} s</span>`;
  if (playing) redraw();
}

function setPlaying(on) {
  if (on && now >= end) now = begin;
  playing = on && end > begin;
  id("play").innerHTML = playing ? ICONS.pause : ICONS.play;
  id("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  stamp = performance.now();
  redraw();
}

function goTo(time) { now = clamp(time, begin, end); redraw(); }

// One sample back or on.
function stepBy(sign) {
  setPlaying(false);
  goTo(now + sign * (clock && clock.length > 1 ? (clock[clock.length - 1] - clock[0]) / (clock.length - 1) : 0.05));
}

function setSpeed(value) { speed = SPEEDS.includes(value) ? value : 1; id("speed").value = String(speed); }
const faster = (by) => setSpeed(SPEEDS[clamp(SPEEDS.indexOf(speed) + by, 0, SPEEDS.length - 1)]);

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  readTheme();
  layPlaces();
  layPanels();
  redraw();
}

function turnTheme() {
  setTheme(dark() ? "light" : "dark");
  remember("theme", document.documentElement.dataset.theme);
}

function resize() {
  ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  layPanels();
  // At once: a canvas that gets a new size is empty until then.
  draw();
}

// Keeps a choice in the page's address, so that loading it again shows the same.
const wish = new URLSearchParams(location.hash.slice(1).replace(/(^|&)(top|dark)(?=&|$)/g, "$1$2=1"));
function remember(name, value) {
  if ((wish.get(name) || "") === value) return;
  if (value) wish.set(name, value); else wish.delete(name);
  location.replace(`#${wish}`);
}

for (const value of SPEEDS) id("speed").append(new Option(`${value} ×`, value));
id("speed").addEventListener("change", (event) => { setSpeed(Number(event.target.value)); event.target.blur(); });
id("play").addEventListener("click", () => setPlaying(!playing));
id("seek").addEventListener("input", (event) => goTo(begin + (end - begin) * event.target.value / 1000));
id("theme").addEventListener("click", turnTheme);
