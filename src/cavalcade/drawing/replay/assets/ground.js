// The ground and what is solid on it.
const identity = boxed([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]);
const PALETTE = ["#8fa7ad", "#b5c4b1", "#dcdcb8", "#ecdfc0", "#e3cdae", "#d6b797"].map(rgb);

function heightColour(share) {
  const v = Math.min(Math.max(share, 0), 1) * (PALETTE.length - 1), k = Math.min(Math.floor(v), PALETTE.length - 2);
  return PALETTE[k].map((part, i) => part + (v - k) * (PALETTE[k + 1][i] - part));
}

const SHAPE = [0.50, 0.53, 0.57], WALL = [0.56, 0.59, 0.63], UNKNOWN = [0.76, 0.77, 0.79], MOVER = [0.60, 0.42, 0.32];
const QUAD = [0, 1, 2, 0, 2, 3], UP = [0, 0, 1];

const ground = terrain ? terrainMesh() : flatMesh();
const contour = terrain && terrain.span > 0.02 ? niceStep(terrain.span / 7) : 0;

function niceStep(v) {
  const ten = 10 ** Math.floor(Math.log10(v));
  return [1, 2, 5, 10].map((f) => f * ten).find((s) => s >= v);
}

function flatMesh() {
  const { face, made } = faces();
  face(QUAD.map((k) => [...border[k], 0]), UP, [0.93, 0.935, 0.925]);
  return made();
}

function terrainMesh() {
  const { x, y, height, blocked, origin, low, span } = terrain, n = x.length, m = y.length;
  const place = [], normal = [], colour = [], index = [];
  const c = Math.cos(origin[2]), s = Math.sin(origin[2]), level = span < 0.02;
  // The outermost nodes stand for their cells up to the border.
  const edge = (v, k, last) => (k === 0 ? 0 : k === last ? v[last] + v[0] : v[k]);
  for (let j = 0; j < m; j++)
    for (let i = 0; i < n; i++) {
      const k = j * n + i, i0 = Math.max(i - 1, 0), i1 = Math.min(i + 1, n - 1), j0 = Math.max(j - 1, 0), j1 = Math.min(j + 1, m - 1);
      place.push(...placed(origin, edge(x, i, n - 1), edge(y, j, m - 1)), height[k]);
      const gx = (height[j * n + i1] - height[j * n + i0]) / (x[i1] - x[i0]), gy = (height[j1 * n + i] - height[j0 * n + i]) / (y[j1] - y[j0]);
      normal.push(...unit([-(c * gx - s * gy), -(s * gx + c * gy), 1]));
      const paint = heightColour(level ? 0.6 : (height[k] - low) / span), dark = blocked(k) ? 0.68 : 1;
      colour.push(...paint.map((part) => part * dark));
      if (i < n - 1 && j < m - 1) index.push(k, k + 1, k + n + 1, k, k + n + 1, k + n);
    }
  return mesh(place, normal, colour, index);
}

// A collector of flat faces, or of their corners one by one, with their normals.
function faces() {
  const p = [], n = [], c = [];
  const face = (points, normal, paint) => points.forEach((at) => { p.push(...at); n.push(...normal); c.push(...paint); });
  // Over a ring counter-clockwise, whose triangles `fill` names.
  const prism = ({ ring, fill, low, high }, paint) => {
    face(fill.map((k) => [...ring[k], high]), UP, paint);
    ring.forEach((a, k) => {
      const b = ring[(k + 1) % ring.length], corners = [[...a, low], [...b, low], [...b, high], [...a, high]];
      face(QUAD.map((i) => corners[i]), unit([b[1] - a[1], a[0] - b[0], 0]), paint);
    });
  };
  return { face, prism, made: () => (p.length ? mesh(p, n, c) : null) };
}

// The corners of rectangles of cells.
function* boxesOf(cells) {
  for (let k = 0; cells && k < cells.boxes.length; k += 4) {
    const [r0, c0, r1, c1] = cells.boxes.slice(k, k + 4).map((v) => v * cells.cell);
    yield [[c0, r0], [c1, r0], [c1, r1], [c0, r1]].map((at) => placed(cells.origin, ...at));
  }
}

const solids = (() => {
  const { prism, made } = faces();
  for (const solid of scene.solids) prism({ ...solid, ring: points(solid.ring) }, SHAPE);
  for (const ring of boxesOf(scene.walls)) prism({ ...scene.walls, ring, fill: QUAD }, WALL);
  return made();
})();

const unknown = (() => {
  const { face, made } = faces();
  for (const ring of boxesOf(scene.unknown)) face(QUAD.map((i) => onGround(ring[i], 0.004)), UP, UNKNOWN);
  return made();
})();

function drawGround() {
  // Level ground takes shadows and throws none.
  const night = terrain ? [0.52, 0.54, 0.56] : [0.25, 0.265, 0.285], tint = dark() ? night : [1, 1, 1];
  if (terrain || drawing === meshes) drawMesh(ground, identity, tint, dark() ? 0.5 : 0.22, contour);
  if (unknown && drawing === meshes) drawMesh(unknown, identity, tint);
}

function drawSolids() {
  if (solids) drawMesh(solids, identity, dark() ? [0.75, 0.78, 0.82] : [1, 1, 1]);
}

// Obstacles that come, go and move; they rise out of the ground when they appear.
const movers = (run ? run.movers : []).map((said) => {
  const { prism, made } = faces();
  prism({ ...said, ring: points(said.ring) }, MOVER);
  return { ...said, end: said.end ?? Infinity, mesh: made() };
});

function drawMovers(time) {
  for (const { mesh: shape, low, start, end: stop, time: times, x, y } of movers) {
    if (time < start || time >= stop) continue;
    const grown = start <= begin ? 1 : clamp((time - start) / 0.4, 0.1, 1);
    drawMesh(shape, boxed([1, 0, 0], [0, 1, 0], [0, 0, grown], [along(times, x, time), along(times, y, time), low * (1 - grown)]), dark() ? [0.85, 0.85, 0.85] : [1, 1, 1]);
  }
}

// What is fixed again after all else, so that what is behind it shows through where it is in the way.
function drawGhosts(aim, slope) {
  if (!solids) return;
  drawWith(meshes, { aim: [...aim, slope] });
  gl.enable(gl.CULL_FACE);
  drawSolids();
  gl.disable(gl.CULL_FACE);
  setUniforms(meshes, { aim: [0, 0, 0, 0] });
}
