// Robots: links as they look in physics; else a body with legs of two links, or a box or a disc.
const dark = () => document.documentElement.dataset.theme === "dark";
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const ink = {};
function readTheme() {
  for (const name of ["page", "card", "line", "ink", "soft", "sky", "walk", "fly", "rest", "turn", "bad", "badfill"]) ink[name] = css(`--${name}`);
}

// Its own colour, or that of its slot; grey where it is lost.
const palette = (k) => { const colours = scene.colours[dark() ? "dark" : "light"]; return colours[k % colours.length]; };
const colourOf = (k, time = now) => (lost(k, time) ? ink.soft : palette(shown.slots ? Math.max(phaseAt(time).roles[k], 0) : k));
const paintOf = (k) => rgb(colourOf(k));
const deepOf = (k) => scaled(paintOf(k), dark() ? 1 : 0.72);

const STANDS = [0.13, 0.13, 0.14], SWINGS = [0.95, 0.95, 0.95], ARROW = [0.49, 0.18, 0.94];
const PER_WEIGHT = 0.36;  // how long an arrow of the whole weight is, m

function drawRobot(robot, time) {
  const state = stateAt(robot, time), paint = paintOf(robot.index);
  if (physics) drawLinks(robot, state);
  else if (robot.legs) drawStepping(robot, state, paint, time);
  else drawBlock(robot, state, paint);
}

function drawBlock({ size: [length, width, height], round }, { place: [x, y], yaw }, paint) {
  const c = Math.cos(yaw), s = Math.sin(yaw), base = groundAt(x, y), half = Math.min(0.5 * height, 0.2), nose = 0.3 * length;
  drawMesh(round ? disc : cube, boxed([c * length / 2, s * length / 2, 0], [-s * width / 2, c * width / 2, 0], [0, 0, half], [x, y, base + half]), paint);
  drawMesh(cube, boxed([c * 0.12 * length, s * 0.12 * length, 0], [-s * 0.12 * width, c * 0.12 * width, 0], [0, 0, 0.03], [x + c * nose, y + s * nose, base + 2 * half + 0.01]), [0.15, 0.16, 0.18]);
}

function drawStepping(robot, state, paint, time) {
  const { x: hx, y: hy, link } = robot.legs, [length, width] = robot.size, { place: at, yaw } = state;
  const c = Math.cos(yaw), s = Math.sin(yaw), feet = [0, 1, 2, 3].map((leg) => footAt(robot, leg, time, state));
  let pitch = Math.atan2(0.5 * (feet[0].at[2] + feet[1].at[2] - feet[2].at[2] - feet[3].at[2]), 2 * hx);
  pitch = clamp(state.phase ? 0.4 * pitch : pitch, -0.5, 0.5);
  const x = [c * Math.cos(pitch), s * Math.cos(pitch), Math.sin(pitch)], y = [-s, c, 0], z = cross(x, y);
  const long = 0.42 * length, wide = Math.min(hy + 0.035, 0.45 * width);
  drawMesh(cube, boxed(scaled(x, long), scaled(y, wide), scaled(z, 0.055), add(at, z, 0.02)), paint);
  drawMesh(cube, boxed(scaled(x, 0.05), scaled(y, 0.7 * wide), scaled(z, 0.045), add(add(at, x, long + 0.03), z, 0.045)), [0.13, 0.14, 0.16]);
  const limbs = paint.map((v) => 0.25 + 0.5 * v);
  for (let leg = 0; leg < 4; leg++) {
    const left = leg % 2 ? -1 : 1, hip = add(add(at, x, leg < 2 ? hx : -hx), y, left * (hy + 0.02));
    const foot = add(feet[leg].at, [0, 0, 0.02]), away = sub(foot, hip), far = Math.hypot(...away);
    const bend = Math.sqrt(Math.max(link * link - 0.25 * far * far, 0.0002)), out = unit(cross(away, y));
    // Knees point backwards.
    const knee = add(add(hip, away, 0.5), out, dot(out, x) > 0 ? -bend : bend);
    limb(hip, knee, 0.024, limbs, y);
    limb(knee, foot, 0.017, scaled(limbs, 0.8), y);
    drawMesh(cube, boxed([0.022, 0, 0], [0, 0.022, 0], [0, 0, 0.022], foot), feet[leg].stands ? STANDS : SWINGS);
  }
}

// The shell of the trunk has the robot's colour, light parts of the legs a touch of it.
function painted(shape, paint) {
  if ((shape.colour[0] + shape.colour[1] + shape.colour[2]) / 3 < 0.42) return shape.colour;
  const share = shape.part === "trunk" ? 1 : 0.45;
  return shape.colour.map((v, i) => v + share * (paint[i] - v));
}

// The shapes of each link made one mesh.
function linkMesh(shapes, paint) {
  const { face, made } = faces();
  for (const shape of shapes) {
    const turn = turnOf(shape.turn), colour = painted(shape, paint);
    for (const [at, normal] of FACES[shape.kind](shape.size)) face([add(shape.at, turned(turn, at))], turned(turn, normal), colour);
  }
  return made();
}

const dressed = new Map();
function linkMeshes(robot) {
  const colour = colourOf(robot.index), key = colour + scene.robots[robot.index].body, { looks } = robot.body;
  if (!dressed.has(key))
    dressed.set(key, Array.from({ length: 13 }, (_, link) => linkMesh(looks.filter((shape) => shape.link === link && shape.part !== "foot"), rgb(colour))));
  return dressed.get(key);
}

function drawLinks(robot, state) {
  const r = robot.body.radius;
  linkMeshes(robot).forEach((link, k) => { if (link) drawMesh(link, boxed(...state.turn[k], state.at[k]), [1, 1, 1], 0, 0, 0.16); });
  state.feet.forEach((at, leg) => {
    const stands = Math.hypot(...state.forces[leg]) > TOUCH;
    drawMesh(ball, boxed([r, 0, 0], [0, r, 0], [0, 0, r], at), stands ? STANDS : SWINGS, 0, 0, 0.1);
    if (shown.forces && stands && drawing === meshes) drawArrow(add(at, [0, 0, -r]), scaled(state.forces[leg], PER_WEIGHT / robot.body.weight));
  });
}

// The force of the ground on a foot, from where they touch.
function drawArrow(from, along) {
  const size = Math.hypot(...along), z = scaled(along, 1 / size), side = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), other = cross(z, side);
  const head = Math.min(0.045, 0.5 * size), thick = 0.0055, wide = 0.3 * head, bar = size - head;
  drawMesh(shaft, boxed(scaled(side, thick), scaled(other, thick), scaled(z, bar), from), ARROW, 0, 0, 0.1);
  drawMesh(tip, boxed(scaled(side, wide), scaled(other, wide), scaled(z, head), add(from, z, bar)), ARROW, 0, 0, 0.1);
}
