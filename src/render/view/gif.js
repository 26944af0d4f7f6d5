// Encodes pictures as an animated GIF with one palette. Each picture after the first stores only changed pixels.

const MOST_COLORS = 255;
// The last palette entry marks unchanged pixels.
const UNCHANGED = 255;
// The number of distinguished colours: five bits per component.
const COLOR_KINDS = 1 << 15;
const kindOf = (pixels, at) => ((pixels[at] >> 3) << 10) | ((pixels[at + 1] >> 3) << 5) | (pixels[at + 2] >> 3);
const partOf = (kind, part) => (kind >> (10 - 5 * part)) & 31;

// Computes the palette of pictures by median cut. The box with the largest product of pixels and extent is cut next. A
// palette colour is the mean of the pixels in its box.
export function paletteOf(pictures) {
  const counts = new Uint32Array(COLOR_KINDS);
  const sums = new Float64Array(3 * COLOR_KINDS);
  for (const pixels of pictures) {
    for (let at = 0; at < pixels.length; at += 4) {
      const kind = kindOf(pixels, at);
      counts[kind]++;
      for (let part = 0; part < 3; part++) sums[3 * kind + part] += pixels[at + part];
    }
  }
  const boxOf = (kinds) => {
    const extents = [0, 1, 2].map((part) => Math.max(...kinds.map((kind) => partOf(kind, part))) - Math.min(...kinds.map((kind) => partOf(kind, part))));
    const count = kinds.reduce((sum, kind) => sum + counts[kind], 0);
    return { kinds, count, longest: extents.indexOf(Math.max(...extents)), weight: Math.sqrt(count) * Math.max(...extents) };
  };
  const boxes = [boxOf(Array.from(counts.keys()).filter((kind) => counts[kind]))];
  while (boxes.length < MOST_COLORS) {
    boxes.sort((a, b) => a.weight - b.weight);
    if (!boxes.at(-1).weight) break;
    const { kinds, count, longest } = boxes.pop();
    kinds.sort((a, b) => partOf(a, longest) - partOf(b, longest));
    let [cut, below] = [0, 0];
    while (cut < kinds.length - 1 && below + counts[kinds[cut]] <= count / 2) below += counts[kinds[cut++]];
    cut = Math.max(1, cut);
    boxes.push(boxOf(kinds.slice(0, cut)), boxOf(kinds.slice(cut)));
  }
  return boxes.map(({ kinds, count }) => [0, 1, 2].map((part) => Math.round(kinds.reduce((sum, kind) => sum + sums[3 * kind + part], 0) / count)));
}

// Compresses bytes by LZW, in blocks of at most 255 bytes.
function lzwOf(indices) {
  const bytes = [];
  let [bits, held, width, next] = [0, 0, 9, 258];
  const put = (code) => {
    bits |= code << held;
    for (held += width; held >= 8; held -= 8, bits >>>= 8) bytes.push(bits & 255);
  };
  const known = new Int16Array(4096 * 256).fill(-1);
  put(256);
  let prefix = indices[0];
  for (let i = 1; i < indices.length; i++) {
    const at = (prefix << 8) | indices[i];
    if (known[at] >= 0) {
      prefix = known[at];
      continue;
    }
    put(prefix);
    if (next < 4096) {
      known[at] = next;
      if (next === 1 << width) width++;
      next++;
    } else {
      put(256);
      known.fill(-1);
      [width, next] = [9, 258];
    }
    prefix = indices[i];
  }
  put(prefix);
  put(257);
  if (held) bytes.push(bits & 255);
  const blocks = [8];
  for (let at = 0; at < bytes.length; at += 255) {
    const block = bytes.slice(at, at + 255);
    blocks.push(block.length, ...block);
  }
  return Uint8Array.from([...blocks, 0]);
}

const word = (number) => [number & 255, number >> 8];

export class Gif {
  // Each picture is shown for `hundredths` of a second.
  constructor({ width, height, hundredths, palette }) {
    Object.assign(this, { width, height, hundredths, palette });
    this.nearest = new Int16Array(COLOR_KINDS).fill(-1);
    this.before = null;
    const table = Array.from({ length: 256 }, (_, color) => palette[color] ?? [0, 0, 0]).flat();
    const again = [0x21, 0xff, 11, ...new TextEncoder().encode("NETSCAPE2.0"), 3, 1, 0, 0, 0];
    this.parts = [Uint8Array.from([...new TextEncoder().encode("GIF89a"), ...word(width), ...word(height), 0xf7, 0, 0, ...table, ...again])];
  }

  colorOf(kind) {
    if (this.nearest[kind] < 0) {
      const off = this.palette.map((color) => color.reduce((sum, value, part) => sum + (value - 8 * partOf(kind, part) - 4) ** 2, 0));
      this.nearest[kind] = off.indexOf(Math.min(...off));
    }
    return this.nearest[kind];
  }

  // `pixels` has four bytes per pixel, row by row from the top.
  add(pixels) {
    const { width, height, hundredths, before } = this;
    const colors = new Uint8Array(width * height);
    for (let i = 0; i < colors.length; i++) colors[i] = this.colorOf(kindOf(pixels, 4 * i));
    const drawn = before ? colors.map((color, i) => (color === before[i] ? UNCHANGED : color)) : colors;
    this.before = colors;
    // Keep the previous picture, and make one palette entry transparent.
    this.parts.push(Uint8Array.from([0x21, 0xf9, 4, before ? 5 : 4, ...word(hundredths), UNCHANGED, 0, 0x2c, 0, 0, 0, 0, ...word(width), ...word(height), 0]));
    this.parts.push(lzwOf(drawn));
  }

  get blob() { return new Blob([...this.parts, Uint8Array.from([0x3b])], { type: "image/gif" }); }
}
