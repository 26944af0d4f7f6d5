// Writes H.264 pictures as an MP4 film: boxes of ISO/IEC 14496-12, and of 14496-15 for the codec.

import { bigEndian, bytesOfAll } from "./bytes.js";

const TICKS_PER_SECOND = 90000;
// The identity matrix of a track, in fixed point: 16 fractional bits, and 30 in the last column.
const IDENTITY_MATRIX = [0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000];

// Encodes numbers in sequence, with four bytes each, or as [number, count of bytes].
function fields(...numbers) {
  const pairs = numbers.map((number) => (Array.isArray(number) ? number : [number, 4]));
  return Uint8Array.from(pairs.flatMap(([number, count]) => [...bigEndian(number, count)]));
}

const letters = (word) => Uint8Array.from(word, (letter) => letter.charCodeAt(0));

// A box: length, name and contents, as a list of pieces of bytes.
function box(name, ...contents) {
  const parts = contents.flat();
  return [fields(8 + bytesOfAll(parts)), letters(name), ...parts];
}

// The tables of the pictures' positions: one contiguous chunk that begins at `start`.
function sampleTables(pictures, { width, height, rate, description }, start) {
  const entry = box("avc1", fields([0, 6], [1, 2], 0, 0, 0, 0, [width, 2], [height, 2], 0x480000, 0x480000, 0, [1, 2], [0, 32], [24, 2], [0xffff, 2]), box("avcC", description));
  const keys = pictures.flatMap(({ isKey }, index) => (isKey ? [index + 1] : []));
  return box("stbl",
    box("stsd", fields(0, 1), entry),
    box("stts", fields(0, 1, pictures.length, Math.round(TICKS_PER_SECOND / rate))),
    box("stss", fields(0, keys.length, ...keys)),
    box("stsc", fields(0, 1, 1, pictures.length, 1)),
    box("stsz", fields(0, 0, pictures.length, ...pictures.map(({ bytes }) => bytes.length))),
    box("stco", fields(0, 1, start)));
}

// Makes a film of pictures, each with bytes and isKey. The decoder needs `description` before the first picture.
export function mp4Of(pictures, format) {
  const { width, height, rate } = format;
  const duration = pictures.length * Math.round(TICKS_PER_SECOND / rate);
  const movie = (start) => box("moov",
    box("mvhd", fields(0, 0, 0, TICKS_PER_SECOND, duration, 0x10000, [0x100, 2], [0, 10], ...IDENTITY_MATRIX, [0, 24], 2)),
    box("trak",
      box("tkhd", fields(3, 0, 0, 1, 0, duration, [0, 8], [0, 2], [0, 2], [0, 2], [0, 2], ...IDENTITY_MATRIX, 0x10000 * width, 0x10000 * height)),
      box("mdia",
        box("mdhd", fields(0, 0, 0, TICKS_PER_SECOND, duration, [0x55c4, 2], [0, 2])),
        box("hdlr", fields(0, 0), letters("vide"), fields([0, 12], [0, 1])),
        box("minf",
          box("vmhd", fields(1, [0, 8])),
          box("dinf", box("dref", fields(0, 1), box("url ", fields(1)))),
          sampleTables(pictures, format, start)))));
  const head = box("ftyp", letters("isom"), fields(0x200), letters("isomiso2avc1mp41"));
  const start = bytesOfAll(head) + bytesOfAll(movie(0)) + 8;
  const bytes = pictures.map((picture) => picture.bytes);
  return new Blob([...head, ...movie(start), ...box("mdat", bytes)], { type: "video/mp4" });
}
