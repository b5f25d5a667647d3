// WebGL: lit meshes with the sun's shadows, thick lines, dots.
const canvas = document.getElementById("view");
const gl = canvas.getContext("webgl", { alpha: false, antialias: true, preserveDrawingBuffer: true });
if (!gl) {
  document.getElementById("trouble").hidden = false;
  document.body.classList.add("plain");
  throw new Error("no WebGL");
}
const fine = gl.getExtension("OES_standard_derivatives");
const long = gl.getExtension("OES_element_index_uint");

function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const places = (kind, count) => Object.fromEntries(Array.from({ length: gl.getProgramParameter(made, count) }, (_, k) => {
    const { name } = gl[`getActive${kind}`](made, k);
    return [name, gl[`get${kind}Location`](made, name)];
  }));
  return { made, at: places("Uniform", gl.ACTIVE_UNIFORMS), inputs: places("Attrib", gl.ACTIVE_ATTRIBUTES) };
}

// Gives a program in use its uniforms: numbers, vectors and matrices.
function setUniforms({ at }, values) {
  for (const [name, value] of Object.entries(values)) {
    if (typeof value === "number") gl.uniform1f(at[name], value);
    else if (value.length === 16) gl.uniformMatrix4fv(at[name], false, value);
    else gl[`uniform${value.length}fv`](at[name], value);
  }
}

const meshes = program(`
attribute vec3 place, normal, colour;
uniform mat4 view, model, sun;
uniform vec3 tint;
uniform float texel;
varying vec3 n, c, w, s;
void main() {
  vec4 at = model * vec4(place, 1.0);
  // Models have orthogonal axes, so the inverse's transpose is the axes over their squares.
  vec3 a = model[0].xyz, b = model[1].xyz, d = model[2].xyz;
  n = a * normal.x / dot(a, a) + b * normal.y / dot(b, b) + d * normal.z / dot(d, d);
  c = colour * tint;
  w = at.xyz;
  s = (sun * vec4(w + 0.7 * texel * normalize(n), 1.0)).xyz * 0.5 + 0.5;
  gl_Position = view * at;
}`, `
${fine ? "#extension GL_OES_standard_derivatives : enable" : ""}
precision highp float;
varying vec3 n, c, w, s;
uniform vec3 eye, sunward;
uniform vec4 aim;
uniform float lines, contour, gloss, bias;
uniform sampler2D shade;
float line(float v) {
  ${fine ? "float d = fwidth(v); return d > 0.5 || d < 1e-5 ? 0.0 : 1.0 - smoothstep(0.0, 1.2 * d, abs(fract(v - 0.5) - 0.5));" : "return 0.0;"}
}
float nearest(vec2 at) { return dot(texture2D(shade, at), vec4(1.0, 1.0 / 255.0, 1.0 / 65025.0, 1.0 / 16581375.0)); }
float sunlit(float high) {
  if (min(s.x, s.y) < 0.0 || max(max(s.x, s.y), s.z) > 1.0) return 1.0;
  float sum = 0.0, slack = bias * (1.0 + min(sqrt(1.0 - high * high) / high, 7.0));
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++) sum += step(s.z - slack, nearest(s.xy + vec2(float(i), float(j)) / 2048.0));
  return sum / 9.0;
}
void main() {
  vec3 m = normalize(n), ray = normalize(eye - w);
  float high = dot(m, sunward), sun = high > 0.0 ? high * sunlit(high) : 0.0;
  vec3 shade = c * (vec3(0.53, 0.54, 0.56) + vec3(0.50, 0.49, 0.465) * sun + 0.08 * m.z);
  if (gloss > 0.0) shade += gloss * (pow(max(dot(m, normalize(sunward + ray)), 0.0), 36.0) * sun + 0.25 * pow(1.0 - max(dot(m, ray), 0.0), 4.0));
  if (lines > 0.0) {
    float far = length(eye - w);
    float g = max(line(w.x), line(w.y)) * lines * clamp(1.0 - far / 70.0, 0.0, 1.0);
    g = max(g, max(line(4.0 * w.x), line(4.0 * w.y)) * lines * 0.35 * clamp(1.0 - far / 7.0, 0.0, 1.0));
    if (contour > 0.0) g = max(g * 0.5, line(w.z / contour + 0.5) * 0.30);
    shade = mix(shade, shade * 0.45, g);
  }
  // What stands between the eye and its aim is seen through, in a cone of the slope aim.w.
  float seen = 1.0;
  if (aim.w > 0.0) {
    vec3 way = aim.xyz - eye;
    float far = length(way), near = dot(w - eye, way) / far, off = length(w - eye - near / far * way);
    seen = max(mix(0.2, 1.0, smoothstep(0.7, 1.0, off / (aim.w * near))), smoothstep(far - 0.7, far - 0.3, near));
  }
  gl_FragColor = vec4(shade, seen);
}`);

// Seen from the sun: how far away is what it meets first.
const depths = program(`
attribute vec3 place;
uniform mat4 view, model;
void main() { gl_Position = view * model * vec4(place, 1.0); }`, `
precision highp float;
void main() {
  vec4 parts = fract(gl_FragCoord.z * vec4(1.0, 255.0, 65025.0, 16581375.0));
  gl_FragColor = parts - parts.yzww * vec4(vec3(1.0 / 255.0), 0.0);
}`);

const shadow = (() => {
  const size = 2048, image = gl.createTexture(), depth = gl.createRenderbuffer(), frame = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, image);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, size, size, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
  for (const which of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, which, gl.NEAREST);
  for (const which of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, which, gl.CLAMP_TO_EDGE);
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, size, size);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, image, 0);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return { size, image, frame, sunward: unit([-0.45, 0.5, 0.85]) };
})();

// The sun's view of what is around a place; it moves in whole texels, so that edges do not crawl.
function sunMatrix(middle, radius) {
  const z = shadow.sunward, x = unit(cross([0, 0, 1], z)), y = cross(z, x), texel = 2 * radius / shadow.size;
  const u = Math.round(dot(x, middle) / texel) * texel, v = Math.round(dot(y, middle) / texel) * texel, f = 1 / radius;
  const g = 1 / (1.6 * radius + 3), matrix = new Float32Array([x[0] * f, y[0] * f, -z[0] * g, 0, x[1] * f, y[1] * f, -z[1] * g, 0, x[2] * f, y[2] * f, -z[2] * g, 0, -u * f, -v * f, dot(z, middle) * g, 1]);
  return { matrix, texel, bias: 0.5 * texel * g };
}

// Everything solid: once as the sun sees it, once as the eye does.
let fed = null, drawing = meshes;
function drawWith(shader, values) {
  drawing = shader;
  fed = null;
  gl.useProgram(shader.made);
  setUniforms(shader, values);
}

function clearFrame(frame, width, height, colour) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.viewport(0, 0, width, height);
  gl.clearColor(...colour, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
}

function renderSolid(view, eye, middle, radius, sky, drawThem) {
  const { matrix: sun, texel, bias } = sunMatrix(middle, radius);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
  clearFrame(shadow.frame, shadow.size, shadow.size, [1, 1, 1]);
  drawWith(depths, { view: sun });
  drawThem();
  clearFrame(null, canvas.width, canvas.height, sky);
  drawWith(meshes, { view, sun, texel, bias, eye, sunward: shadow.sunward });
  gl.bindTexture(gl.TEXTURE_2D, shadow.image);
  drawThem();
}

// Each piece of a line is a quad, widened on the screen; `when` is the time of its end: before
// `since` it is not seen, until `now` with its `strength`, and `faint` after that.
const strokes = program(`
attribute vec3 place, other, colour;
attribute vec2 side;
attribute float when;
uniform mat4 view;
uniform vec2 screen;
uniform float width;
uniform vec3 tint;
varying vec4 c;
varying float t;
void main() {
  vec4 a = view * vec4(place, 1.0), b = view * vec4(other, 1.0);
  vec2 along = (b.xy / max(b.w, 1e-4) - a.xy / max(a.w, 1e-4)) * screen * side.y;
  float size = length(along);
  vec2 across = size > 1e-6 ? vec2(-along.y, along.x) / size : vec2(0.0);
  a.xy += (across * side.x * width + (size > 1e-6 ? -along / size * side.y * 0.3 * width : vec2(0.0))) / screen * a.w;
  a.z -= 0.0006 * a.w;
  c = vec4(colour * tint, 1.0);
  t = when;
  gl_Position = a;
}`, `
precision highp float;
varying vec4 c;
varying float t;
uniform float now, since, faint, strength;
void main() {
  float seen = t < since ? 0.0 : t <= now ? strength : faint;
  if (seen <= 0.0) discard;
  gl_FragColor = vec4(c.rgb, seen);
}`);

const dots = program(`
attribute vec3 place;
attribute float when;
uniform mat4 view;
uniform vec3 tint;
uniform float now, since, size;
varying vec4 c;
void main() {
  gl_Position = view * vec4(place, 1.0);
  gl_Position.z -= 0.0004 * gl_Position.w;
  gl_PointSize = when <= now ? clamp(size / gl_Position.w, 1.5, 11.0) : 0.0;
  if (when > now || when < since) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  c = vec4(tint, since > 0.0 ? 0.9 * min(2.0 * (when - since) / (now - since), 1.0) : 0.9);
}`, `
precision mediump float;
varying vec4 c;
void main() {
  if (length(gl_PointCoord - 0.5) > 0.5) discard;
  gl_FragColor = c;
}`);

function buffer(values) {
  const made = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  gl.bufferData(gl.ARRAY_BUFFER, values instanceof Float32Array ? values : new Float32Array(values), gl.STATIC_DRAW);
  return made;
}

// How many numbers a corner has of each input.
const SIZES = { place: 3, other: 3, normal: 3, colour: 3, side: 2, when: 1 };
const buffers = (rows) => Object.fromEntries(Object.entries(rows).map(([name, values]) => [name, buffer(values)]));

function feed(shader, parts) {
  for (const [name, made] of Object.entries(parts)) {
    const place = shader.inputs[name];
    if (place === undefined) continue;
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, SIZES[name], gl.FLOAT, false, 0, 0);
  }
}

// A mesh of triangles; `index` may be left out.
function mesh(place, normal, colour, index) {
  const made = { parts: buffers({ place, normal, colour }), count: place.length / 3 };
  if (index) {
    made.index = gl.createBuffer();
    made.type = place.length / 3 > 65535 && long ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, made.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, made.type === gl.UNSIGNED_INT ? new Uint32Array(index) : new Uint16Array(index), gl.STATIC_DRAW);
    made.count = index.length;
  }
  return made;
}

function drawMesh(what, model, tint, lines = 0, contour = 0, gloss = 0) {
  if (fed !== what) { feed(drawing, what.parts); fed = what; }
  gl.uniformMatrix4fv(drawing.at.model, false, model);
  if (drawing === meshes) setUniforms(meshes, { tint, lines, contour, gloss });
  if (what.index) {
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, what.index);
    gl.drawElements(gl.TRIANGLES, what.count, what.type, 0);
  } else gl.drawArrays(gl.TRIANGLES, 0, what.count);
}
