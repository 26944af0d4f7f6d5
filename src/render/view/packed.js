// Decodes a run of frames from a packed clip; docs/packed-clip.md describes the bytes. Loading decodes every frame
// once.

// Flags of the file and of a node, bytes of a node in the table, the kind of a rotation whose keys do not all omit the
// same component.
const ALL_KEYS = 2;
const FLAG = { rotates: 1, translates: 2, rotation: 4, translation: 8, scale: 16, restRotation: 64, restTranslation: 128 };
const [NODE, MIXED] = [5, 4];

export const isPackedClip = (bytes) => String.fromCharCode(...bytes.subarray(0, 4)) === "MCLP";

const three = (next) => [0, 1, 2].map(next);

// Reads numbers in sequence: whole bytes, or a few bits each, starting at `bit`.
class ClipReader {
  constructor(bytes) {
    Object.assign(this, { view: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), at: 0, bit: 0 });
  }

  number(kind, size) {
    this.at += size;
    return this.view[`get${kind}`](this.at - size, true);
  }

  u32() { return this.number("Uint32", 4); }
  floats(count) { return Array.from({ length: count }, () => this.number("Float32", 4)); }

  // Reads at most 24 bits.
  bits(count) {
    const value = (this.view.getUint32(this.bit >>> 3, true) >>> (this.bit & 7)) & ((1 << count) - 1);
    this.bit += count;
    return value;
  }

  // The ranges for all blocks of a track: the least value and slope of its lines, and the bits of the remainders.
  lines(kind, size) {
    const [number, rise] = [0, 1].map(() => three(() => this.number(kind, size)));
    const [bits, riseBits] = [0, 1].map(() => three(() => this.number("Uint8", 1)));
    return { number, rise, bits, riseBits };
  }

  // The lines of a track in a block.
  inBlock({ lines: { number, rise, bits, riseBits } }, widths) {
    return { widths, from: three((axis) => number[axis] + this.bits(bits[axis])), rise: three((axis) => rise[axis] + this.bits(riseBits[axis])) };
  }

  component({ from, rise, widths }, axis, offset, log2) {
    return (from[axis] + (Math.imul(rise[axis], offset) >> log2) + this.bits(widths[axis])) | 0;
  }

  // The frames with keys in a block.
  keys(frames, hasAll) {
    return Array.from({ length: frames }, (_, frame) => frame).filter(() => hasAll || this.bits(1));
  }
}

// Interpolates the frames between two keys. Rotations are interpolated along the shorter arc.
function fillBetween({ values, size }, before, after) {
  const [a, b] = [size * before, size * after];
  let dot = 0;
  if (size === 4) for (let i = 0; i < 4; i++) dot += values[a + i] * values[b + i];
  if (dot < 0) for (let i = 0; i < 4; i++) values[b + i] *= -1;
  for (let frame = before + 1; frame < after; frame++) {
    const share = (frame - before) / (after - before);
    const at = size * frame;
    let square = size === 4 ? 0 : 1;
    for (let i = 0; i < size; i++) {
      values[at + i] = values[a + i] + (values[b + i] - values[a + i]) * share;
      if (size === 4) square += values[at + i] ** 2;
    }
    for (let i = 0; i < size; i++) values[at + i] /= Math.sqrt(square);
  }
}

// Fills `count` frames of the tracks, starting at frame `first`. Each track has its node. A track with 4 numbers is a
// rotation.
export function unpackClip(bytes, tracks, first, count, metresPerUnit) {
  const reader = new ClipReader(bytes);
  reader.at = 6;
  const log2 = reader.number("Uint16", 2);
  const nodes = reader.u32();
  // Skip the header: frames, rate, duration, error and numbers of tracks.
  reader.at = 44;
  const nameBytes = reader.u32();
  const hasAll = reader.u32() & ALL_KEYS;
  const table = reader.at;
  reader.at += NODE * nodes + nameBytes;
  const moving = { 3: [], 4: [] };
  for (let node = 0; node < nodes; node++) {
    const has = (name) => reader.view.getUint8(table + NODE * node + 2) & FLAG[name];
    const put = (size, moves, constant) => {
      const track = tracks.find((track) => track.node === node && track.size === size);
      if (moves) moving[size].push({ ...track });
      else if (track) for (let frame = first; frame < first + count; frame++) track.values.set(constant, size * frame);
    };
    put(4, has("rotates"), has("rotation") ? reader.floats(4) : [0, 0, 0, 1]);
    put(3, has("translates"), (has("translation") ? reader.floats(3) : [0, 0, 0]).map((metres) => metres / metresPerUnit));
    for (const [name, size] of [["scale", 3], ["restRotation", 4], ["restTranslation", 3]]) if (has(name)) reader.floats(size);
  }
  for (const track of moving[4]) {
    track.step = Math.SQRT1_2 / reader.number("Uint16", 2);
    track.lines = reader.lines("Int16", 2);
  }
  for (const track of moving[3]) {
    track.step = reader.number("Float32", 4) / metresPerUnit;
    track.lines = reader.lines("Int32", 4);
  }
  const all = [...moving[4], ...moving[3]];
  if (!all.length) return;
  const blocks = Array.from({ length: Math.ceil(count / 2 ** log2) + 1 }, () => reader.u32());
  let before = first;
  for (let block = 0; block < blocks.length - 1; block++) {
    const start = first + block * 2 ** log2;
    reader.bit = 8 * (reader.at + blocks[block] + 4);
    const keys = reader.keys(2 ** log2, hasAll).filter((key) => start + key < first + count);
    for (const track of moving[4]) {
      track.kind = reader.bits(3);
      track.block = reader.inBlock(track, three(() => reader.bits(4)).map((width) => width + (width === 15)));
    }
    for (const track of moving[3]) track.block = reader.inBlock(track, three(() => reader.bits(5)));
    for (const key of keys) {
      const frame = start + key;
      for (const { values, size, step, kind, block } of all) {
        const dropped = size === 3 ? -1 : kind === MIXED ? reader.bits(2) : kind;
        let rest = 1;
        for (let axis = 0; axis < 3; axis++) {
          const value = reader.component(block, axis, key, log2) * step;
          values[size * frame + ((dropped + 1 + axis) & 3)] = value;
          rest -= value * value;
        }
        if (size === 4) values[4 * frame + dropped] = Math.sqrt(Math.max(0, rest));
      }
      for (const track of all) fillBetween(track, before, frame);
      before = frame;
    }
  }
}
