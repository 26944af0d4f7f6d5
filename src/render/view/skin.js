// A skin: vertices, triangles, and the bones that move them; skin.rs packs it, renderer_skin.js draws it.
//
//   vertices, corners    their numbers
//   positions, coords    of the vertices; coords are texture coordinates
//   normals, weights, joints   of the vertices: 4 numbers each; normals are signed bytes, weights sum to 65535
//   indices              the corners of triangles
//   bones, offsets       the node of each bone, and the matrix from the mesh to the node in the bind pose
//   morphs               sliders: name, weight (in the rest pose, included in positions), count (of affected vertices), step
//   morphIds, morphOffsets, morphNormals   slider after slider: affected vertices, offsets in steps along x, y, z, and
//                        offsets of normals in units of 1/63
//   parts                first, count (corners), name, color (linear), texture (an index into textures, or -1), alpha
//                        ("opaque", "mask", "blend"), cutoff, twoSided
//   textures             mediaType, and bytes()

import { multiply, transformPoint } from "./math.js";

// Reads the arrays of a skin from its block of bytes.
export function unpackSkin(skin, bytes) {
  let at = 0;
  const take = (Kind, count) => {
    const array = new Kind(bytes.buffer, bytes.byteOffset + at, count);
    at += array.byteLength;
    return array;
  };
  const { vertices, corners, bones, morphs } = skin;
  const moved = morphs.reduce((sum, { count }) => sum + count, 0);
  return {
    ...skin,
    positions: take(Float32Array, 3 * vertices),
    coords: take(Float32Array, 2 * vertices),
    offsets: take(Float32Array, 16 * bones.length),
    weights: take(Uint16Array, 4 * vertices),
    joints: take(Uint16Array, 4 * vertices),
    indices: take(Uint32Array, corners),
    morphIds: take(Uint32Array, moved),
    morphOffsets: take(Int16Array, 3 * moved),
    normals: take(Int8Array, 4 * vertices),
    morphNormals: take(Int8Array, 3 * moved),
  };
}

const NORMAL_STEPS = 63;

// Moves the vertices as the sliders with these weights require. Increments `changes`, so that a renderer notices the
// change.
export function morphSkin(skin, weights) {
  skin.atRest ??= { positions: skin.positions.slice(), normals: skin.normals.slice() };
  const { positions, atRest, morphIds, morphOffsets, morphNormals } = skin;
  positions.set(atRest.positions);
  const normals = Float32Array.from(atRest.normals, (value) => value / 127);
  let first = 0;
  skin.morphs.forEach(({ weight, count, step }, slider) => {
    const by = weights[slider] - weight;
    for (let i = by ? first : first + count; i < first + count; i++) {
      for (let axis = 0; axis < 3; axis++) {
        positions[3 * morphIds[i] + axis] += by * step * morphOffsets[3 * i + axis];
        normals[4 * morphIds[i] + axis] += (by / NORMAL_STEPS) * morphNormals[3 * i + axis];
      }
    }
    first += count;
  });
  for (let at = 0; at < normals.length; at += 4) {
    const length = Math.hypot(normals[at], normals[at + 1], normals[at + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) skin.normals[at + axis] = Math.round((127 * normals[at + axis]) / length);
  }
  skin.weightsNow = weights;
  skin.changes = (skin.changes ?? 0) + 1;
}

// Applies the animated morph weights of the files, except to skins whose sliders the user has moved.
export function playMorphs(clips) {
  for (const clip of clips) {
    const { skin, morphs, tick } = clip;
    if (!morphs || skin.isHeld || (skin.moved?.clip === clip && skin.moved.tick === tick)) continue;
    skin.moved = { clip, tick };
    morphSkin(skin, clip.morphWeights(tick));
  }
}

// The current weights of the sliders.
export const morphWeights = (skin) => skin.weightsNow ?? skin.morphs.map(({ weight }) => weight);

// The matrices from the mesh to the page in the current pose, one for each bone.
export function boneMatrices(skin, clip) {
  const matrices = new Float32Array(16 * skin.bones.length);
  const toPage = clip.pageMatrix;
  const worlds = new Map();
  skin.bones.forEach((node, bone) => {
    if (!worlds.has(node)) worlds.set(node, multiply(toPage, clip.world[node]));
    matrices.set(multiply(worlds.get(node), skin.offsets.subarray(16 * bone, 16 * bone + 16)), 16 * bone);
  });
  return matrices;
}

// The number of vertices that are enough to bound a skin.
const MOST_VERTICES = 3000;

// The positions of the skin's vertices on the page, in the current pose.
export function verticesOnPage(skin, clip) {
  const matrices = boneMatrices(skin, clip);
  const step = Math.ceil(skin.vertices / MOST_VERTICES);
  const places = [];
  for (let vertex = 0; vertex < skin.vertices; vertex += step) {
    const at = skin.positions.subarray(3 * vertex, 3 * vertex + 3);
    const place = [0, 0, 0];
    for (let i = 4 * vertex; i < 4 * vertex + 4; i++) {
      const weight = skin.weights[i] / 65535;
      if (weight === 0) continue;
      const moved = transformPoint(matrices.subarray(16 * skin.joints[i], 16 * skin.joints[i] + 16), at);
      for (let axis = 0; axis < 3; axis++) place[axis] += weight * moved[axis];
    }
    places.push(place);
  }
  return places;
}
