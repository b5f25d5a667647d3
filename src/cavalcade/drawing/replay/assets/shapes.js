// Meshes of simple bodies.
function limb(a, b, thick, paint, across) {
  const along = sub(b, a), y = unit(across), z = unit(cross(along, y));
  drawMesh(cube, boxed(scaled(along, 0.5), scaled(y, thick), scaled(z, thick), add(a, along, 0.5)), paint);
}

// Triangles of a body of revolution about z: the profile's points are [radius, z, outwards, up],
// the last two its normal.
function lathe(profile, count = 20) {
  const out = [], ring = Array.from({ length: count + 1 }, (_, k) => [Math.cos(2 * Math.PI * k / count), Math.sin(2 * Math.PI * k / count)]);
  const corner = ([r, z, u, v], [c, s]) => [[r * c, r * s, z], [u * c, u * s, v]];
  for (let i = 0; i + 1 < profile.length; i++)
    for (let k = 0; k < count; k++) {
      const [a, b] = [profile[i], profile[i + 1]], p = corner(a, ring[k]), q = corner(a, ring[k + 1]), r = corner(b, ring[k + 1]), t = corner(b, ring[k]);
      if (a[0] > 0) out.push(p, q, r);
      if (b[0] > 0) out.push(p, r, t);
    }
  return out;
}

const quarter = (n, from) => Array.from({ length: n + 1 }, (_, k) => { const a = from + k / n * Math.PI / 2; return [Math.cos(a), Math.sin(a)]; });

// Half length without the caps; both caps are half balls.
function capsuleFaces(radius, half) {
  const low = quarter(5, -Math.PI / 2), high = quarter(5, 0);
  return lathe([...low.map(([c, s]) => [radius * c, radius * s - half, c, s]), ...high.map(([c, s]) => [radius * c, radius * s + half, c, s])]);
}

// With its edges rounded off a little.
function cylinderFaces(radius, half, count = 24) {
  const b = Math.min(0.18 * radius, 0.3 * half), low = quarter(3, -Math.PI / 2), high = quarter(3, 0);
  return lathe([
    [0, -half, 0, -1], [radius - b, -half, 0, -1],
    ...low.map(([c, s]) => [radius - b + b * c, b - half + b * s, c, s]),
    ...high.map(([c, s]) => [radius - b + b * c, half - b + b * s, c, s]),
    [radius - b, half, 0, 1], [0, half, 0, 1],
  ], count);
}

// A box with edges rounded off by r, half lengths as given.
function boxFaces(size, r = 0.3 * Math.min(...size)) {
  const inner = size.map((v) => v - r), out = [], nodes = r ? [[-1, -1], [-1, -0.5], [-1, 0], [1, 0], [1, 0.5], [1, 1]] : [[-1, 0], [1, 0]];
  for (let axis = 0; axis < 3; axis++)
    for (const sign of [-1, 1]) {
      const u = (axis + 1) % 3, v = (axis + 2) % 3;
      const corner = ([a, s], [b, t]) => {
        const n = [0, 0, 0], p = [0, 0, 0];
        n[axis] = sign; n[u] = Math.tan(Math.PI / 4 * s); n[v] = Math.tan(Math.PI / 4 * t);
        const m = unit(n);
        p[axis] = sign * inner[axis]; p[u] = a * inner[u]; p[v] = b * inner[v];
        return [add(p, m, r), m];
      };
      for (let i = 0; i + 1 < nodes.length; i++)
        for (let j = 0; j + 1 < nodes.length; j++) {
          const p = corner(nodes[i], nodes[j]), q = corner(nodes[i + 1], nodes[j]), s = corner(nodes[i + 1], nodes[j + 1]), t = corner(nodes[i], nodes[j + 1]);
          out.push(...(sign > 0 ? [p, q, s, p, s, t] : [p, s, q, p, t, s]));
        }
    }
  return out;
}

const FACES = {
  box: (size) => boxFaces(size),
  sphere: ([radius]) => capsuleFaces(radius, 0),
  capsule: ([radius, half]) => capsuleFaces(radius, half),
  cylinder: ([radius, half]) => cylinderFaces(radius, half),
};

const whole = (faces) => mesh(faces.flatMap(([p]) => p), faces.flatMap(([, n]) => n), faces.flatMap(() => [1, 1, 1]));
const cube = whole(boxFaces([1, 1, 1], 0)), ball = whole(capsuleFaces(1, 0));
const shaft = whole(lathe([[1, 0, 1, 0], [1, 1, 1, 0]], 12)), tip = whole(lathe([[0, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0.9, 0.4], [0, 1, 0.9, 0.4]], 16));
const disc = whole(lathe([[0, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]], 32));
