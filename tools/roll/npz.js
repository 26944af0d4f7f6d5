// Reads the arrays of an .npz file that numpy wrote without compression.

import { readFileSync } from "node:fs";

/** @returns {Record<string, { shape: number[], data: Float32Array }>} the arrays of 32-bit floats */
export function readNpz(path) {
  const bytes = readFileSync(path);
  const arrays = {};
  let at = 0;
  while (bytes.readUInt32LE(at) === 0x04034b50) {
    const [method, size] = [bytes.readUInt16LE(at + 8), bytes.readUInt32LE(at + 18)];
    const [nameLength, extra] = [bytes.readUInt16LE(at + 26), bytes.readUInt16LE(at + 28)];
    const name = bytes.toString("latin1", at + 30, at + 30 + nameLength);
    const start = at + 30 + nameLength + extra;
    // numpy writes the sizes of large files into the extra field.
    const length = size === 0xffffffff ? Number(bytes.readBigUInt64LE(at + 30 + nameLength + 4)) : size;
    if (method !== 0) throw new Error(`${path}: ${name} is compressed`);
    const head = bytes.toString("latin1", start + 10, start + 10 + bytes.readUInt16LE(start + 8));
    const shape = head.match(/'shape': \(([^)]*)\)/)[1].split(",").filter((word) => word.trim()).map(Number);
    if (head.includes("'<f4'")) {
      const data = bytes.buffer.slice(bytes.byteOffset + start + 10 + head.length, bytes.byteOffset + start + length);
      arrays[name.replace(/\.npy$/, "")] = { shape, data: new Float32Array(data) };
    }
    at = start + length;
  }
  return arrays;
}
