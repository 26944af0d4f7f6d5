// The data of a page: blocks of bytes in base64, each with a run of frames of every track; pack.rs writes them.

import { unpackSkin } from "./skin.js";

// The bytes of an element that holds base64; the text is dropped, because it may be large.
export function takeBytes(id) {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.textContent = "";
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// The same of an element that several clips share.
const shared = new Map();
function sharedBytes(id) {
  if (!shared.has(id)) shared.set(id, takeBytes(id));
  return shared.get(id);
}

// Clips with one skin and its textures have one object, which is on the GPU once.
const skins = new Map();
function skinOf(description) {
  const key = JSON.stringify(description);
  if (!skins.has(key)) {
    const textures = description.textures.map((texture) => ({ ...texture, bytes: () => sharedBytes(texture.id) }));
    skins.set(key, unpackSkin({ ...description, textures }, sharedBytes(description.id)));
  }
  return skins.get(key);
}

const [ALL_FOUR, NEGATIVE] = [4, 8];

// Fills `count` frames of the tracks, from frame `first` on, from the bytes of a block.
export function unpackBlock(bytes, tracks, first, count) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  const row = (values, size, component) => {
    const width = bytes[at++];
    let to = first * size + component;
    if (width === 4) {
      for (let i = 0; i < count; i++, at += 4, to += size) values[to] = view.getFloat32(at, true);
      return;
    }
    const least = view.getFloat32(at, true);
    const step = view.getFloat64(at + 4, true);
    at += 12;
    for (let i = 0; i < count; i++, to += size) {
      let steps = 0;
      for (let byte = 0; byte < width; byte++) steps += bytes[at++] * 2 ** (8 * byte);
      values[to] = least + steps * step;
    }
  };
  for (const { values, size } of tracks) {
    const form = size === 4 ? bytes[at++] : ALL_FOUR;
    const leftOut = form === ALL_FOUR ? -1 : form & 3;
    for (let component = 0; component < size; component++) if (component !== leftOut) row(values, size, component);
    if (leftOut < 0) continue;
    const sign = form & NEGATIVE ? -1 : 1;
    for (let i = first; i < first + count; i++) {
      let squares = 0;
      for (let component = 0; component < 4; component++) if (component !== leftOut) squares += values[4 * i + component] ** 2;
      values[4 * i + leftOut] = sign * Math.sqrt(Math.max(0, 1 - squares));
    }
  }
}

// The data of a clip from its description: tracks as arrays that `load` fills, block by block.
export function unpacked(description) {
  const { frames, framesPerBlock, blocks } = description;
  const tracks = [];
  const track = (value, size) => {
    if (Array.isArray(value)) return { values: new Float32Array(value), keys: 1 };
    tracks[value] = { values: new Float32Array(size * frames), size, keys: frames };
    return tracks[value];
  };
  const nodes = description.nodes.map((node) => ({
    ...node, translation: track(node.translation, 3), rotation: track(node.rotation, 4), scale: track(node.scale, 3),
  }));
  const isLoaded = new Uint8Array(blocks.length);
  const loadBlock = (block) => {
    if (block >= blocks.length || isLoaded[block]) return;
    isLoaded[block] = 1;
    const first = block * framesPerBlock;
    unpackBlock(takeBytes(blocks[block]), tracks, first, Math.min(framesPerBlock, frames - first));
  };
  let glb = null;
  return {
    ...description,
    nodes,
    limbs: description.limbs && { ...description.limbs, bytes: takeBytes(description.limbs.id) },
    skin: description.skin && skinOf(description.skin),
    load: (frame) => loadBlock(Math.floor(frame / framesPerBlock)),
    // Loads one more block; false where there is none.
    loadNext: () => {
      const next = isLoaded.indexOf(0);
      if (next >= 0) loadBlock(next);
      return next >= 0;
    },
    glb: description.glb && (() => (glb ??= takeBytes(description.glb))),
  };
}
