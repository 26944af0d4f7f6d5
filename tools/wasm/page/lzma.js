// Decodes LZMA (`xz --format=lzma`). LZMA makes the module a quarter smaller than gzip, the only format that browsers decode.
// The code follows the public domain specification of LZMA: https://www.7-zip.org/sdk.html.

/** The bits of a probability, and the shift that adapts a probability after each bit. */
const [PROBABILITY_BITS, MOVE_BITS] = [11, 5];
const [TOP, STATES, POSITIONS] = [2 ** 24, 12, 16];
/** The shortest match, and the number of match lengths with separate distance slots. */
const [SHORTEST, LENGTH_STATES] = [2, 4];
const [ALIGN_BITS, FIRST_TREE, FIRST_DIRECT] = [4, 4, 14];

const probabilities = (count) => new Uint16Array(count).fill(2 ** (PROBABILITY_BITS - 1));

/** Reads single bits. */
class Bits {
  constructor(bytes, at) {
    Object.assign(this, { bytes, at: at + 5, range: 0xffffffff });
    this.code = new DataView(bytes.buffer, bytes.byteOffset + at + 1).getUint32(0);
  }

  normalize() {
    if (this.range >= TOP) return;
    this.range = (this.range << 8) >>> 0;
    this.code = ((this.code << 8) | this.bytes[this.at++]) >>> 0;
  }

  bit(table, index) {
    const probability = table[index];
    const bound = (this.range >>> PROBABILITY_BITS) * probability;
    let bit = 0;
    if (this.code < bound) {
      this.range = bound;
      table[index] += (2 ** PROBABILITY_BITS - probability) >> MOVE_BITS;
    } else {
      this.range -= bound;
      this.code -= bound;
      table[index] -= probability >> MOVE_BITS;
      bit = 1;
    }
    this.normalize();
    return bit;
  }

  // Reads bits with equal probabilities of 0 and 1.
  direct(count) {
    let value = 0;
    for (let i = 0; i < count; i++) {
      this.range >>>= 1;
      const bit = this.code >= this.range ? 1 : 0;
      if (bit) this.code -= this.range;
      value = value * 2 + bit;
      this.normalize();
    }
    return value;
  }

  tree(table, count, start = 0) {
    let node = 1;
    for (let i = 0; i < count; i++) node = 2 * node + this.bit(table, start + node);
    return node - 2 ** count;
  }

  // Reads a number, the lowest bit first.
  reverseTree(table, count, start = 0) {
    let [node, value] = [1, 0];
    for (let i = 0; i < count; i++) {
      const bit = this.bit(table, start + node);
      node = 2 * node + bit;
      value += bit * 2 ** i;
    }
    return value;
  }
}

/** Reads the lengths of matches. */
class Lengths {
  constructor() {
    Object.assign(this, { choices: probabilities(2), low: probabilities(POSITIONS << 3), middle: probabilities(POSITIONS << 3), high: probabilities(256) });
  }

  read(bits, position) {
    if (!bits.bit(this.choices, 0)) return bits.tree(this.low, 3, position << 3);
    if (!bits.bit(this.choices, 1)) return 8 + bits.tree(this.middle, 3, position << 3);
    return 16 + bits.tree(this.high, 8);
  }
}

/** Reads the distance of a match. */
class Distances {
  constructor() {
    this.slots = Array.from({ length: LENGTH_STATES }, () => probabilities(64));
    this.trees = probabilities(128);
    this.align = probabilities(2 ** ALIGN_BITS);
  }

  read(bits, length) {
    const slot = bits.tree(this.slots[Math.min(length, LENGTH_STATES - 1)], 6);
    if (slot < FIRST_TREE) return slot;
    const count = (slot >> 1) - 1;
    const base = (2 | (slot & 1)) * 2 ** count;
    if (slot < FIRST_DIRECT) return base + bits.reverseTree(this.trees, count, base - slot);
    return base + bits.direct(count - ALIGN_BITS) * 2 ** ALIGN_BITS + bits.reverseTree(this.align, ALIGN_BITS);
  }
}

/** Reads a literal byte. After a match, the byte at the match distance is its context. */
function literal(bits, table, start, matched) {
  let node = 1;
  if (matched >= 0) {
    while (node < 0x100) {
      const expected = (matched >> 7) & 1;
      matched <<= 1;
      const bit = bits.bit(table, start + ((1 + expected) << 8) + node);
      node = 2 * node + bit;
      if (expected !== bit) break;
    }
  }
  while (node < 0x100) node = 2 * node + bits.bit(table, start + node);
  return node & 0xff;
}

/** Returns the decompressed bytes. @param {Uint8Array} bytes */
export function fromLzma(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const contextBits = bytes[0] % 9;
  const literalMask = 2 ** (Math.floor(bytes[0] / 9) % 5) - 1;
  const positionMask = 2 ** Math.floor(bytes[0] / 45) - 1;
  const out = new Uint8Array(view.getUint32(5, true));
  const bits = new Bits(bytes, 13);
  const literals = probabilities(0x300 << (contextBits + Math.floor(bytes[0] / 9) % 5));
  const [isMatch, isLongRepeat] = [probabilities(STATES * POSITIONS), probabilities(STATES * POSITIONS)];
  const isRepeat = Array.from({ length: 4 }, () => probabilities(STATES));
  const [lengths, repeatLengths, distances] = [new Lengths(), new Lengths(), new Distances()];
  let [at, state, recent] = [0, 0, [0, 0, 0, 0]];
  while (at < out.length) {
    const position = at & positionMask;
    if (!bits.bit(isMatch, state * POSITIONS + position)) {
      const context = ((at & literalMask) << contextBits) + ((out[at - 1] ?? 0) >> (8 - contextBits));
      out[at] = literal(bits, literals, 0x300 * context, state >= 7 ? out[at - recent[0] - 1] : -1);
      at++;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let length;
    if (bits.bit(isRepeat[0], state)) {
      let which = 0;
      if (bits.bit(isRepeat[1], state)) which = bits.bit(isRepeat[2], state) ? 2 + bits.bit(isRepeat[3], state) : 1;
      else if (!bits.bit(isLongRepeat, state * POSITIONS + position)) {
        out[at] = out[at - recent[0] - 1];
        at++;
        state = state < 7 ? 9 : 11;
        continue;
      }
      recent.unshift(...recent.splice(which, 1));
      length = repeatLengths.read(bits, position);
      state = state < 7 ? 8 : 11;
    } else {
      length = lengths.read(bits, position);
      state = state < 7 ? 7 : 10;
      recent = [distances.read(bits, length), ...recent.slice(0, 3)];
    }
    const from = at - recent[0] - 1;
    if (from < 0) throw new Error("the packed module is damaged");
    for (let i = 0; i < length + SHORTEST; i++) out[at + i] = out[from + i];
    at += length + SHORTEST;
  }
  return out;
}
