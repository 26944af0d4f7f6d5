// Reads a packed clip in double precision and without code of mocap; docs/packed-clip.md describes the bytes.

import { readFileSync } from "node:fs";

import { nlerp } from "./clips.js";

const [ROTATES, TRANSLATES, ROTATION, TRANSLATION, SCALE] = [1, 2, 4, 8, 16];

class Bits {
  constructor(bytes, at) {
    Object.assign(this, { bytes, at });
  }

  next(count) {
    let value = 0;
    for (let bit = 0; bit < count; bit += 1, this.at += 1) value += ((this.bytes[this.at >> 3] >> (this.at & 7)) & 1) * 2 ** bit;
    return value;
  }
}

/** @returns {import("./clips.js").Clip & { times: number[] }} */
export function openPacked(path) {
  const bytes = readFileSync(path);
  let at = 0;
  const read = (method, size) => bytes[method]((at += size) - size);
  const u8 = () => read("readUInt8", 1);
  const u16 = () => read("readUInt16LE", 2);
  const i16 = () => read("readInt16LE", 2);
  const u32 = () => read("readUInt32LE", 4);
  const i32 = () => read("readInt32LE", 4);
  const f32 = () => read("readFloatLE", 4);
  const f64 = () => read("readDoubleLE", 8);
  const many = (count, one) => Array.from({ length: count }, one);

  if (bytes.toString("latin1", 0, 4) !== "MCLP") throw new Error(`${path} is not a packed clip`);
  at = 4;
  if (u16() !== 1) throw new Error(`${path} has another version`);
  const blockFrames = 2 ** u16();
  const [nodeCount, frames, rate] = [u32(), u32(), f64()];
  f64();
  f32();
  const [rotations, translations, nameBytes, flags] = [u32(), u32(), u32(), u32()];
  const nodes = many(nodeCount, () => ({ parent: u16(), flags: u8(), nameBytes: u16() }));
  const names = nodes.map(({ nameBytes: length }) => bytes.toString("utf8", at, (at += length)));
  if (nameBytes !== nodes.reduce((sum, node) => sum + node.nameBytes, 0)) throw new Error(`${path}: names`);
  const rest = nodes.map(({ flags: has }) => ({
    rotation: has & ROTATION ? many(4, f32) : [0, 0, 0, 1],
    translation: has & TRANSLATION ? many(3, f32) : [0, 0, 0],
    scale: has & SCALE ? many(3, f32) : [1, 1, 1],
  }));
  const ticks = flags & 1 ? many(frames, f64) : many(frames, (_, frame) => frame);
  const driven = (flag) => nodes.flatMap((node, index) => (node.flags & flag ? [index] : []));
  const tracks = [
    ...driven(ROTATES).map((node) => ({ node, isRotation: true, step: 1 / (u16() * Math.SQRT2), least: many(6, i16), bits: many(6, u8) })),
    ...driven(TRANSLATES).map((node) => ({ node, isRotation: false, step: f32(), least: many(6, i32), bits: many(6, u8) })),
  ];
  if (tracks.length !== rotations + translations) throw new Error(`${path}: tracks`);
  const blockCount = tracks.length > 0 ? Math.ceil(frames / blockFrames) : 0;
  const starts = many(blockCount + 1, u32);
  const blocksAt = at;

  // All keys, one after the other.
  const keys = [];
  for (let block = 0; block < blockCount; block += 1) {
    at = blocksAt + starts[block] + 4;
    const count = Math.min(blockFrames, frames - block * blockFrames);
    const input = new Bits(bytes, 8 * at);
    const has = flags & 2 ? many(count, () => 1) : many(blockFrames, () => input.next(1));
    const widthBits = (track) => (track.isRotation ? 4 : 5);
    const headers = tracks.map((track) => {
      const kind = track.isRotation ? input.next(3) : 0;
      const widths = many(3, () => input.next(widthBits(track))).map((width) => (track.isRotation && width === 15 ? 16 : width));
      return { kind, widths, lines: track.bits.map((bits, index) => track.least[index] + input.next(bits)) };
    });
    has.forEach((one, offset) => {
      if (!one) return;
      const values = tracks.map(({ step, isRotation }, track) => {
        const { kind, widths, lines } = headers[track];
        const dropped = isRotation && kind === 4 ? input.next(2) : kind;
        const stored = widths.map((width, axis) => lines[axis] + Math.floor((lines[3 + axis] * offset) / blockFrames) + input.next(width));
        const three = stored.map((value) => value * step);
        if (!isRotation) return three;
        const rotation = [0, 0, 0, 0];
        rotation[dropped] = Math.sqrt(Math.max(0, 1 - three.reduce((sum, value) => sum + value * value, 0)));
        three.forEach((value, index) => (rotation[(dropped + 1 + index) % 4] = value));
        return rotation;
      });
      keys.push({ tick: ticks[block * blockFrames + offset], values });
    });
  }

  const poseAt = (seconds) => {
    const pose = rest.map((local) => ({ ...local }));
    if (keys.length === 0) return pose;
    // Times of the source are 32-bit floats; a time within their rounding of a frame means that frame.
    const exact = seconds * rate;
    const tick = Math.abs(exact - Math.round(exact)) < 1e-3 ? Math.round(exact) : exact;
    const after = keys.findIndex((key) => key.tick > tick);
    const next = after < 0 ? keys.length - 1 : after;
    const last = Math.max(0, after < 0 ? next : next - 1);
    const span = keys[next].tick - keys[last].tick;
    const share = span > 0 ? Math.min(Math.max((tick - keys[last].tick) / span, 0), 1) : 0;
    tracks.forEach(({ node, isRotation }, track) => {
      const [a, b] = [keys[last].values[track], keys[next].values[track]];
      if (isRotation) pose[node].rotation = nlerp(a, b, share);
      else pose[node].translation = a.map((value, axis) => value + share * (b[axis] - value));
    });
    return pose;
  };
  const parents = nodes.map(({ parent }) => (parent === 65535 ? -1 : parent));
  return { names, parents, times: ticks.map((tick) => tick / rate), at: poseAt };
}
