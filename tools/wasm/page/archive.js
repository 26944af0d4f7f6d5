// Writes several files as one .zip without compression, because motions are small or already compressed.

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

function checksum(bytes) {
  let value = 0xffffffff;
  for (const byte of bytes) value = CRC_TABLE[(value ^ byte) & 255] ^ (value >>> 8);
  return (value ^ 0xffffffff) >>> 0;
}

/** The largest archive of this form, in bytes. */
const LARGEST_ARCHIVE = 2 ** 32 - 1;
const UTF_8 = 0x800;
/** The first date of the format. A constant date makes equal archives of equal files. */
const FIRST_DAY = 0x21;

/** Encodes numbers of 2 or 4 bytes, the lowest byte first. */
function littleEndian(...pairs) {
  const bytes = new Uint8Array(pairs.reduce((sum, [, size]) => sum + size, 0));
  let at = 0;
  for (const [number, size] of pairs) for (let k = 0; k < size; k++) bytes[at++] = Math.floor(number / 256 ** k) % 256;
  return bytes;
}

/** A unique file name in the archive. */
function freeName(name, taken) {
  const [, stem, extension] = /^(.*?)(\.\w+)?$/s.exec(name);
  for (let count = 1; ; count++) {
    const free = count === 1 ? name : `${stem} (${count})${extension ?? ""}`;
    if (!taken.has(free.toLowerCase())) return taken.add(free.toLowerCase()), free;
  }
}

/** Makes an archive of files, each with name and bytes. */
export function zipOf(files) {
  const [parts, directory, taken] = [[], [], new Set()];
  let at = 0;
  for (const file of files) {
    const name = new TextEncoder().encode(freeName(file.name, taken));
    const [crc, size] = [checksum(file.bytes), file.bytes.length];
    const both = [[20, 2], [UTF_8, 2], [0, 2], [0, 2], [FIRST_DAY, 2], [crc, 4], [size, 4], [size, 4], [name.length, 2], [0, 2]];
    parts.push(littleEndian([0x04034b50, 4], ...both), name, file.bytes);
    directory.push(littleEndian([0x02014b50, 4], [20, 2], ...both, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]), name);
    at += 30 + name.length + size;
    if (at > LARGEST_ARCHIVE) throw new Error("the files are together larger than 4 GB, the limit of an archive; save some of them");
  }
  const length = directory.reduce((sum, part) => sum + part.length, 0);
  const end = littleEndian([0x06054b50, 4], [0, 2], [0, 2], [files.length, 2], [files.length, 2], [length, 4], [at, 4], [0, 2]);
  return new Blob([...parts, ...directory, end], { type: "application/zip" });
}
