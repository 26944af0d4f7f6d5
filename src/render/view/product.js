// The separate matrices of the chain from the root to a joint, T = J0 L1 J1 L2 ..., like `Pose::chain` of the library.

import { compose, multiply } from "./math.js";

const IDENTITY = compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]);

// The matrices of a chain in the current pose. Each has letter, index, node, matrix, and the product up to this matrix.
export function chainMatrices(clip, id) {
  const isPart = (node) => node === id || clip.nodes[node].kind !== "group" || clip.locals[node].some((value, i) => value !== IDENTITY[i]);
  const parts = [];
  const push = (letter, index, node, matrix) => {
    const before = parts.at(-1)?.product;
    parts.push({ letter, index, id: node, matrix, product: before ? multiply(before, matrix) : matrix });
  };
  clip.chain(id).filter(isPart).forEach((node, index) => {
    const local = Array.from(clip.locals[node]);
    if (index > 0) push("L", index, node, [...IDENTITY.slice(0, 12), ...local.slice(12)]);
    if (clip.nodes[node].kind === "end_site" && index > 0) return;
    push("J", index, node, index > 0 ? [...local.slice(0, 12), ...IDENTITY.slice(12)] : local);
  });
  return parts;
}
