// Removes functions from the module that the page never reaches, because only the calls below use them. Each becomes a trap and
// keeps its index.

/** The exports that the page never calls. Jobs, laboratory data, packed clips and controllers are for programs. */
const UNUSED = new Set([
  "mocap_call_other", "mocap_clip_sample", "mocap_clip_free", "mocap_controller_steer", "mocap_controller_follow", "mocap_controller_free",
  "mocap_robot_stream_free",
]);

/** The ids of a module's sections, and the kind of a function in imports and exports. */
const SECTION = { custom: 0, imports: 2, exports: 7, start: 8, elements: 9, code: 10 };
const FUNCTION = 0;

/** The body of a function that is never called: no locals, `unreachable`, `end`. */
const TRAP = [3, 0, 0, 0x0b];

/** Reads the numbers of a module, LEB128. */
class Cursor {
  constructor(bytes, at) { Object.assign(this, { bytes, at }); }

  byte() { return this.bytes[this.at++]; }

  /** Reads a number. For signed numbers only the length matters. */
  number() {
    let value = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = this.byte();
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
  }

  numbers(count) { for (let i = 0; i < count; i++) this.number(); }

  list(read) { return Array.from({ length: this.number() }, read); }

  text() {
    const length = this.number();
    this.at += length;
    return Buffer.from(this.bytes.buffer, this.bytes.byteOffset + this.at - length, length).toString();
  }
}

/**
 * Skips the operands of an instruction with the prefix 0xfc: bulk memory and table instructions, and saturating conversions.
 */
function skipBulk(cursor) {
  const operands = { 8: 2, 9: 1, 10: 2, 11: 1, 12: 2, 13: 1, 14: 2, 15: 1, 16: 1, 17: 1 };
  cursor.numbers(operands[cursor.number()] ?? 0);
}

/** Skips the operands of an instruction with the prefix 0xfd: 128-bit vectors. */
function skipVector(cursor) {
  const code = cursor.number();
  if (code <= 11 || code === 92 || code === 93) cursor.numbers(2);
  else if (code === 12 || code === 13) cursor.at += 16;
  else if (code >= 21 && code <= 34) cursor.at += 1;
  else if (code >= 84 && code <= 91) {
    cursor.numbers(2);
    cursor.at += 1;
  }
}

/** The functions that a function body references. */
function namedIn(bytes, start, end) {
  const cursor = new Cursor(bytes, start);
  cursor.list(() => cursor.numbers(2));
  const named = [];
  while (cursor.at < end) {
    const code = cursor.byte();
    if (code === 0x10 || code === 0x12 || code === 0xd2) named.push(cursor.number());
    else if (code >= 0x02 && code <= 0x04) cursor.number();
    else if (code === 0x0c || code === 0x0d || (code >= 0x20 && code <= 0x26) || code === 0x3f || code === 0x40) cursor.number();
    else if (code === 0x0e) {
      cursor.list(() => cursor.number());
      cursor.number();
    } else if (code === 0x11 || code === 0x13 || (code >= 0x28 && code <= 0x3e)) cursor.numbers(2);
    else if (code === 0x1c) cursor.list(() => cursor.number());
    else if (code === 0x41 || code === 0x42 || code === 0xd0) cursor.number();
    else if (code === 0x43) cursor.at += 4;
    else if (code === 0x44) cursor.at += 8;
    else if (code === 0xfc) skipBulk(cursor);
    else if (code === 0xfd) skipVector(cursor);
    else if (code > 0xc4) throw new Error(`the instruction ${code} of WebAssembly is not known`);
  }
  if (cursor.at !== end || bytes[end - 1] !== 0x0b) throw new Error("a function of the module was not understood");
  return named;
}

function sectionsOf(bytes) {
  const sections = new Map();
  for (const cursor = new Cursor(bytes, 8); cursor.at < bytes.length; ) {
    const id = cursor.byte();
    const header = cursor.at;
    const length = cursor.number();
    if (id !== SECTION.custom) sections.set(id, { header, start: cursor.at, end: cursor.at + length });
    cursor.at += length;
  }
  return sections;
}

/** The functions in tables, which any indirect call can reach. */
function inTables(cursor) {
  return cursor.list(() => {
    if (cursor.number() !== 0) throw new Error("a table of functions has another form");
    // Skip the offset: a constant, and the end of the expression.
    cursor.byte();
    cursor.number();
    cursor.byte();
    return cursor.list(() => cursor.number());
  }).flat();
}

const lengthOf = (number) => {
  const bytes = [];
  for (let left = number; ; left = Math.floor(left / 128)) {
    bytes.push((left & 127) | (left < 128 ? 0 : 128));
    if (left < 128) return bytes;
  }
};

/** A copy of the module. */
export function leanCode(bytes) {
  const sections = sectionsOf(bytes);
  if (sections.has(SECTION.imports) || sections.has(SECTION.start)) throw new Error("the module imports something, or starts by itself");
  const at = (id) => new Cursor(bytes, sections.get(id).start);
  const exported = at(SECTION.exports);
  const roots = exported.list(() => ({ name: exported.text(), kind: exported.byte(), index: exported.number() }));
  for (const name of UNUSED) if (!roots.some((root) => root.name === name)) throw new Error(`the module has no ${name}`);
  const code = at(SECTION.code);
  const bodies = code.list(() => {
    const length = code.number();
    const start = code.at;
    code.at += length;
    return { start, end: code.at };
  });
  const reached = new Set([
    ...roots.filter(({ name, kind }) => kind === FUNCTION && !UNUSED.has(name)).map(({ index }) => index),
    ...inTables(at(SECTION.elements)),
  ]);
  // The set grows during the iteration.
  for (const index of reached) for (const named of namedIn(bytes, bodies[index].start, bodies[index].end)) reached.add(named);
  const lean = bodies.map(({ start, end }, index) => (reached.has(index) ? [...lengthOf(end - start), ...bytes.subarray(start, end)] : TRAP));
  const content = Buffer.concat([Buffer.from(lengthOf(bodies.length)), ...lean.map((body) => Buffer.from(body))]);
  const { header, end } = sections.get(SECTION.code);
  const module = Buffer.concat([bytes.subarray(0, header), Buffer.from(lengthOf(content.length)), content, bytes.subarray(end)]);
  if (!WebAssembly.validate(module)) throw new Error("the module of the page is not valid");
  return module;
}
