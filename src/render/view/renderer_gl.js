// The WebGL 2 renderer: lit bones, a ground with a grid, and soft shadows. It draws three shapes with instancing.

import { INSTANCE } from "./batch.js";
import { SkinRenderer } from "./renderer_skin.js";

const BONE_SHADER = `#version 300 es
in vec3 shape; in vec3 start; in vec3 end; in float width; in vec3 color;
uniform mat4 worldToClip; uniform float isBall, swell;
out vec3 place; out vec3 tint; out vec3 round;
void main() {
  vec3 way = end - start;
  float size = length(way);
  vec3 x = size > 0.0 ? way / size : vec3(0, 1, 0);
  vec3 z = normalize(cross(x, abs(x.y) < 0.99 ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  vec3 y = cross(z, x);
  place = isBall > 0.5 ? start + shape * width : start + x * shape.x * size + (y * shape.y + z * shape.z) * width * swell;
  round = isBall > 0.5 ? shape : vec3(0);
  tint = color;
  gl_Position = worldToClip * vec4(place, 1);
}`;

// Faces are flat: their normal comes from neighbouring pixels. Spheres have exact normals.
const LIGHT_SHADER = `#version 300 es
precision highp float;
in vec3 place; in vec3 tint; in vec3 round;
uniform vec3 eye; uniform vec3 sun;
out vec4 pixel;
void main() {
  vec3 normal = dot(round, round) > 0.0 ? normalize(round) : normalize(cross(dFdx(place), dFdy(place)));
  vec3 view = normalize(eye - place);
  if (dot(normal, view) < 0.0) normal = -normal;
  float light = 0.66 + 0.14 * normal.y + 0.42 * max(0.0, dot(normal, sun));
  float gloss = pow(max(0.0, dot(normal, normalize(sun + view))), 40.0);
  pixel = vec4(pow(tint * light + 0.14 * gloss, vec3(0.95)), 1);
}`;

// Higher parts cast a weaker shadow.
const SHADOW_SHADER = `#version 300 es
precision highp float;
in vec3 place; in vec3 tint; in vec3 round;
uniform float ground; uniform float reach;
out vec4 pixel;
void main() { pixel = vec4(1.0 / (1.0 + 1.6 * max(0.0, place.y - ground) / reach)); }`;

const GROUND_SHADER = `#version 300 es
in vec2 corner;
uniform mat4 worldToClip; uniform vec3 middle; uniform float extent;
out vec2 place;
void main() {
  place = middle.xz + corner * extent;
  gl_Position = worldToClip * vec4(place.x, middle.y, place.y, 1);
}`;

// The sample positions of soft shadows, in a disc of radius 1.
const TAPS = Array.from({ length: 24 }, (_, i) => {
  const [turn, away] = [i * 2.39996, Math.sqrt((i + 0.5) / 24)];
  return `vec2(${(Math.cos(turn) * away).toFixed(6)}, ${(Math.sin(turn) * away).toFixed(6)})`;
});

const GRID_SHADER = `#version 300 es
precision highp float;
in vec2 place;
uniform vec3 middle, background, lineColor; uniform float extent, squares, softness, darkness;
uniform vec4 shadowArea; uniform sampler2D shadow;
out vec4 pixel;
const vec2 TAPS[24] = vec2[24](${TAPS.join(", ")});
float lines(float unit) {
  vec2 at = place / unit, pace = fwidth(at);
  vec2 near = abs(fract(at - 0.5) - 0.5) / max(pace, vec2(1e-6));
  return (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.15, 0.6, max(pace.x, pace.y)));
}
void main() {
  float far = length(place - middle.xz) / extent;
  float grid = max(0.55 * lines(squares), lines(squares * 5.0));
  vec2 center = (place - shadowArea.xy) / shadowArea.zw;
  float shade = 0.0;
  // There is no shadow outside the shadow map and its soft edge.
  bool shaded = max(abs(center.x), abs(center.y)) < 1.0 + softness;
  for (int i = 0; shaded && i < 24; i++) {
    vec2 at = center + TAPS[i] * softness;
    shade += textureLod(shadow, at * 0.5 + 0.5, 0.0).r / 24.0;
  }
  vec3 color = mix(background, lineColor, grid * (1.0 - smoothstep(0.3, 1.0, far)));
  pixel = vec4(color * (1.0 - darkness * shade * (1.0 - smoothstep(0.6, 1.0, far))), 1);
}`;

/** The default size of the shadow map: pixels along one side. */
const SHADOW_SIZE = 2048;

// A bone is an octahedron with its widest part near the start.
function boneShape() {
  const ring = [[0.16, 1, 0], [0.16, 0, 1], [0.16, -1, 0], [0.16, 0, -1]];
  return ring.flatMap((corner, i) => {
    const next = ring[(i + 1) % 4];
    return [[0, 0, 0], next, corner, [1, 0, 0], corner, next];
  });
}

function rodShape() {
  const ring = Array.from({ length: 6 }, (_, i) => [Math.cos((i * Math.PI) / 3), Math.sin((i * Math.PI) / 3)]);
  return ring.flatMap((a, i) => {
    const b = ring[(i + 1) % 6];
    return [[0, ...a], [0, ...b], [1, ...b], [0, ...a], [1, ...b], [1, ...a]];
  });
}

function ballShape() {
  const [rings, sectors] = [8, 12];
  const at = (ring, sector) => {
    const [up, around] = [(Math.PI * ring) / rings, (2 * Math.PI * sector) / sectors];
    return [Math.sin(up) * Math.cos(around), Math.cos(up), Math.sin(up) * Math.sin(around)];
  };
  const corners = [];
  for (let r = 0; r < rings; r++) {
    for (let s = 0; s < sectors; s++) corners.push(at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s), at(r + 1, s + 1), at(r, s + 1));
  }
  return corners;
}

const NAMES = ["shape", "start", "end", "width", "color"];

export class GlRenderer {
  // `changed` is called when a redraw is necessary.
  constructor(canvas, changed, shadowSize = SHADOW_SIZE) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("no WebGL 2");
    Object.assign(this, { canvas, gl, changed, shadowSize });
    this.name = "WebGL";
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.build(); changed(); });
    this.build();
  }

  build() {
    const { gl } = this;
    this.bones = this.program(BONE_SHADER, LIGHT_SHADER, NAMES);
    this.shadows = this.program(BONE_SHADER, SHADOW_SHADER, NAMES);
    this.ground = this.program(GROUND_SHADER, GRID_SHADER, ["corner"]);
    this.skins = new SkinRenderer(this, this.changed);
    this.shapes = { bone: this.shape(boneShape()), rod: this.shape(rodShape()), ball: this.shape(ballShape()) };
    this.groundCorners = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.groundCorners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), gl.STATIC_DRAW);
    this.groundArray = gl.createVertexArray();
    gl.bindVertexArray(this.groundArray);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    this.shadowMap = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, this.shadowSize, this.shadowSize, 0, gl.RED, gl.UNSIGNED_BYTE, null);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
    this.shadowTarget = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.shadowMap, 0);
  }

  // Makes a shader program with these attributes, in the order of their locations.
  program(vertex, fragment, names) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    names.forEach((name, index) => gl.bindAttribLocation(program, index, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name, type } = gl.getActiveUniform(program, i);
      uniforms[name] = { place: gl.getUniformLocation(program, name), type };
    }
    return { program, uniforms };
  }

  use({ program, uniforms }, values) {
    const { gl } = this;
    gl.useProgram(program);
    for (const [name, value] of Object.entries(values)) {
      const uniform = uniforms[name];
      if (!uniform) continue;
      if (uniform.type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(uniform.place, false, value);
      else if (uniform.type === gl.FLOAT_VEC4) gl.uniform4fv(uniform.place, value);
      else if (uniform.type === gl.FLOAT_VEC3) gl.uniform3fv(uniform.place, value);
      else if (uniform.type === gl.SAMPLER_2D) gl.uniform1i(uniform.place, value);
      else gl.uniform1f(uniform.place, value);
    }
  }

  shape(corners) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners.flat()), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    const instances = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, instances);
    [[1, 3, 0], [2, 3, 3], [3, 1, 6], [4, 3, 7]].forEach(([index, size, start]) => {
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, size, gl.FLOAT, false, 4 * INSTANCE, 4 * start);
      gl.vertexAttribDivisor(index, 1);
    });
    return { array, instances, corners: corners.length };
  }

  drawBatch(shape, batch) {
    const { gl } = this;
    if (!batch.count) return;
    gl.bindVertexArray(shape.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, shape.instances);
    gl.bufferData(gl.ARRAY_BUFFER, batch.numbers.subarray(0, batch.count * INSTANCE), gl.DYNAMIC_DRAW);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, shape.corners, batch.count);
  }

  draw(view) {
    const { gl } = this;
    const { target, ground, shadowReach, sun } = view;
    this.skins.pose(view.skins, view.clips);
    const middle = [target[0], ground, target[2]];

    // The floor as seen along the sun's rays: y is folded onto the floor, x and z fill the map.
    const [rx, rz] = [-sun[0] / sun[1] / shadowReach, -sun[2] / sun[1] / shadowReach];
    const s = 1 / shadowReach;
    const toMap = [s, 0, 0, 0, rx, rz, 0, 0, 0, s, 0, 0,
      -s * middle[0] - rx * ground, -s * middle[2] - rz * ground, 0, 1];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.viewport(0, 0, this.shadowSize, this.shadowSize);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.MAX);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.use(this.shadows, { worldToClip: toMap, ground, reach: view.reach, isBall: 0, swell: 2 });
    if (view.bonesShade) this.drawBatch(this.shapes.bone, view.bones);
    this.skins.drawShadows({ worldToClip: toMap, ground, reach: view.reach });
    gl.disable(gl.BLEND);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(...view.theme.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);

    const { worldToClip, eye } = view.camera;
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    this.use(this.ground, {
      worldToClip, middle, extent: view.groundExtent, background: view.theme.background, lineColor: view.theme.grid,
      squares: view.gridStep, darkness: view.theme.shadow, softness: (0.055 * view.reach) / shadowReach, shadow: 0, shadowArea: [middle[0], middle[2], shadowReach, shadowReach],
    });
    gl.bindVertexArray(this.groundArray);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);

    this.skins.draw({ worldToClip, eye, sun });
    // The skeleton is visible through the skin.
    if (view.skins.length) gl.clear(gl.DEPTH_BUFFER_BIT);
    this.use(this.bones, { worldToClip, eye, sun, isBall: 0, swell: 1 });
    this.drawBatch(this.shapes.bone, view.bones);
    this.drawBatch(this.shapes.rod, view.rods);
    this.use(this.bones, { isBall: 1 });
    this.drawBatch(this.shapes.ball, view.balls);
  }
}
