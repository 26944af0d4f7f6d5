// Reads the content of a written file without a glTF library.

import { readFileSync } from "node:fs";

const JSON_CHUNK = 0x4e4f534a;
const BIN_CHUNK = 0x004e4942;
const COMPONENTS = { SCALAR: 1, VEC3: 3, VEC4: 4 };
/** Component types: their reader, and the divisor of normalised values. */
const COMPONENT_TYPES = {
  5120: { array: Int8Array, most: 127 },
  5121: { array: Uint8Array, most: 255 },
  5122: { array: Int16Array, most: 32767 },
  5123: { array: Uint16Array, most: 65535 },
  5126: { array: Float32Array, most: 1 },
};

/** The JSON and the bytes of a .glb file. */
export function readGlb(path) {
  const bytes = readFileSync(path);
  const length = bytes.readUInt32LE(12);
  if (bytes.readUInt32LE(16) !== JSON_CHUNK) throw new Error(`${path}: the first chunk is not JSON`);
  return { json: JSON.parse(bytes.toString("utf8", 20, 20 + length)), bin: new Uint8Array(bytes.subarray(20 + length + 8)) };
}

/** The JSON of a .glb or .gltf file. */
export function readJson(path) {
  const bytes = readFileSync(path);
  return bytes.toString("latin1", 0, 4) === "glTF" ? readGlb(path).json : JSON.parse(bytes.toString("utf8"));
}

/** A .glb file of this JSON and these bytes. */
export function glbOf(json, bin) {
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
  const header = Buffer.alloc(20);
  header.write("glTF");
  [2, 28 + padded.length + bin.length, padded.length, JSON_CHUNK].forEach((word, at) => header.writeUInt32LE(word, 4 + 4 * at));
  const binHeader = Buffer.alloc(8);
  binHeader.writeUInt32LE(bin.length);
  binHeader.writeUInt32LE(BIN_CHUNK, 4);
  return Buffer.concat([header, padded, binHeader, bin]);
}

/** The numbers of an accessor, as doubles. The file must not be compressed; see meshopt.js. */
export function numbersOf({ json, bin }, index) {
  const { type, componentType, normalized, count, bufferView, byteOffset = 0, sparse } = json.accessors[index];
  if (bufferView === undefined || sparse) throw new Error(`accessor ${index} is sparse`);
  const { array: Type, most } = COMPONENT_TYPES[componentType];
  const view = json.bufferViews[bufferView];
  const width = COMPONENTS[type];
  const stride = view.byteStride ?? width * Type.BYTES_PER_ELEMENT;
  const numbers = new Float64Array(count * width);
  for (let element = 0; element < count; element += 1) {
    const start = (view.byteOffset ?? 0) + byteOffset + element * stride;
    const values = new Type(bin.slice(start, start + width * Type.BYTES_PER_ELEMENT).buffer);
    values.forEach((value, component) => {
      numbers[element * width + component] = normalized ? Math.max(value / most, -1) : value;
    });
  }
  return numbers;
}

/**
 * The content of a file: the nodes of the skeleton in order, which of them are joints of the skin, the frames and the
 * frame time. The parent of several roots, or of the points of a C3D file, belongs to the skeleton, but is no joint.
 * `between` lists such nodes between the skin's root and its joints, such as the armature of a Blender FBX file.
 */
export function describe(path) {
  const json = readJson(path);
  const { mocap: provenance } = json.asset.extras;
  const joints = new Set((json.skins ?? []).flatMap((skin) => skin.joints));
  const nodes = json.nodes
    .map((node, index) => ({ ...node, index, isJoint: joints.has(index), sourceName: node.extras?.source_name ?? node.name }))
    .filter((node) => node.mesh === undefined);
  const between = nodes.filter(({ index, isJoint, children }) => index > 0 && !isJoint && children);
  return { json, provenance, nodes, between, frames: provenance.frames, frameTime: provenance.frame_time };
}
