// Meshes of simple bodies.
const cube = (() => {
  const p = [], n = [], c = [];
  for (let axis = 0; axis < 3; axis++)
    for (const sign of [-1, 1]) {
      const u = (axis + 1) % 3, v = (axis + 2) % 3;
      const corner = (a, b) => { const at = [0, 0, 0]; at[axis] = sign; at[u] = a; at[v] = b; return at; };
      const order = sign > 0 ? [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]] : [[-1, -1], [1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]];
      for (const [a, b] of order) { const normal = [0, 0, 0]; normal[axis] = sign; p.push(...corner(a, b)); n.push(...normal); c.push(1, 1, 1); }
    }
  return mesh(p, n, c);
})();

const disc = (() => {
  const p = [], n = [], c = [], count = 32;
  for (let k = 0; k < count; k++) {
    const [a, b] = [k, k + 1].map((i) => [Math.cos(2 * Math.PI * i / count), Math.sin(2 * Math.PI * i / count)]);
    for (const at of [[0, 0, 1], [...a, 1], [...b, 1]]) { p.push(...at); n.push(0, 0, 1); c.push(1, 1, 1); }
    for (const [at, z] of [[a, -1], [b, -1], [b, 1], [a, -1], [b, 1], [a, 1]]) { p.push(...at, z); n.push(...at, 0); c.push(1, 1, 1); }
  }
  return mesh(p, n, c);
})();

const scaled = (v, f) => [v[0] * f, v[1] * f, v[2] * f];

function limb(a, b, thick, paint, across) {
  const along = sub(b, a), y = unit(across), z = unit(cross(along, y));
  drawMesh(cube, boxed(scaled(along, 0.5), scaled(y, thick), scaled(z, thick), add(a, along, 0.5)), paint);
}

