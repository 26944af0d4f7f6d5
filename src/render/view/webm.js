// Writes encoded pictures as a WebM film: elements of Matroska, https://www.rfc-editor.org/rfc/rfc9559.

import { bigEndian, bytesOfAll } from "./bytes.js";

const utf8Encoder = new TextEncoder();
const fewestBytes = (number) => Math.max(1, Math.ceil(Math.log2(number + 1) / 8));

// An element: id, length in eight bytes, and contents. Each is a list of pieces of bytes.
function matroska(id, ...contents) {
  const parts = contents.flat();
  const length = bigEndian(bytesOfAll(parts), 8);
  length[0] = 1;
  return [bigEndian(id, fewestBytes(id)), length, ...parts];
}

const unsigned = (id, value, count = fewestBytes(value)) => matroska(id, bigEndian(value, count));
const utf8 = (id, value) => matroska(id, utf8Encoder.encode(value));

function double(id, value) {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return matroska(id, bytes);
}

// The numbers of ITU-T H.273 for the browsers' names of colour spaces.
const MATRICES = { rgb: 0, bt709: 1, bt470bg: 5, smpte170m: 6 };
const TRANSFERS = { bt709: 1, smpte170m: 6, "iec61966-2-1": 13 };
const PRIMARIES = { bt709: 1, bt470bg: 5, smpte170m: 6 };

function colour({ matrix, transfer, primaries, fullRange } = {}) {
  const known = (id, table, name) => (name in table ? unsigned(id, table[name]) : []);
  return matroska(0x55b0, known(0x55b1, MATRICES, matrix), unsigned(0x55b9, fullRange ? 2 : 1), known(0x55ba, TRANSFERS, transfer), known(0x55bb, PRIMARIES, primaries));
}

const ebmlHead = () => matroska(0x1a45dfa3, unsigned(0x4286, 1), unsigned(0x42f7, 1), unsigned(0x42f2, 4), unsigned(0x42f3, 8), utf8(0x4282, "webm"), unsigned(0x4287, 4), unsigned(0x4285, 2));

// Groups the pictures in clusters, each from a key frame to the next, with times in milliseconds.
function clustersOf(pictures) {
  const clusters = [];
  for (const picture of pictures) {
    if (picture.isKey || !clusters.length) clusters.push([]);
    clusters.at(-1).push(picture);
  }
  return clusters.map((pictures) => {
    const [{ milliseconds: start }] = pictures;
    const blocks = pictures.map(({ bytes, milliseconds, isKey }) =>
      matroska(0xa3, new Uint8Array([0x81]), bigEndian(milliseconds - start, 2), new Uint8Array([isKey ? 0x80 : 0]), bytes));
    return { start, parts: matroska(0x1f43b675, unsigned(0xe7, start), ...blocks) };
  });
}

// Makes a film of pictures, each with bytes, milliseconds and isKey. `codec` is "V_VP9" or "V_VP8". `rate` is in
// pictures per second.
export function webmOf(pictures, { codec, width, height, rate, colorSpace }) {
  const info = matroska(0x1549a966, unsigned(0x2ad7b1, 1e6), double(0x4489, (1000 * pictures.length) / rate), utf8(0x4d80, "mocap"), utf8(0x5741, "mocap"));
  const video = matroska(0xe0, unsigned(0xb0, width), unsigned(0xba, height), colour(colorSpace));
  const track = matroska(0xae, unsigned(0xd7, 1), unsigned(0x73c5, 1), unsigned(0x83, 1), unsigned(0x9c, 0), utf8(0x86, codec), unsigned(0x23e383, Math.round(1e9 / rate)), video);
  const clusters = clustersOf(pictures);
  // The positions of clusters come before the clusters, in numbers of fixed length.
  const cuesAt = (places) => matroska(0x1c53bb6b, ...clusters.map(({ start }, i) =>
    matroska(0xbb, unsigned(0xb3, start, 8), matroska(0xb7, unsigned(0xf7, 1), unsigned(0xf1, places[i], 8)))));
  const before = [...info, ...matroska(0x1654ae6b, track)];
  let at = bytesOfAll(before) + bytesOfAll(cuesAt(clusters.map(() => 0)));
  const places = clusters.map(({ parts }) => {
    const place = at;
    at += bytesOfAll(parts);
    return place;
  });
  return new Blob([...ebmlHead(), ...matroska(0x18538067, before, cuesAt(places), ...clusters.map(({ parts }) => parts))], { type: "video/webm" });
}
