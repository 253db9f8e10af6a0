// Draws the body with WebGL2: smooth shading from the deformed shape, a colour ramp, edges, supports, the shape at rest.
import { round125 } from "vademecum/body";
import { ramp } from "vademecum/colors";

const VERTEX = `#version 300 es
precision highp float;
uniform mat4 view;
uniform float magnification;
uniform highp int component;
uniform float scale;
uniform float point_size;
uniform bool dots;
uniform vec4 ball;
uniform highp int floor_axis;
uniform float floor_at;
in vec3 rest;
in vec3 displacement;
in vec3 field;
in vec3 normal;
in float loadable;
out vec3 n;
out float value;
out float bright;
void main() {
  vec3 at = ball.w > 0.0 ? ball.xyz + ball.w * rest : rest + magnification * displacement;
  if (floor_axis == 0) at.x = floor_at;
  if (floor_axis == 1) at.y = floor_at;
  if (floor_axis == 2) at.z = floor_at;
  gl_Position = view * vec4(at, 1.0);
  gl_PointSize = point_size;
  // Dots lie on the surface: a little nearer, so that it does not cut them.
  if (dots) gl_Position.z -= 2e-4 * gl_Position.w;
  n = ball.w > 0.0 ? rest : normal;
  bright = loadable;
  value = component < 0 ? length(field) / scale
    : 0.5 + 0.5 * field[component] / scale;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D ramp;
uniform vec4 flat_color;
uniform vec3 eye, above;
uniform float stripe;
uniform bool dots;
uniform vec4 ball;
uniform vec3 ball_color;
uniform highp int component;
in vec3 n;
in float value;
in float bright;
out vec4 color;
void main() {
  if (dots && length(gl_PointCoord - 0.5) > 0.5) discard;
  if (flat_color.a > 0.0) { color = vec4(flat_color.rgb * flat_color.a, flat_color.a); return; }
  vec3 unit = normalize(n);
  if (!gl_FrontFacing) unit = -unit;
  float key = max(dot(unit, normalize(eye + 0.9 * above)), 0.0);
  float light = 0.66 + 0.16 * dot(unit, above) + 0.26 * key;
  float shine = 0.14 * pow(key, 24.0);
  vec3 base = texture(ramp, vec2(clamp(value, 0.0, 1.0) * 0.996 + 0.002, 0.5)).rgb;
  // What cannot be pushed: paler, and striped.
  float line = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / stripe));
  base = mix(mix(base, vec3(0.5 + 0.18 * line), 0.5), base, bright);
  if (component == -2 && bright < 0.5) base = vec3(0.6);
  // What is rigid.
  if (bright < 0.0) base = vec3(0.62, 0.64, 0.67);
  if (ball.w > 0.0) base = ball_color;
  color = vec4(base * light + shine, 1.0);
}`;

/** Colours of edges on the body, and of supports and the shape at rest on the background, in dark and in light. */
const INK = { dark: [0.02, 0.04, 0.08, 0.4], light: [0.03, 0.06, 0.12, 0.28] };
const SUPPORT = { dark: [0.62, 0.66, 0.75, 1], light: [0.33, 0.37, 0.46, 1] };
/** The ground's lines, and the shadow on it. */
const GROUND = { dark: [0.62, 0.66, 0.75, 0.18], light: [0.33, 0.37, 0.46, 0.16] };
const SHADOW = { dark: [0, 0, 0, 0.4], light: [0.1, 0.13, 0.2, 0.13] };
/** The sphere that presses. */
const BALL = { dark: [0.72, 0.75, 0.8], light: [0.6, 0.64, 0.7] };

export class Renderer {
  /** Throws if the browser has no WebGL2. */
  constructor(canvas, body) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: false });
    if (!gl) throw new Error("this browser does not offer WebGL2");
    Object.assign(this, { canvas, gl, body, ghost: false, ground: true, grid: null, finer: null });
    // Edges and supports help where they are few; of a fine mesh they would hide the body.
    this.wire = body.edges.length < 6000;
    this.supports = body.held.length < 150;
    this.dot = body.held.length < 50 ? 5 : 3;
    this.program = link(gl);
    const uniforms = ["view", "magnification", "component", "scale", "point_size", "ramp", "flat_color", "eye", "above", "stripe", "dots", "ball", "ball_color", "floor_axis", "floor_at"];
    this.at = Object.fromEntries(uniforms.map((name) => [name, gl.getUniformLocation(this.program, name)]));
    const vertices = body.vertexNode.length;
    this.arrays = { displacement: new Float32Array(3 * vertices), field: new Float32Array(3 * vertices) };
    this.normals = new Float32Array(3 * vertices);
    this.spread = [0, 1].map(() => new Float64Array(body.skin.rest.length));
    const rest = Float32Array.from({ length: 3 * vertices }, (_, i) => body.skin.rest[3 * body.vertexNode[(i / 3) | 0] + (i % 3)]);
    this.vao = gl.createVertexArray();
    gl.bindVertexArray(this.vao);
    this.buffers = {
      rest: this.attribute("rest", 3, rest, gl.STATIC_DRAW), loadable: this.attribute("loadable", 1, body.vertexLoadable, gl.STATIC_DRAW),
      displacement: this.attribute("displacement", 3, this.arrays.displacement, gl.DYNAMIC_DRAW),
      field: this.attribute("field", 3, this.arrays.field, gl.DYNAMIC_DRAW), normal: this.attribute("normal", 3, this.normals, gl.DYNAMIC_DRAW),
    };
    this.sphere = this.ball();
    gl.bindVertexArray(this.vao);
    const vertexOf = new Map();
    body.vertexNode.forEach((node, vertex) => vertexOf.set(node, vertex));
    this.faces = this.indices(body.vertexCorners);
    this.lines = this.indices(body.edges.map((node) => vertexOf.get(node)));
    // A vertex of an embedded surface is held with the facet below it.
    const heldNodes = new Set(body.held);
    const isHeld = (vertex) => Array.from(body.skin.nodesOf(vertex)).filter((node) => heldNodes.has(node)).length >= (body.skin.embedded ? 3 : 1);
    this.points = this.indices(Uint32Array.from([...vertexOf.keys()].filter(isHeld), (vertex) => vertexOf.get(vertex)));
    this.ramps = [false, true].map((signed) => this.texture(ramp(signed)));
  }

  /** A sphere of radius 1, with an array object of its own. */
  ball() {
    const [rings, around] = [24, 48];
    const places = [], corners = [];
    for (let i = 0; i <= rings; i++) {
      for (let j = 0; j <= around; j++) {
        const [polar, turn] = [(Math.PI * i) / rings, (2 * Math.PI * j) / around];
        places.push(Math.sin(polar) * Math.cos(turn), Math.sin(polar) * Math.sin(turn), Math.cos(polar));
        const at = i * (around + 1) + j;
        if (i < rings && j < around) corners.push(at, at + around + 1, at + 1, at + 1, at + around + 1, at + around + 2);
      }
    }
    const vao = this.gl.createVertexArray();
    this.gl.bindVertexArray(vao);
    this.attribute("rest", 3, Float32Array.from(places), this.gl.STATIC_DRAW);
    return { vao, corners: this.indices(Uint32Array.from(corners)) };
  }

  /** Lines on the ground under the body at rest, a little below it; anew when another axis points upwards. */
  lay(up) {
    const { box, size } = this.body;
    const [a, b] = [(up + 1) % 3, (up + 2) % 3];
    const at = box.low[up] - 0.02 * size;
    const step = round125(size / 4);
    const half = 6;
    const places = [];
    const middle = [a, b].map((axis) => step * Math.round((box.low[axis] + box.high[axis]) / 2 / step));
    for (let i = -half; i <= half; i++) {
      for (const [across, along, c, d] of [[a, b, 0, 1], [b, a, 1, 0]]) {
        for (const end of [-half, half]) {
          const place = [0, 0, 0];
          [place[up], place[across], place[along]] = [at, middle[c] + step * i, middle[d] + step * end];
          places.push(...place);
        }
      }
    }
    const vao = this.gl.createVertexArray();
    this.gl.bindVertexArray(vao);
    this.attribute("rest", 3, Float32Array.from(places), this.gl.STATIC_DRAW);
    return { vao, up, at, lines: this.indices(Uint32Array.from({ length: places.length / 3 }, (_, i) => i)) };
  }

  /** The ground and the shadow of the body on it, each place once however many triangles are over it. */
  under(camera, theme, magnification) {
    const { gl, at } = this;
    if (this.grid?.up !== camera.up) this.grid = this.lay(camera.up);
    // Behind the body, whatever is drawn later.
    gl.disable(gl.DEPTH_TEST);
    gl.uniform1f(at.magnification, 0);
    gl.bindVertexArray(this.grid.vao);
    this.elements(gl.LINES, this.grid.lines, GROUND[theme]);
    gl.bindVertexArray(this.vao);
    gl.uniform1f(at.magnification, magnification);
    gl.uniform1i(at.floor_axis, camera.up);
    gl.uniform1f(at.floor_at, this.grid.at);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilFunc(gl.EQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    this.elements(gl.TRIANGLES, this.faces, SHADOW[theme]);
    gl.disable(gl.STENCIL_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.uniform1i(at.floor_axis, -1);
  }

  attribute(name, size, data, usage) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    const place = gl.getAttribLocation(this.program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, usage);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    return buffer;
  }

  indices(data) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return { buffer, count: data.length };
  }

  texture(colors) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /** Copies surface fields (per node) to the vertices and sums the normals of the drawn shape. */
  fill(displacement, field) {
    const { vertexNode, vertexCorners, skin } = this.body;
    const { displacement: u, field: f } = this.arrays;
    [displacement, field] = [skin.at(displacement, this.spread[0]), skin.at(field, this.spread[1])];
    for (let v = 0; v < vertexNode.length; v++) {
      const node = 3 * vertexNode[v];
      for (let c = 0; c < 3; c++) {
        u[3 * v + c] = displacement[node + c];
        f[3 * v + c] = field[node + c];
      }
    }
    sumNormals(skin.displaced, skin.triangles, vertexCorners, this.normals);
    const { gl, buffers } = this;
    for (const [name, data] of [["displacement", u], ["field", f], ["normal", this.normals]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
    }
  }

  /** Fits the canvas to its place on the page; its size in CSS pixels. */
  resize() {
    const { canvas, gl } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    // No browser has larger canvases everywhere.
    const ratio = Math.min(this.finer ?? Math.min(window.devicePixelRatio || 1, 2), 8000 / Math.max(width, height, 1));
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    this.ratio = ratio;
    return [Math.max(width, 1), Math.max(height, 1)];
  }

  /** One frame. `component` −1 for the size of the field, else 0 to 2. */
  draw(camera, { magnification, component, scale, dark, tool }) {
    const { gl, at } = this;
    const theme = dark ? "dark" : "light";
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    gl.bindVertexArray(this.vao);
    gl.uniformMatrix4fv(at.view, false, camera.matrix);
    gl.uniform1f(at.magnification, magnification);
    gl.uniform1i(at.component, component);
    gl.uniform1f(at.scale, scale);
    gl.uniform1f(at.point_size, this.dot * this.ratio);
    gl.uniform3fv(at.eye, camera.view.back);
    gl.uniform3fv(at.above, [0, 1, 2].map((axis) => (axis === camera.up ? 1 : 0)));
    gl.uniform1f(at.stripe, 9 * this.ratio);
    gl.uniform4fv(at.ball, [0, 0, 0, 0]);
    gl.uniform1i(at.floor_axis, -1);
    if (this.ground) this.under(camera, theme, magnification);
    gl.bindTexture(gl.TEXTURE_2D, this.ramps[component < 0 ? 0 : 1]);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    this.elements(gl.TRIANGLES, this.faces, [0, 0, 0, 0]);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (this.wire) this.elements(gl.LINES, this.lines, INK[theme]);
    if (this.supports) this.elements(gl.POINTS, this.points, SUPPORT[theme]);
    if (this.ghost) {
      gl.uniform1f(at.magnification, 0);
      this.elements(gl.LINES, this.lines, SUPPORT[theme].map((x, i) => (i === 3 ? 0.35 : x)));
    }
    if (tool) {
      gl.bindVertexArray(this.sphere.vao);
      gl.uniform4fv(at.ball, [...tool.centre, tool.radius]);
      gl.uniform3fv(at.ball_color, BALL[theme]);
      this.elements(gl.TRIANGLES, this.sphere.corners, [0, 0, 0, 0]);
    }
  }

  elements(kind, { buffer, count }, color) {
    const { gl } = this;
    gl.uniform4fv(this.at.flat_color, color);
    gl.uniform1i(this.at.dots, kind === gl.POINTS ? 1 : 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.drawElements(kind, count, gl.UNSIGNED_INT, 0);
  }
}

function sumNormals(positions, triangles, corners, normals) {
  normals.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const length = Math.hypot(x, y, z) || 1;
    for (let k = 0; k < 3; k++) {
      const v = 3 * corners[t + k];
      normals[v] += x / length;
      normals[v + 1] += y / length;
      normals[v + 2] += z / length;
    }
  }
}

function link(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}
