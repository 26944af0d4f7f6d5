// What a written file says about itself, read without any glTF library.

import { readFileSync } from "node:fs";

const JSON_CHUNK = 0x4e4f534a;

/** The JSON of a .glb or .gltf file. */
export function readJson(path) {
  const bytes = readFileSync(path);
  if (bytes.toString("latin1", 0, 4) !== "glTF") return JSON.parse(bytes.toString("utf8"));
  const length = bytes.readUInt32LE(12);
  if (bytes.readUInt32LE(16) !== JSON_CHUNK) throw new Error(`${path}: the first chunk is not JSON`);
  return JSON.parse(bytes.toString("utf8", 20, 20 + length));
}

/** The numbers of a float accessor of a .glb file. */
export function readFloats(path, accessorIndex) {
  const bytes = readFileSync(path);
  const json = readJson(path);
  const accessor = json.accessors[accessorIndex];
  const components = { SCALAR: 1, VEC3: 3, VEC4: 4 }[accessor.type];
  const binStart = 20 + bytes.readUInt32LE(12) + 8;
  const start = binStart + (json.bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const end = start + 4 * components * accessor.count;
  return new Float32Array(bytes.buffer.slice(bytes.byteOffset + start, bytes.byteOffset + end));
}

/**
 * What a file holds: the nodes of the skeleton in their order, which of them are joints of the skin, the frames and the
 * frame time. A node that several roots hang on, or the points of a C3D file, is in the skeleton, and no joint; `between`
 * lists such nodes that stand between the skin's root and its joints, as the armature of a Blender FBX does.
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
