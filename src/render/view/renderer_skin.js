// Draws skins with WebGL 2. The vertex shader transforms each vertex by four matrices from a texture.

import { boneMatrices } from "./skin.js";

// The number of bones per row of the matrix texture.
const BONES_A_ROW = 256;

export const SKIN_SHADER = `#version 300 es
precision highp float;
in vec3 position; in vec3 normal; in vec2 coords; in vec4 weights; in uvec4 joints;
uniform mat4 worldToClip; uniform highp sampler2D bones;
out vec3 place; out vec3 bent; out vec2 at;
mat4 bone(uint index) {
  ivec2 texel = ivec2(int(index % ${BONES_A_ROW}u) * 4, int(index / ${BONES_A_ROW}u));
  return mat4(texelFetch(bones, texel, 0), texelFetch(bones, texel + ivec2(1, 0), 0),
    texelFetch(bones, texel + ivec2(2, 0), 0), texelFetch(bones, texel + ivec2(3, 0), 0));
}
void main() {
  mat4 skin = weights.x * bone(joints.x) + weights.y * bone(joints.y) + weights.z * bone(joints.z) + weights.w * bone(joints.w);
  place = (skin * vec4(position, 1)).xyz;
  bent = mat3(skin) * normal;
  at = coords;
  gl_Position = worldToClip * vec4(place, 1);
}`;

// Light on a matte surface, in linear colours.
const COLOR_SHADER = `#version 300 es
precision highp float;
in vec3 place; in vec3 bent; in vec2 at;
uniform vec3 eye, sun; uniform vec4 color; uniform float hasImage, cutoff, isOpaque; uniform sampler2D image;
out vec4 pixel;
void main() {
  vec4 own = color * (hasImage > 0.5 ? texture(image, at) : vec4(1));
  if (own.a < cutoff) discard;
  vec3 normal = normalize(bent), view = normalize(eye - place);
  if (!gl_FrontFacing) normal = -normal;
  float light = 0.5 + 0.12 * normal.y + 0.2 * max(0.0, dot(normal, view)) + 0.45 * max(0.0, dot(normal, sun));
  pixel = vec4(pow(min(own.rgb * light, 1.0), vec3(1.0 / 2.2)), mix(own.a, 1.0, isOpaque));
}`;

// The fragment shader of shadows: a texture may have holes.
const SHADE_SHADER = `#version 300 es
precision highp float;
in vec3 place; in vec3 bent; in vec2 at;
uniform float ground, reach, hasImage, cutoff; uniform vec4 color; uniform sampler2D image;
out vec4 pixel;
void main() {
  if (color.a * (hasImage > 0.5 ? texture(image, at).a : 1.0) < cutoff) discard;
  pixel = vec4(1.0 / (1.0 + 1.6 * max(0.0, place.y - ground) / reach));
}`;

const SKIN_NAMES = ["position", "normal", "coords", "weights", "joints"];

export class SkinRenderer {
  // Uses `program` and `use` of the renderer. `changed` is called when an image is decoded.
  constructor(renderer, changed) {
    const { gl } = renderer;
    Object.assign(this, { gl, renderer, changed });
    this.colors = renderer.program(SKIN_SHADER, COLOR_SHADER, SKIN_NAMES);
    this.shades = renderer.program(SKIN_SHADER, SHADE_SHADER, SKIN_NAMES);
    this.known = new Map();
  }

  // Makes the buffers and textures of new skins, and frees the buffers and textures of removed skins.
  prepare(skins) {
    const { gl } = this;
    for (const [skin, held] of this.known) {
      if (skins.includes(skin)) continue;
      held.buffers.forEach((buffer) => gl.deleteBuffer(buffer));
      held.images.forEach((image) => gl.deleteTexture(image.texture));
      gl.deleteTexture(held.bones);
      gl.deleteVertexArray(held.array);
      this.known.delete(skin);
    }
    for (const skin of skins) {
      if (!this.known.has(skin)) this.known.set(skin, this.upload(skin));
      this.update(skin, this.known.get(skin));
    }
  }

  // Uploads vertices that morph targets have moved.
  update(skin, held) {
    const { gl } = this;
    if (held.changes === skin.changes) return;
    held.changes = skin.changes;
    [skin.positions, skin.normals].forEach((data, index) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, held.buffers[index]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, data);
    });
  }

  upload(skin) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffers = [];
    const attribute = (index, data, size, type, kind) => {
      buffers.push(gl.createBuffer());
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers.at(-1));
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(index);
      if (kind === "whole") gl.vertexAttribIPointer(index, size, type, 0, 0);
      else gl.vertexAttribPointer(index, size, type, kind === "share", 0, 0);
    };
    attribute(0, skin.positions, 3, gl.FLOAT);
    attribute(1, skin.normals, 4, gl.BYTE, "share");
    attribute(2, skin.coords, 2, gl.FLOAT);
    attribute(3, skin.weights, 4, gl.UNSIGNED_SHORT, "share");
    attribute(4, skin.joints, 4, gl.UNSIGNED_SHORT, "whole");
    buffers.push(gl.createBuffer());
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.at(-1));
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, skin.indices, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    const bones = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, bones);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    const rows = Math.ceil(skin.bones.length / BONES_A_ROW);
    return { array, buffers, bones, rows, changes: skin.changes, numbers: new Float32Array(rows * BONES_A_ROW * 16), images: skin.textures.map((texture) => this.image(texture)) };
  }

  // Makes a texture, and fills it when the browser has decoded the image.
  image({ mediaType, bytes, failed }) {
    const { gl } = this;
    const image = { texture: gl.createTexture(), isReady: false };
    const show = (bitmap) => {
      if (!gl.isTexture(image.texture)) return;
      gl.bindTexture(gl.TEXTURE_2D, image.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
      gl.generateMipmap(gl.TEXTURE_2D);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
      image.isReady = true;
      bitmap.close();
      this.changed();
    };
    gl.bindTexture(gl.TEXTURE_2D, image.texture);
    const options = { premultiplyAlpha: "none", colorSpaceConversion: "none" };
    image.shown = createImageBitmap(new Blob([bytes()], { type: mediaType }), options).then(show).catch(failed);
    return image;
  }

  // Computes the current bone matrices of the clips to draw. `all` has all clips that may be drawn later.
  pose(clips, all) {
    this.prepare(all.flatMap(({ skin }) => skin ?? []));
    this.posed = clips.map((clip) => {
      const held = this.known.get(clip.skin);
      const matrices = boneMatrices(clip.skin, clip);
      return { skin: clip.skin, held, matrices, isMirrored: isMirrored(matrices) };
    });
  }

  // Uploads the bone matrices directly before drawing a clip, because clips may share a skin.
  bindBones({ held, matrices }) {
    const { gl } = this;
    held.numbers.set(matrices);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, held.bones);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 4 * BONES_A_ROW, held.rows, 0, gl.RGBA, gl.FLOAT, held.numbers);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindVertexArray(held.array);
  }

  // Shadows are drawn from both sides of each face.
  drawParts(posed, program, parts, values) {
    const { gl } = this;
    for (const part of parts) {
      const image = posed.held.images[part.texture];
      gl.activeTexture(gl.TEXTURE2);
      gl.bindTexture(gl.TEXTURE_2D, image?.isReady ? image.texture : null);
      gl.activeTexture(gl.TEXTURE0);
      this.renderer.use(program, { color: part.color, hasImage: image?.isReady ? 1 : 0, ...values(part) });
      if (part.twoSided || program === this.shades) gl.disable(gl.CULL_FACE);
      else gl.enable(gl.CULL_FACE);
      gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 4 * part.first);
    }
  }

  drawShadows(values) {
    const { gl } = this;
    this.renderer.use(this.shades, { ...values, image: 2, bones: 1 });
    for (const posed of this.posed) {
      this.bindBones(posed);
      this.drawParts(posed, this.shades, posed.skin.parts, (part) => ({ cutoff: { opaque: 0, mask: part.cutoff, blend: 0.5 }[part.alpha] }));
    }
    gl.disable(gl.CULL_FACE);
  }

  // Transparent parts are drawn last.
  draw(values) {
    const { gl } = this;
    this.renderer.use(this.colors, { ...values, image: 2, bones: 1 });
    for (const isBlended of [false, true]) {
      if (isBlended) {
        gl.enable(gl.BLEND);
        gl.blendEquation(gl.FUNC_ADD);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
        gl.depthMask(false);
      }
      for (const posed of this.posed) {
        this.bindBones(posed);
        gl.frontFace(posed.isMirrored ? gl.CW : gl.CCW);
        const parts = posed.skin.parts.filter((part) => (part.alpha === "blend") === isBlended);
        this.drawParts(posed, this.colors, parts, (part) => ({ cutoff: part.alpha === "mask" ? part.cutoff : 0, isOpaque: isBlended ? 0 : 1 }));
      }
    }
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
    gl.frontFace(gl.CCW);
    gl.depthMask(true);
  }

  // Resolves when every image is decoded.
  get ready() { return Promise.all([...this.known.values()].flatMap(({ images }) => images.map((image) => image.shown))); }
}

// Whether the first bone's matrix is a reflection, which flips the side of triangles.
function isMirrored(m) {
  return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) + m[8] * (m[1] * m[6] - m[5] * m[2]) < 0;
}
