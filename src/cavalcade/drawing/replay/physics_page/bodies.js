// Robots as they look: the shapes of each link made one mesh, in the robot's own colour.
const bright = (colour) => (colour[0] + colour[1] + colour[2]) / 3;

// The shell of the trunk has the robot's colour, light parts of the legs a touch of it.
function painted(shape, paint) {
  if (bright(shape.colour) < 0.42) return shape.colour;
  const share = shape.part === "trunk" ? 1 : 0.45;
  return shape.colour.map((v, i) => v + share * (paint[i] - v));
}

function linkMesh(shapes, paint) {
  const p = [], n = [], c = [];
  for (const shape of shapes) {
    const turn = turnOf(shape.turn), colour = painted(shape, paint);
    for (const [at, normal] of FACES[shape.kind](shape.size)) {
      p.push(...add(shape.at, turned(turn, at))); n.push(...turned(turn, normal)); c.push(...colour);
    }
  }
  return p.length ? mesh(p, n, c) : null;
}

const dressed = new Map();
for (const robot of robots) {
  const key = robot.colour + scene.robots[robot.index].body, { looks } = robot.body;
  if (!dressed.has(key))
    dressed.set(key, Array.from({ length: 13 }, (_, link) => linkMesh(looks.filter((shape) => shape.link === link && shape.part !== "foot"), rgb(robot.colour))));
  robot.meshes = dressed.get(key);
}

const whole = (faces) => mesh(faces.flatMap(([p]) => p), faces.flatMap(([, n]) => n), faces.flatMap(() => [1, 1, 1]));
const ball = whole(capsuleFaces(1, 0));
const shaft = whole(lathe([[1, 0, 1, 0], [1, 1, 1, 0]], 12)), tip = whole(lathe([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0.9, 0.4], [0, 1, 0.9, 0.4]], 16));
const STANDS = [0.13, 0.13, 0.14], SWINGS = [0.95, 0.95, 0.95], ARROW = [0.49, 0.18, 0.94];
const PER_WEIGHT = 0.36;  // how long an arrow of the whole weight is, m

function drawRobot(robot, time) {
  const state = stateAt(robot, time);
  robot.meshes.forEach((link, k) => { if (link) drawMesh(link, boxed(...state.turn[k], state.at[k]), [1, 1, 1], 0, 0, 0.16); });
  const r = robot.body.radius;
  state.feet.forEach((at, leg) => {
    const stands = Math.hypot(...state.forces[leg]) > TOUCH;
    drawMesh(ball, boxed([r, 0, 0], [0, r, 0], [0, 0, r], at), stands ? STANDS : SWINGS, 0, 0, 0.1);
    if (shown.forces && stands && drawing === meshes) arrow(add(at, [0, 0, -r]), scaled(state.forces[leg], PER_WEIGHT / robot.body.weight));
  });
}

// The force of the ground on a foot, from where they touch.
function arrow(from, along) {
  const size = Math.hypot(...along), z = scaled(along, 1 / size), side = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), other = cross(z, side);
  const head = Math.min(0.045, 0.5 * size), thick = 0.0055, wide = 0.3 * head, bar = size - head;
  drawMesh(shaft, boxed(scaled(side, thick), scaled(other, thick), scaled(z, bar), from), ARROW, 0, 0, 0.1);
  drawMesh(tip, boxed(scaled(side, wide), scaled(other, wide), scaled(z, head), add(from, z, bar)), ARROW, 0, 0, 0.1);
}
