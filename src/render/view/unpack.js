// Decodes the data of a page: base64 blocks of bytes, each with a run of frames of every track. pack.rs writes them.

import { isPackedClip, unpackClip } from "./packed.js";
import { unpackSkin } from "./skin.js";

// Returns the text of an element and removes it from the page, because it may be large.
export function takeText(id) {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.textContent = "";
  return text;
}

// The bytes of an element that holds base64.
export function takeBytes(id) {
  const text = takeText(id);
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// The blocks of a page or of one file. `take` returns the bytes of an id once.
export class Blocks {
  constructor(take) {
    this.take = take;
    this.sharedBytes = new Map();
    this.skins = new Map();
  }

  // The bytes of a block that several clips share.
  shared(id) {
    if (!this.sharedBytes.has(id)) this.sharedBytes.set(id, this.take(id));
    return this.sharedBytes.get(id);
  }

  // Clips that share a skin and its textures share one object, which is uploaded to the GPU once.
  skin(description) {
    const key = JSON.stringify(description);
    if (!this.skins.has(key)) {
      const textures = description.textures.map((texture) => ({ ...texture, bytes: () => this.shared(texture.id) }));
      this.skins.set(key, unpackSkin({ ...description, textures }, this.shared(description.id)));
    }
    return this.skins.get(key);
  }
}

const [ALL_FOUR, NEGATIVE] = [4, 8];

// Fills `count` frames of the tracks from rows, starting at frame `first`.
function unpackRows(bytes, tracks, first, count) {
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

// Makes the data of a clip from its description and its blocks. `load` fills the arrays of the tracks, block by block.
export function unpacked(description, source) {
  const { frames, framesPerBlock, blocks, metresPerUnit } = description;
  const tracks = [];
  const track = (value, size, node) => {
    if (Array.isArray(value)) return { values: new Float32Array(value), keys: 1 };
    tracks[value] = { values: new Float32Array(size * frames), size, keys: frames, node };
    return tracks[value];
  };
  const nodes = description.nodes.map((node, id) => ({
    ...node, translation: track(node.translation, 3, id), rotation: track(node.rotation, 4, id), scale: track(node.scale, 3, id),
  }));
  const isLoaded = new Uint8Array(blocks.length);
  const loadBlock = (block) => {
    if (block >= blocks.length || isLoaded[block]) return;
    isLoaded[block] = 1;
    const first = block * framesPerBlock;
    const bytes = source.take(blocks[block]);
    const unpack = isPackedClip(bytes) ? unpackClip : unpackRows;
    unpack(bytes, tracks, first, Math.min(framesPerBlock, frames - first), metresPerUnit);
  };
  let glb = null;
  return {
    ...description,
    nodes,
    limbs: description.limbs && { ...description.limbs, angles: new Uint16Array(Uint8Array.from(source.take(description.limbs.id)).buffer) },
    morphs: description.morphs && { ...description.morphs, weights: new Uint16Array(Uint8Array.from(source.take(description.morphs.id)).buffer) },
    skin: description.skin && source.skin(description.skin),
    load: (frame) => loadBlock(Math.floor(frame / framesPerBlock)),
    // Loads the next block; returns false after the last.
    loadNext: () => {
      const next = isLoaded.indexOf(0);
      if (next >= 0) loadBlock(next);
      return next >= 0;
    },
    source: description.source && { name: description.source.name, bytes: () => source.shared(description.source.id) },
    glb: description.glb && (() => (glb ??= source.take(description.glb))),
  };
}

// Loads all blocks in the background, so that a jump to any frame is quick.
export function loadAll(clips) {
  const loadMore = () => {
    if (clips.some((clip) => clip.loadNext())) setTimeout(loadMore, 4);
  };
  requestAnimationFrame(() => setTimeout(loadMore));
}
