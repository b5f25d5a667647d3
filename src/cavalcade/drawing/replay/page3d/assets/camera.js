// An orbit camera: drag turns, right or shift drag moves, wheel and pinch zoom. The page gives
// `bounds` (x0, y0, x1, y1 of what is worth seeing), `level` (its height), `eyesOn(who)` (a place)
// and `known(who)`.
const camera = { target: [0, 0, 0], away: 10, turn: 0, lift: 0.8, follow: null };

function wholeView(lift = 0.75) {
  const [x0, y0, x1, y1] = bounds, cx = (x0 + x1) / 2, cy = (y0 + y1) / 2;
  Object.assign(camera, { target: [cx, cy, level], turn: -Math.PI / 2 - (lift > 1.4 ? 0 : 0.35), lift, follow: null });
  // As near as all of it stays in the picture.
  const half = [(x1 - x0) / 2 + 0.8, (y1 - y0) / 2 + 0.8];
  for (camera.away = 2; camera.away < 400; camera.away *= 1.03) {
    const m = viewMatrix();
    const inside = [[-1, -1], [1, -1], [1, 1], [-1, 1]].every(([a, b]) => {
      const [px, py, , w] = apply(m, [cx + a * half[0], cy + b * half[1], camera.target[2]]);
      return w > 0 && Math.abs(px) < 0.96 && Math.abs(py) < 0.92;
    });
    if (inside) break;
  }
}

function eyeAt() {
  const { target, away, turn, lift } = camera;
  return add(target, [Math.cos(turn) * Math.cos(lift), Math.sin(turn) * Math.cos(lift), Math.sin(lift)], away);
}

function viewMatrix() {
  const up = camera.lift > 1.5 ? [-Math.cos(camera.turn), -Math.sin(camera.turn), 0] : [0, 0, 1];
  const aspect = canvas.width / Math.max(canvas.height, 1);
  return times(perspective(0.7, aspect, camera.away * 0.02, camera.away * 6 + 60), lookAt(eyeAt(), camera.target, up));
}

// Stay with a robot (its number) or with all of them ("team"), `away` from it at most.
function follow(who, away = 3.2) {
  if (who === null) { camera.follow = null; redraw(); return; }
  if (!known(who)) return;
  Object.assign(camera, { follow: who, away: who === "team" ? away : Math.min(camera.away, away), lift: Math.min(camera.lift, 0.45) });
  redraw();
}

function pan(dx, dy) {
  const per = camera.away * 0.73 / canvas.clientHeight, s = Math.sin(camera.turn), c = Math.cos(camera.turn);
  const flat = Math.max(Math.sin(camera.lift), 0.25);
  camera.follow = null;
  camera.target = add(camera.target, [(s * dx - c * dy / flat) * per, (-c * dx - s * dy / flat) * per, 0]);
}

const fingers = new Map();
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  canvas.classList.add("drag");
});
for (const kind of ["pointerup", "pointercancel"])
  canvas.addEventListener(kind, (event) => { fingers.delete(event.pointerId); canvas.classList.remove("drag"); });
canvas.addEventListener("pointermove", (event) => {
  const last = fingers.get(event.pointerId);
  if (!last) return;
  const dx = event.clientX - last[0], dy = event.clientY - last[1];
  if (fingers.size === 2) {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
    zoom(apart(last) / apart([event.clientX, event.clientY]));
    pan(dx / 2, dy / 2);
  } else if (event.shiftKey || event.buttons & 2) pan(dx, dy);
  else {
    camera.turn -= dx * 0.006;
    camera.lift = Math.min(Math.max(camera.lift + dy * 0.005, 0.05), 1.55);
  }
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  redraw();
});
canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.001)); redraw(); }, { passive: false });

function zoom(factor) { camera.away = Math.min(Math.max(camera.away * factor, 0.6), 300); }
