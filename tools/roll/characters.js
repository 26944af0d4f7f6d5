// Writes a character in the style of another program: with other names, joint frames, armatures and rest poses, but the
// same body.

import { readFileSync } from "node:fs";

import { poseAt, readGltf } from "./gltf.js";
import { aboutAxis, add, angle, cross, dot, identity, inverse, length, multiply, normalize, random, randomRotation, rotate, scale, sub } from "./math.js";
import { AXES } from "./measure.js";
import { NAMES, named } from "./variants.js";

const pick = (next, list) => list[Math.floor(next() * list.length)];

/** `parent` is -1 for nodes without a parent. */
const kidsOf = (parents, index) => parents.flatMap((parent, child) => (parent === index ? [child] : []));

/** Lowers the arms by an angle in radians: all nodes below an upper arm turn about its joint. */
function lowered({ places, rotations }, parents, bones, facing, radians) {
  const moved = { places: [...places], rotations: [...rotations] };
  for (const [side, sign] of [["left", -1], ["right", 1]]) {
    const arm = bones[`${side}UpperArm`];
    const turn = aboutAxis(AXES[facing], sign * radians);
    const open = [arm];
    while (open.length > 0) {
      const node = open.pop();
      moved.places[node] = add(places[arm], rotate(turn, sub(places[node], places[arm])));
      moved.rotations[node] = multiply(turn, rotations[node]);
      open.push(...kidsOf(parents, node));
    }
  }
  return moved;
}

/** Frames of joints: their axes in the bone, as rotations from the new axes to the old. */
function framesOf(kind, { places, rotations }, parents, bones, next) {
  const right = new Set(Object.entries(bones).filter(([bone]) => bone.startsWith("right")).map(([, joint]) => joint));
  return parents.map((_, node) => {
    if (kind === "random") return randomRotation(next);
    const axis = { "+X": [1, 0, 0], "+Y": [0, 1, 0], "+Z": [0, 0, 1] }[kind.slice(0, 2)];
    if (kind === "identity") return inverse(rotations[node]);
    const child = axis && kidsOf(parents, node).find((child) => length(sub(places[child], places[node])) > 1e-4);
    if (child === undefined) return identity;
    const along = normalize(rotate(inverse(rotations[node]), sub(places[child], places[node])));
    const from = kind.endsWith("mirrored") && right.has(node) ? scale(axis, -1) : axis;
    const about = cross(from, along);
    return length(about) > 1e-6 ? aboutAxis(about, Math.atan2(length(about), dot(from, along))) : identity;
  });
}

/**
 * A character by a seed: `{ text, how, scene, rest, bones, facing }`. `rest` has the joints of the original upright
 * pose, independent of the armature.
 */
export function characterVariant(character, seed) {
  const next = random(seed);
  const json = JSON.parse(readFileSync(character.path, "utf8"));
  const { parents } = readGltf(character.path);
  const how = [];
  let stands = poseAt({ nodes: json.nodes, parents, tracks: [] });
  const lower = pick(next, [0, 0, 0.5, 0.8, 1.2]);
  const isTPose = angle(sub(stands.places[character.bones.leftHand], stands.places[character.bones.leftUpperArm]), [0, -1, 0]) > 75;
  if (isTPose && lower > 0) {
    stands = lowered(stands, parents, character.bones, character.facing, lower);
    how.push(`arms ${Math.round((lower * 180) / Math.PI)} down`);
  }
  const kind = pick(next, ["as they are", "identity", "random", "+X", "+X mirrored", "+Y", "+Y mirrored", "+Z"]);
  const frames = framesOf(kind, stands, parents, character.bones, next);
  const rest = { places: stands.places, rotations: stands.rotations.map((rotation, node) => multiply(rotation, frames[node])) };
  const system = pick(next, Object.keys(NAMES).filter((name) => name !== "numbers"));
  const joints = named(json.nodes.map(({ name }) => ({ name })), character.bones, system);
  how.push(system, `frames ${kind}`);
  const heading = pick(next, [0, 0, 0.5, 1, -0.5, 0.2]);
  const tilt = pick(next, [0, 0, 0, 10, 33, 90]);
  const about = pick(next, [[1, 0, 0], [0, 0, 1]]);
  const size = pick(next, [1, 1, 0.01, 100]);
  how.push(`heading ${180 * heading}`, `tilt ${tilt} about ${about}`, `armature ${size}`);
  const isArmature = (index) => parents[index] < 0;
  const root = json.nodes.length;
  // Nodes in the world of the upright figure, each below its parent. Only the armature has a scale.
  const nodes = json.nodes.map(({ children }, index) => {
    const above = parents[index] < 0 ? { place: [0, 0, 0], rotation: identity } : { place: rest.places[parents[index]], rotation: rest.rotations[parents[index]] };
    const node = {
      name: joints[index].name,
      translation: scale(rotate(inverse(above.rotation), sub(rest.places[index], above.place)), 1 / size),
      rotation: multiply(inverse(above.rotation), rest.rotations[index]),
    };
    return children ? { ...node, children } : node;
  });
  const armature = multiply(aboutAxis(about, (tilt * Math.PI) / 180), aboutAxis([0, 1, 0], Math.PI * heading));
  nodes.push({ name: "Armature", rotation: armature, scale: [size, size, size], children: nodes.flatMap((_, index) => (isArmature(index) ? [index] : [])) });
  const made = { asset: { version: "2.0", generator: "tools/roll" }, scene: 0, scenes: [{ nodes: [root] }], nodes, skins: [{ joints: json.skins[0].joints }] };
  const turned = aboutAxis([0, 1, 0], Math.PI * heading);
  return {
    text: JSON.stringify(made),
    how: how.join(", "),
    character: {
      ...character,
      name: `${character.name} (${how.join(", ")})`,
      parents: [...parents.map((parent) => (parent < 0 ? root : parent)), -1],
      rest: {
        places: [...rest.places.map((place) => rotate(turned, place)), [0, 0, 0]],
        rotations: [...rest.rotations.map((rotation) => multiply(turned, rotation)), turned],
      },
      facing: rotate(turned, AXES[character.facing]),
    },
  };
}
