// Compares the ratios of body lengths in the fixtures with the table by which mocap guesses bones.

import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { readBvh, restOf } from "../roll/bvh.js";
import { poseAt, readGltf } from "../roll/gltf.js";
import { length, sub } from "../roll/math.js";

const TOP = join(dirname(fileURLToPath(import.meta.url)), "../..");
const { files } = JSON.parse(readFileSync(join(TOP, "fixtures/skeletons/truth.json"), "utf8"));

/** The names, parents and rest positions of a file's nodes. */
function skeleton(path) {
  if (path.endsWith(".bvh")) {
    const motion = readBvh(path);
    const { joints } = motion;
    return { names: joints.map(({ name }) => name), parents: joints.map(({ parent }) => parent), places: restOf(motion).places };
  }
  if (!/\.(gltf|glb|vrm)$/.test(path)) return undefined;
  const scene = readGltf(path);
  return { names: scene.names, parents: scene.parents, places: poseAt(scene).places };
}

/** The length of the path between two nodes through the tree. */
function between({ parents, places }, from, to) {
  const above = (node) => {
    const all = [];
    for (let at = node; at >= 0; at = parents[at]) all.push(at);
    return all;
  };
  const [up, down] = [above(from), above(to)];
  const top = up.find((node) => down.includes(node));
  const sum = (nodes) => {
    const path = nodes.slice(0, nodes.indexOf(top) + 1);
    return path.slice(1).reduce((all, node, at) => all + length(sub(places[path[at]], places[node])), 0);
  };
  return sum(up) + sum(down);
}

/** The length of the longest chain below a node. */
function reach({ parents, places }, node) {
  const below = parents.flatMap((parent, child) => (parent === node ? [child] : []));
  const each = below.map((child) => length(sub(places[node], places[child])) + reach({ parents, places }, child));
  return Math.max(0, ...each);
}

/** The ratios of one skeleton, by the words of the table. */
function ratios(found, map) {
  const node = (bone) => found.names.indexOf(map[bone] ?? "");
  const path = (from, to) => (node(from) >= 0 && node(to) >= 0 ? between(found, node(from), node(to)) : NaN);
  const behind = (bone) => (node(bone) >= 0 ? reach(found, node(bone)) : NaN);
  const all = [];
  const legs = [];
  for (const side of ["left", "right"]) {
    const bone = (name) => `${side}${name}`;
    const [thigh, shin] = [path(bone("UpperLeg"), bone("LowerLeg")), path(bone("LowerLeg"), bone("Foot"))];
    const [upper, fore] = [path(bone("UpperArm"), bone("LowerArm")), path(bone("LowerArm"), bone("Hand"))];
    legs.push(thigh + shin);
    all.push(["thigh to shin", thigh / shin]);
    all.push(["hips to hip joint, to thigh", path("hips", bone("UpperLeg")) / thigh]);
    all.push(["foot to shin", behind(bone("Foot")) / shin]);
    all.push(["ankle to toes, to shin", path(bone("Foot"), bone("Toes")) / shin]);
    all.push(["upper arm to forearm", upper / fore]);
    all.push(["hand to forearm", behind(bone("Hand")) / fore]);
    all.push(["collar bone to upper arm", path(bone("Shoulder"), bone("UpperArm")) / upper]);
    all.push(["arm to leg", (upper + fore) / (thigh + shin)]);
  }
  const leg = (legs[0] + legs[1]) / 2;
  const top = ["upperChest", "chest", "spine"].find((bone) => node(bone) >= 0);
  all.push(["hips to shoulders, to leg", path("hips", top) / leg]);
  all.push(["hips to head, to leg", path("hips", "head") / leg]);
  all.push(["head to its tip, to leg", behind("head") / leg]);
  all.push(["neck to head, to leg", path("neck", "head") / leg]);
  return all.filter(([, ratio]) => Number.isFinite(ratio) && ratio > 0.01);
}

/** From the lower to the upper quartile of a normal distribution, in standard deviations. */
const QUARTILES = 1.349;

const found = new Map();
const seen = new Set();
for (const [file, { humanoid, map }] of Object.entries(files)) {
  if (humanoid === false) continue;
  const read = skeleton(join(TOP, "fixtures", file));
  if (read === undefined) continue;
  const all = ratios(read, map);
  // A skeleton counts once.
  const key = all.map(([, ratio]) => ratio.toFixed(3)).join();
  if (seen.has(key)) continue;
  seen.add(key);
  for (const [row, ratio] of all) found.set(row, [...(found.get(row) ?? []), Math.log(ratio)]);
}

const table = readFileSync(join(TOP, "src/figure/humanoid/tables.rs"), "utf8");
let off = 0;
console.log(`${"ratio".padEnd(30)} in the table         measured             limbs or trunks`);
for (const [, row, mean, spread] of table.matchAll(/Ratio::new\(\s*"([^"]+)",\s*([\d.]+),\s*([\d.]+)\s*\)/g)) {
  const logs = found.get(row);
  if (logs === undefined) {
    console.log(`${row.padEnd(30)} ${mean} spread ${spread}    not measured`);
    continue;
  }
  // Some skeletons have a length of 0, or of ten times a body's length; the median and the quartiles ignore such
  // lengths.
  logs.sort((a, b) => a - b);
  const quantile = (share) => logs[Math.round((logs.length - 1) * share)];
  const middle = quantile(0.5);
  const deviation = (quantile(0.75) - quantile(0.25)) / QUARTILES;
  const isOff = Math.abs(middle - Math.log(mean)) > Number(spread);
  off += isOff;
  const measured = `${Math.exp(middle).toFixed(2)} spread ${deviation.toFixed(2)}`;
  console.log(`${row.padEnd(30)} ${`${mean} spread ${spread}`.padEnd(20)} ${measured.padEnd(20)} ${logs.length}${isOff ? "  off" : ""}`);
}
process.exit(off > 0 ? 1 : 0);
