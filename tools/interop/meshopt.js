// Unpacks buffer views of EXT_meshopt_compression or KHR_meshopt_compression with the decoder of the npm package
// meshoptimizer.

import { writeFileSync } from "node:fs";

import { MeshoptDecoder } from "meshoptimizer";

import { glbOf, readGlb } from "./glb.js";

const EXTENSIONS = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/** The extension that compresses a buffer view or marks a missing buffer; undefined without such an extension. */
function packingOf(part) {
  return EXTENSIONS.map((name) => part.extensions?.[name]).find(Boolean);
}

/** The JSON and the bytes of a .glb file, with every view unpacked and the extensions removed. */
export async function unpacked(path) {
  await MeshoptDecoder.ready;
  const { json, bin } = readGlb(path);
  const parts = [];
  let length = 0;
  const bufferViews = json.bufferViews.map(({ extensions, ...view }) => {
    const packing = packingOf({ extensions });
    let bytes = bin.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
    if (packing) {
      const { byteOffset = 0, byteLength, byteStride, count, mode, filter } = packing;
      bytes = new Uint8Array(count * byteStride);
      MeshoptDecoder.decodeGltfBuffer(bytes, count, byteStride, bin.subarray(byteOffset, byteOffset + byteLength), mode, filter);
    }
    const byteOffset = length;
    const padding = new Uint8Array((4 - (bytes.length % 4)) % 4);
    parts.push(bytes, padding);
    length += bytes.length + padding.length;
    return { ...view, buffer: 0, byteOffset };
  });
  const withoutPacking = (names) => names?.filter((name) => !EXTENSIONS.includes(name));
  const plain = { ...json, buffers: [{ byteLength: length }], bufferViews };
  for (const key of ["extensionsUsed", "extensionsRequired"]) {
    const names = withoutPacking(json[key]);
    if (names?.length > 0) plain[key] = names;
    else delete plain[key];
  }
  return { json: plain, bin: new Uint8Array(Buffer.concat(parts)) };
}

/** Writes a copy of `input` with every view unpacked, which the validator can read. */
export async function writeUnpacked(input, output) {
  const { json, bin } = await unpacked(input);
  writeFileSync(output, glbOf(json, bin));
  return output;
}
