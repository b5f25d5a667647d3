// WebGL: one program for lit meshes, one for thick lines, one for dots.
const canvas = document.getElementById("view");
const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
if (!gl) {
  document.getElementById("trouble").hidden = false;
  throw new Error("no WebGL");
}
const fine = gl.getExtension("OES_standard_derivatives");

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
  const at = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const { name } = gl.getActiveUniform(made, k);
    at[name] = gl.getUniformLocation(made, name);
  }
  const inputs = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_ATTRIBUTES); k++) {
    const { name } = gl.getActiveAttrib(made, k);
    inputs[name] = gl.getAttribLocation(made, name);
  }
  return { made, at, inputs };
}

const meshes = program(`
attribute vec3 place, normal, colour;
uniform mat4 view, model;
uniform vec3 tint;
varying vec3 n, c, w;
void main() {
  vec4 at = model * vec4(place, 1.0);
  // Boxes only: their axes are orthogonal, so the inverse's transpose is the axes over their squares.
  vec3 a = model[0].xyz, b = model[1].xyz, d = model[2].xyz;
  n = a * normal.x / dot(a, a) + b * normal.y / dot(b, b) + d * normal.z / dot(d, d);
  c = colour * tint;
  w = at.xyz;
  gl_Position = view * at;
}`, `
${fine ? "#extension GL_OES_standard_derivatives : enable" : ""}
precision highp float;
varying vec3 n, c, w;
uniform vec3 eye;
uniform float lines, contour;
float line(float v) {
  ${fine ? "float d = fwidth(v); return d > 0.5 || d < 1e-5 ? 0.0 : 1.0 - smoothstep(0.0, 1.2 * d, abs(fract(v - 0.5) - 0.5));" : "return 0.0;"}
}
void main() {
  vec3 m = normalize(n);
  float lit = 0.62 + 0.42 * max(dot(m, normalize(vec3(-0.45, 0.5, 0.75))), 0.0) + 0.10 * m.z;
  vec3 shade = c * lit;
  if (lines > 0.0) {
    float far = length(eye - w);
    float g = max(line(w.x), line(w.y)) * lines * clamp(1.0 - far / 70.0, 0.0, 1.0);
    if (contour > 0.0) g = max(g * 0.5, line(w.z / contour + 0.5) * 0.30);
    shade = mix(shade, shade * 0.45, g);
  }
  gl_FragColor = vec4(shade, 1.0);
}`);

// Each piece of a line is a quad, widened on the screen; `when` is the time of its end.
const strokes = program(`
attribute vec3 place, other, colour;
attribute vec2 side;
attribute float when;
uniform mat4 view;
uniform vec2 screen;
uniform float width;
varying vec4 c;
varying float t;
void main() {
  vec4 a = view * vec4(place, 1.0), b = view * vec4(other, 1.0);
  vec2 along = (b.xy / max(b.w, 1e-4) - a.xy / max(a.w, 1e-4)) * screen * side.y;
  float size = length(along);
  vec2 across = size > 1e-6 ? vec2(-along.y, along.x) / size : vec2(0.0);
  a.xy += (across * side.x * width + (size > 1e-6 ? -along / size * side.y * 0.3 * width : vec2(0.0))) / screen * a.w;
  a.z -= 0.0006 * a.w;
  c = vec4(colour, 1.0);
  t = when;
  gl_Position = a;
}`, `
precision mediump float;
varying vec4 c;
varying float t;
uniform float now, faint;
void main() { gl_FragColor = vec4(c.rgb, t <= now ? 1.0 : faint); }`);

const dots = program(`
attribute vec3 place, colour;
attribute float when;
uniform mat4 view;
uniform float now, size;
varying vec4 c;
void main() {
  gl_Position = view * vec4(place, 1.0);
  gl_Position.z -= 0.0004 * gl_Position.w;
  gl_PointSize = when <= now ? clamp(size / gl_Position.w, 1.5, 9.0) : 0.0;
  if (when > now) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  c = vec4(colour, 0.9);
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

function feed(shader, parts) {
  for (const [name, [made, size]] of Object.entries(parts)) {
    const place = shader.inputs[name];
    if (place === undefined) continue;
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
  }
}

// A mesh of triangles; `index` may be left out.
function mesh(place, normal, colour, index) {
  const made = { parts: { place: [buffer(place), 3], normal: [buffer(normal), 3], colour: [buffer(colour), 3] }, count: place.length / 3 };
  if (index) {
    made.index = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, made.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(index), gl.STATIC_DRAW);
    made.count = index.length;
  }
  return made;
}

let fed = null;
function drawMesh(what, model, tint, lines = 0, contour = 0) {
  if (fed !== what) { feed(meshes, what.parts); fed = what; }
  gl.uniformMatrix4fv(meshes.at.model, false, model);
  gl.uniform3fv(meshes.at.tint, tint);
  gl.uniform1f(meshes.at.lines, lines);
  gl.uniform1f(meshes.at.contour, contour);
  if (what.index) {
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, what.index);
    gl.drawElements(gl.TRIANGLES, what.count, gl.UNSIGNED_SHORT, 0);
  } else gl.drawArrays(gl.TRIANGLES, 0, what.count);
}
