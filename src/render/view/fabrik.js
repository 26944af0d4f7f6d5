// Inverse kinematics of a chain with any number of bones. The library's `ik::ChainOptions` has the same steps. FABRIK
// (Aristidou and Lasenby, 2011) converges quickly, and the last step is exact.

import { add, clamp, dot, length, normalize, scale, sub } from "./math.js";
import { arc, turned, twoBone } from "./reach.js";

// The tolerance as a fraction of the chain's length, and the largest number of passes.
const [NEAR_ENOUGH, PASSES] = [1e-5, 100];
// The largest remaining distance before the last step, as a fraction of the distance of the goal.
const LEFT_TO_LAST = 0.05;

const away = (a, b) => length(sub(a, b));
const directionOr = (way, other) => (length(way) > 0 ? normalize(way) : other);
const rejected = (way, unit) => sub(way, scale(unit, dot(way, unit)));

// A direction perpendicular to another (Duff and others, 2017). The library computes the same direction.
function orthonormal([x, y, z]) {
  const sign = z < 0 || Object.is(z, -0) ? -1 : 1;
  const a = -1 / (sign + z);
  return [x * y * a, sign + y * y * a, -y];
}

// Moves the end of a chain to a goal. Returns the positions from the first joint to the end. The first joint and the
// lengths of bones stay unchanged. If the goal is out of reach, the chain is straight towards the goal.
export function bentPositions(positions, goal, tolerance = NEAR_ENOUGH) {
  const start = positions[0];
  const lengths = positions.slice(1).map((point, i) => away(positions[i], point));
  const whole = lengths.reduce((sum, bone) => sum + bone, 0);
  const toGoal = sub(goal, start);
  if (!goal.every(Number.isFinite)) return positions;
  if (length(toGoal) >= whole) {
    const way = directionOr(toGoal, [0, 0, 0]);
    return lengths.reduce((points, bone) => [...points, add(points.at(-1), scale(way, bone))], [start]);
  }
  const last = lengths.length;
  const aside = orthonormal(directionOr(toGoal, [1, 0, 0]));
  let points = leaveLine(positions, goal, { lengths, whole, aside, tolerance });
  const isMet = () => away(points[last], goal) <= tolerance && lengths.every((bone, i) => Math.abs(away(points[i], points[i + 1]) - bone) <= 1e-9 * bone);
  for (let pass = 0; pass < PASSES; pass++) {
    if (isMet()) return points;
    const closed = closedPositions(points, goal, tolerance);
    points = closed.points;
    if (closed.isMet) return points;
    points[last] = goal;
    for (let i = last - 1; i >= 0; i--) points[i] = add(points[i + 1], scale(directionOr(sub(points[i], points[i + 1]), aside), lengths[i]));
    points[0] = start;
    for (let i = 0; i < last; i++) points[i + 1] = add(points[i], scale(directionOr(sub(points[i + 1], points[i]), aside), lengths[i]));
  }
  const closed = closedPositions(points, goal, tolerance);
  points = closed.points;
  return closed.isMet || isMet() ? points : placedInTurn(points, lengths, goal, aside);
}

// Moves the joints of a straight chain aside, by a tenth of the length of a bone. Otherwise a chain in line with the
// goal would stay in line.
function leaveLine(positions, goal, { lengths, whole, aside, tolerance }) {
  const start = positions[0];
  const end = positions.at(-1);
  const axis = directionOr(sub(end, start), aside);
  const isStraight = positions.every((point) => length(rejected(sub(point, start), axis)) < 1e-4 * whole);
  if (!isStraight || away(end, goal) <= tolerance) return [...positions];
  return positions.map((point, i) => (i ? add(point, scale(aside, (i % 2 ? 0.1 : -0.1) * lengths[i - 1])) : point));
}

// Places joint after joint, from the first. Each joint stays as near to its previous position as possible while the
// remaining bones can still reach the goal.
function placedInTurn(before, lengths, goal, aside) {
  const points = [...before];
  lengths.forEach((bone, i) => {
    const [here, next] = [points[i], points[i + 1]];
    const after = lengths.slice(i + 1);
    const farthest = after.reduce((sum, other) => sum + other, 0);
    const longest = Math.max(0, ...after);
    const distance = away(here, goal);
    const least = Math.max(2 * longest - farthest, Math.abs(distance - bone));
    const remaining = Math.max(Math.min(away(next, goal), farthest, distance + bone), least);
    // Two circles, about this joint and about the goal, intersect at this distance along the line between the centres.
    const towards = directionOr(sub(goal, here), aside);
    const along = clamp((distance * distance + bone * bone - remaining * remaining) / (2 * distance), -bone, bone) || 0;
    const side = directionOr(rejected(sub(next, here), towards), orthonormal(towards));
    points[i + 1] = add(here, add(scale(towards, along), scale(side, Math.sqrt(Math.max(0, bone * bone - along * along)))));
  });
  return points;
}

// Turns the chain as two rigid parts: the first about the start of the chain, the second about the joint between the
// parts. Of all joints, the one with the smallest turn is chosen.
function closedPositions(points, goal, tolerance) {
  const start = points[0];
  const last = points.length - 1;
  const distance = away(goal, start);
  const open = { points, isMet: false };
  if (last < 2 || away(points[last], goal) > LEFT_TO_LAST * distance) return open;
  const room = (joint) => {
    const [a, b] = [away(points[joint], start), away(points[joint], points[last])];
    return Math.min(a + b - distance, distance - Math.abs(a - b));
  };
  // Among equal turns, the last joint is chosen.
  let joint = 1;
  for (let other = 2; other < last; other++) if (room(other) >= room(joint)) joint = other;
  if (room(joint) < 0) return open;
  const { upper, lower } = twoBone([start, points[joint], points[last]], goal);
  const pivot = points[joint];
  const newPivot = add(start, turned(upper, sub(pivot, start)));
  const moved = points.map((point, i) => (i <= joint ? add(start, turned(upper, sub(point, start))) : add(newPivot, turned(lower, sub(point, pivot)))));
  return { points: moved, isMet: away(moved[last], goal) <= Math.max(tolerance, 1e-6 * distance) };
}

// Turns a chain of joints of a clip, so that the last joint reaches a goal in the file's coordinates.
export function bendChain(clip, joints, goal) {
  const places = joints.map((id) => clip.filePosition(id));
  const whole = places.slice(1).reduce((sum, place, i) => sum + away(places[i], place), 0);
  const bent = bentPositions(places, goal, NEAR_ENOUGH * whole);
  joints.slice(0, -1).forEach((id, i) => {
    const from = sub(clip.filePosition(joints[i + 1]), clip.filePosition(id));
    clip.rotate(id, arc(from, sub(bent[i + 1], clip.filePosition(id)), orthonormal(directionOr(from, [1, 0, 0]))));
  });
}

// The chains that can be dragged by their ends. A chain goes from below the last branch, or from the root, to an end
// effector.
export function chainsOf(nodes, children) {
  const chains = new Map();
  nodes.forEach((node, end) => {
    if (children[end].length || node.kind === "group") return;
    const joints = [end];
    for (let at = node.parent; at >= 0 && children[at].length === 1 && nodes[at].kind !== "group"; at = nodes[at].parent) joints.unshift(at);
    if (joints.length > 1) chains.set(end, joints);
  });
  return chains;
}
