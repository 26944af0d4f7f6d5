// Clears data of the module that the page does not use. The bytes become zeros, so that all addresses stay valid. Compressed
// zeros take no space.

/** The position of one list of bytes in another, or -1. */
const placeOf = (bytes, part) => Buffer.from(bytes.buffer, bytes.byteOffset, bytes.length).indexOf(part);

/** The TrueType tables that are needed to read outlines. */
const USED_TABLES = new Set(["cmap", "glyf", "loca", "hmtx", "head", "hhea", "maxp"]);

/**
 * The characters in pictures of the page: Latin, Greek, Cyrillic, Armenian, Hebrew, punctuation, currencies, letter-like
 * symbols, arrows and mathematics.
 */
const LETTERS = [[0x20, 0x5ff], [0x1e00, 0x1fff], [0x2000, 0x22ff]];

/** The first bytes of every TrueType font. */
const TRUE_TYPE = Buffer.from([0, 1, 0, 0]);

/**
 * The glyphs of the characters, from a cmap table of format 4: four lists with the ends, starts, deltas and offsets of ranges.
 */
function glyphsOf(font, cmap) {
  const tables = Array.from({ length: font.getUint16(cmap + 2) }, (_, i) => cmap + font.getUint32(cmap + 8 + 8 * i));
  const at = tables.find((table) => font.getUint16(table) === 4);
  if (at === undefined) throw new Error("the font has no table of letters of format 4");
  const size = font.getUint16(at + 6);
  const list = (index, i) => at + 14 + index * size + (index ? 2 : 0) + i;
  const glyphs = new Set([0]);
  for (let i = 0; i < size; i += 2) {
    const [end, start, difference, place] = [0, 1, 2, 3].map((index) => font.getUint16(list(index, i)));
    for (const [first, last] of LETTERS) {
      for (let letter = Math.max(first, start); letter <= Math.min(last, end); letter++) {
        const glyph = place ? font.getUint16(list(3, i) + place + 2 * (letter - start)) : letter;
        if (glyph || !place) glyphs.add((glyph + difference) & 0xffff);
      }
    }
  }
  return glyphs;
}

/** The components of a composite glyph. */
function partsOf(font, at) {
  const parts = [];
  for (let flags = 0x20, next = at + 10; flags & 0x20; ) {
    flags = font.getUint16(next);
    parts.push(font.getUint16(next + 2));
    next += 4 + (flags & 1 ? 4 : 2) + (flags & 8 ? 2 : flags & 0x40 ? 4 : flags & 0x80 ? 8 : 0);
  }
  return parts;
}

/** Reduces a font to the outlines of the characters above, without hinting instructions. */
function leanFont(bytes, start) {
  const font = new DataView(bytes.buffer, bytes.byteOffset + start);
  const tables = new Map(Array.from({ length: font.getUint16(4) }, (_, i) => {
    const at = 12 + 16 * i;
    const name = String.fromCharCode(...[0, 1, 2, 3].map((k) => font.getUint8(at + k)));
    return [name, { at: font.getUint32(at + 8), length: font.getUint32(at + 12) }];
  }));
  const clear = (at, length) => bytes.fill(0, start + at, start + at + length);
  for (const [name, { at, length }] of tables) if (!USED_TABLES.has(name)) clear(at, length);
  const isLong = font.getInt16(tables.get("head").at + 50) === 1;
  const loca = tables.get("loca").at;
  const glyph = (index) => {
    const place = (i) => tables.get("glyf").at + (isLong ? font.getUint32(loca + 4 * i) : 2 * font.getUint16(loca + 2 * i));
    return { at: place(index), length: place(index + 1) - place(index) };
  };
  const kept = glyphsOf(font, tables.get("cmap").at);
  // The set grows during the iteration.
  for (const index of kept) {
    const { at, length } = glyph(index);
    if (length && font.getInt16(at) < 0) for (const part of partsOf(font, at)) kept.add(part);
  }
  for (let index = 0; index < font.getUint16(tables.get("maxp").at + 4); index++) {
    const { at, length } = glyph(index);
    if (!length) continue;
    if (!kept.has(index)) clear(at, length);
    else if (font.getInt16(at) > 0) {
      const instructions = at + 10 + 2 * font.getInt16(at);
      clear(instructions + 2, font.getUint16(instructions));
    }
  }
}

/** The least size of a table to clear, in bytes. The search for a shorter table could match other data. */
const LEAST_TABLE = 500;

/**
 * The encoding tables in the source of the crate encoding_rs, except Shift-JIS, the encoding of MikuMikuDance names. The crate
 * links all tables, but mocap decodes only Shift-JIS with it.
 */
export function unusedEncodings(source) {
  const tables = source.matchAll(/static ([A-Z0-9_]+): \[u(8|16|32); \d+\] = \[([^\]]*)\]/g);
  return Array.from(tables, ([, name, bits, list]) => {
    if (/^(JIS0208|IBM_KANJI)/.test(name)) return Buffer.alloc(0);
    const numbers = list.split(",").filter((word) => word.trim()).map(Number);
    const Kind = { 8: Uint8Array, 16: Uint16Array, 32: Uint32Array }[bits];
    return Buffer.from(Kind.from(numbers).buffer);
  }).filter(({ length }) => length >= LEAST_TABLE);
}

/**
 * Returns a reduced copy of the module. `parts` are texts of `mocap view` and `mocap survey`, which the page does not write,
 * and unused tables.
 */
export function leanModule(wasm, parts) {
  const bytes = Uint8Array.from(wasm);
  for (const part of parts.map((part) => Buffer.from(part))) {
    const at = placeOf(bytes, part);
    if (at >= 0) bytes.fill(0, at, at + part.length);
  }
  // The font: a header of TrueType whose tables are in the order of their names.
  for (let at = placeOf(bytes, TRUE_TYPE); at >= 0; ) {
    const names = [0, 1].map((i) => Buffer.from(bytes.subarray(at + 12 + 16 * i, at + 16 + 16 * i)).toString("latin1"));
    if (names[0] === "FFTM" && names[1] === "GDEF") {
      leanFont(bytes, at);
      return bytes;
    }
    const next = placeOf(bytes.subarray(at + 1), TRUE_TYPE);
    at = next < 0 ? -1 : at + 1 + next;
  }
  throw new Error("the module has no font where DejaVu was");
}
