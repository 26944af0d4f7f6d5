// Inverse kinematics of an arm or a leg: two bones, solved by the law of cosines, like `ik::two_bone_rotations`.

import { add, clamp, cross, dot, length, normalize, quaternionProduct, scale, sub } from "./math.js";

// The least length of a vector with a known direction, as a fraction of the limb's length.
const NO_DIRECTION = 1e-6;

// Rotates a vector by a quaternion.
export function turned([x, y, z, w], v) {
  const twice = scale(cross([x, y, z], v), 2);
  return add(v, add(scale(twice, w), cross([x, y, z], twice)));
}

// The smallest rotation from one direction to another, about `axis` if they are opposite.
export function arc(from, to, axis) {
  const size = Math.sqrt(dot(from, from) * dot(to, to));
  const w = size + dot(from, to);
  if (!(size > 0)) return [0, 0, 0, 1];
  const q = w <= 1e-12 * size ? [...axis, 0] : [...cross(from, to), w];
  return q.map((value) => value / Math.hypot(...q));
}

const direction = (way, nothing) => (length(way) > nothing ? normalize(way) : null);
const across = (v, unit) => sub(v, scale(unit, dot(v, unit)));

// A direction perpendicular to another direction.
function perpendicular(v) {
  return normalize(cross(v, Math.abs(v[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]));
}

// The world rotations of two bones that move the last of three joints to a goal. The rotation `lower` includes the
// rotation `upper`, and `middle` is the new position of the second joint. If the goal is out of reach, the bones are
// straight towards the goal.
export function twoBone([start, middle, end], goal) {
  const [first, second] = [sub(middle, start), sub(end, middle)];
  const [a, b] = [length(first), length(second)];
  if (!(a + b > 0 && goal.every(Number.isFinite))) return { upper: [0, 0, 0, 1], lower: [0, 0, 0, 1], middle };
  const nothing = NO_DIRECTION * (a + b);
  const old = direction(sub(end, start), nothing) ?? direction(first, 0) ?? direction(second, 0);
  const way = sub(goal, start);
  const towards = direction(way, nothing) ?? old;
  const far = clamp(length(way), Math.abs(a - b), a + b);
  const along = far > nothing ? clamp((far * far + a * a - b * b) / (2 * far), -a, a) : 0;
  const aside = Math.sqrt(Math.max(0, a * a - along * along));
  const turn = arc(old, towards, perpendicular(old));
  const bent = direction(across(first, old), nothing);
  const bend = normalize(across(bent ? turned(turn, bent) : perpendicular(towards), towards));
  const normal = cross(towards, bend);
  const upperWay = add(scale(towards, along), scale(bend, aside));
  const lowerWay = sub(scale(towards, far), upperWay);
  return {
    upper: quaternionProduct(arc(turned(turn, first), upperWay, normal), turn),
    lower: quaternionProduct(arc(turned(turn, second), lowerWay, normal), turn),
    middle: add(start, upperWay),
  };
}

// Turns a limb of three nodes, so that the last node reaches a goal in the file's coordinates, in the current pose.
export function reach(clip, limb, goal) {
  const { upper, lower } = twoBone(limb.map((id) => clip.filePosition(id)), goal);
  clip.rotate(limb[0], upper);
  clip.rotate(limb[1], quaternionProduct(lower, [...scale(upper.slice(0, 3), -1), upper[3]]));
}

// The limbs that can be dragged by a hand or a foot. Maps the last node of a limb to its three nodes.
export function limbsOf(nodes) {
  const limbs = new Map();
  const node = (name) => nodes.findIndex(({ bone }) => bone?.name === name);
  for (const side of ["left", "right"]) {
    for (const names of [["UpperArm", "LowerArm", "Hand"], ["UpperLeg", "LowerLeg", "Foot"]]) {
      const limb = names.map((name) => node(side + name));
      if (limb.every((id) => id >= 0)) limbs.set(limb[2], limb);
    }
  }
  return limbs;
}
