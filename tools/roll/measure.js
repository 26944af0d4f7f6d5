// Compares a motion with its retargeted copy on a character: the directions and the roll of limbs, trunk, pelvis,
// shoulders, head and palms. Hand-made maps define the bones of both.
//
// An elbow and a knee are hinges: their axis is perpendicular to both bones. In the source, the positions of shoulder,
// elbow and wrist give the axis in every frame in which the limb is bent. On the character, the rest pose gives the
// axis, because it stands and faces forward: a shin bends back, and a forearm forward. The joints of the character then
// carry the axis. If both axes are equal, the skin bends where the limb bends. If the source has a standing rest pose,
// this pose defines the roll of its bones, and its joints carry the axis in the same way.

import { aboutAxis, across, add, angle, angleAbout, cross, degrees, dot, inverse, length, multiply, normalize, rotate, scale, sub } from "./math.js";

/** The smallest bend of a hinge that shows its axis, in degrees. */
const BENT = 20;
/** The least number of frames with such a bend. */
const FEWEST = 5;
/**
 * A forearm rolls with its elbow if the direction of the elbow's axis in the forearm varies by at most this, in
 * degrees.
 */
const CONSTANT = 10;

const SIDES = ["left", "right"];
const UP = [0, 1, 0];
export const AXES = { "+X": [1, 0, 0], "-X": [-1, 0, 0], "+Y": [0, 1, 0], "-Y": [0, -1, 0], "+Z": [0, 0, 1], "-Z": [0, 0, -1] };

export const LIMBS = SIDES.flatMap((side) => [
  { bone: `${side}UpperArm`, start: `${side}UpperArm`, middle: `${side}LowerArm`, end: `${side}Hand`, bends: 1, isUpper: true },
  { bone: `${side}LowerArm`, start: `${side}UpperArm`, middle: `${side}LowerArm`, end: `${side}Hand`, bends: 1, isUpper: false },
  { bone: `${side}UpperLeg`, start: `${side}UpperLeg`, middle: `${side}LowerLeg`, end: `${side}Foot`, bends: -1, isUpper: true },
  { bone: `${side}LowerLeg`, start: `${side}UpperLeg`, middle: `${side}LowerLeg`, end: `${side}Foot`, bends: -1, isUpper: false },
]);

/**
 * The joints of the bones of a hand-made map, by index. If the names of a figure exchange left and right, so do its
 * joints here.
 */
export function bonesOf({ map, sides }, names) {
  const isExchanged = sides?.names === "opposite";
  const other = (bone) => bone.replace(/^(left|right)/, (side) => (side === "left" ? "right" : "left"));
  const found = Object.entries(map).map(([bone, name]) => [isExchanged ? other(bone) : bone, names.indexOf(name)]);
  const missing = found.filter(([, joint]) => joint < 0);
  if (missing.length > 0) throw new Error(`no joint for ${missing.map(([bone]) => bone).join(", ")}`);
  return Object.fromEntries(found);
}

/** The rotation that brings the up axis of a file to +Y. */
export function upright(up) {
  const from = AXES[up];
  const axis = cross(from, UP);
  if (length(axis) < 1e-9) return dot(from, UP) > 0 ? [0, 0, 0, 1] : [1, 0, 0, 0];
  return aboutAxis(axis, Math.PI / 2);
}

const middle = (places, bones, a, b) => scale(add(places[bones[a]], places[bones[b]]), 0.5);

/** Lines of the body whose directions are compared. */
function linesOf(places, bones) {
  const has = (...names) => names.every((name) => bones[name] !== undefined);
  const way = (from, to) => (has(from, to) ? sub(places[bones[to]], places[bones[from]]) : undefined);
  const shoulders = has("leftUpperArm", "rightUpperArm");
  const top = bones.neck ?? bones.head;
  const limbs = SIDES.flatMap((side) =>
    [
      ["UpperArm", "LowerArm"],
      ["LowerArm", "Hand"],
      ["UpperLeg", "LowerLeg"],
      ["LowerLeg", "Foot"],
    ].map(([from, to]) => [`${side}${from}`, way(`${side}${from}`, `${side}${to}`)]),
  );
  const trunk = top === undefined ? undefined : sub(places[top], middle(places, bones, "leftUpperLeg", "rightUpperLeg"));
  return Object.fromEntries([
    ...limbs,
    ["trunk", trunk],
    ["pelvis", way("rightUpperLeg", "leftUpperLeg")],
    ["shoulders", shoulders ? way("rightUpperArm", "leftUpperArm") : undefined],
    ...SIDES.map((side) => [`${side}Foot`, way(`${side}Foot`, `${side}Toes`)]),
  ].filter(([, line]) => line !== undefined && length(line) > 1e-9));
}

/** The rotation about +Y that aligns the lines of one motion best with the lines of another. */
function headingBetween(from, to) {
  let [sine, cosine] = [0, 0];
  from.forEach((lines, frame) => {
    for (const name of Object.keys(lines).filter((line) => to[frame][line])) {
      const [a, b] = [normalize(lines[name]), normalize(to[frame][name])];
      sine += a[2] * b[0] - a[0] * b[2];
      cosine += a[0] * b[0] + a[2] * b[2];
    }
  });
  return aboutAxis(UP, Math.atan2(sine, cosine));
}

/** The mean of weighted angles in degrees, and the mean deviation from it. */
function meanOf(samples) {
  const sum = (of) => samples.reduce((total, [value, weight]) => total + weight * of((value * Math.PI) / 180), 0);
  const mean = degrees(Math.atan2(sum(Math.sin), sum(Math.cos)));
  const off = (value) => Math.abs(((value - mean + 540) % 360) - 180);
  const weights = samples.reduce((total, [, weight]) => total + weight, 0);
  return { mean, spread: samples.reduce((total, [value, weight]) => total + weight * off(value), 0) / weights };
}

/**
 * Compares poses of the source with those of the target, frame by frame.
 *
 * @param source `{ poses, bones, parents, up, rest, facing }`: `up` as the file has it; `rest` and `facing`, a name or a
 *   direction, in a file whose rest pose stands
 * @param target `{ poses, bones, parents, rest, facing }`: `rest` is its pose at rest, which looks along `facing`, with +Y up
 */
export function compare(source, target) {
  const stand = upright(source.up);
  const stood = source.poses.map(({ places, rotations }) => ({
    places: places.map((place) => rotate(stand, place)),
    rotations: rotations.map((rotation) => multiply(stand, rotation)),
  }));
  const is = target.poses.map(({ places }) => linesOf(places, target.bones));
  const was = stood.map(({ places }) => linesOf(places, source.bones));
  const heading = headingBetween(was, is);
  const lines = {};
  for (const name of Object.keys(was[0] ?? {}).filter((line) => is[0][line])) {
    const angles = was.map((frame, index) => angle(rotate(heading, frame[name] ?? [0, 1, 0]), is[index][name]));
    lines[name] = angles.reduce((total, value) => total + value, 0) / angles.length;
  }
  const stands = source.rest && {
    facing: rotate(stand, AXES[source.facing] ?? source.facing),
    places: source.rest.places.map((place) => rotate(stand, place)),
    rotations: source.rest.rotations.map((rotation) => multiply(stand, rotation)),
  };
  const moved = stood.map(({ places, rotations }) => ({
    places: places.map((place) => rotate(heading, place)),
    rotations: rotations.map((rotation) => multiply(heading, rotation)),
  }));
  const rolls = Object.fromEntries(LIMBS.map((limb) => [limb.bone, rollOf(limb, { ...source, poses: moved, rest: stands }, target)]).filter(([, roll]) => roll !== undefined));
  const palms = SIDES.map((side) => palmOf(side, { ...source, poses: moved }, target)).filter((value) => value !== undefined);
  const limbs = Object.entries(lines).filter(([name]) => /Arm|Leg/.test(name));
  const of = (names) => Math.max(0, ...names.map((name) => lines[name] ?? 0));
  return {
    direction: limbs.reduce((total, [, value]) => total + value, 0) / Math.max(limbs.length, 1),
    roll: Math.max(0, ...Object.values(rolls).map(Math.abs)),
    rolls,
    trunk: of(["trunk", "pelvis", "shoulders"]),
    feet: of(["leftFoot", "rightFoot"]),
    palm: palms.length > 0 ? Math.max(...palms) : undefined,
    head: headOf(target),
    lines,
  };
}

/** Whether knees and elbows are bent in enough frames to show the axes of their hinges. */
export function bends({ poses, bones }) {
  const isShown = ({ start, middle: hinge, end }) => {
    const joints = [start, hinge, end].map((bone) => bones[bone]);
    if (joints.includes(undefined)) return false;
    const bend = ({ places }) => angle(sub(places[joints[1]], places[joints[0]]), sub(places[joints[2]], places[joints[1]]));
    return poses.filter((pose) => bend(pose) > BENT).length >= FEWEST;
  };
  return LIMBS.every(isShown);
}

/** The mean angle in degrees between the roll of a bone of the target and the hinge of the source. */
function rollOf({ bone, start, middle: hinge, end, bends, isUpper }, source, target) {
  const names = [start, hinge, end];
  if ([source, target].some(({ bones }) => names.some((name) => bones[name] === undefined))) return undefined;
  const at = ({ places }, bones, name) => places[bones[name]];
  const way = (pose, bones) => (isUpper ? sub(at(pose, bones, hinge), at(pose, bones, start)) : sub(at(pose, bones, end), at(pose, bones, hinge)));
  const ofRest = ({ rest, bones }, facing) => normalize(cross(way(rest, bones), scale(facing, bends)));
  // If several joints along an upper bone share its twist, the skin at the hinge follows the last joint.
  const jointOf = ({ bones, parents }) => (isUpper ? parents[bones[hinge]] : bones[bone]);
  const carried = (body, axis, pose) => rotate(multiply(pose.rotations[jointOf(body)], inverse(body.rest.rotations[jointOf(body)])), axis);
  const axisAtRest = ofRest(target, AXES[target.facing] ?? target.facing);
  const axisOfSource = source.rest && ofRest(source, source.rest.facing);
  const [samples, inJoint] = [[], []];
  source.poses.forEach((pose, frame) => {
    const moved = target.poses[frame];
    const direction = normalize(way(moved, target.bones));
    const is = carried(target, axisAtRest, moved);
    if (axisOfSource) {
      samples.push([angleAbout(direction, is, carried(source, axisOfSource, pose)), 1]);
      return;
    }
    const upper = normalize(sub(at(pose, source.bones, hinge), at(pose, source.bones, start)));
    const lower = normalize(sub(at(pose, source.bones, end), at(pose, source.bones, hinge)));
    const bend = angle(upper, lower);
    if (bend < BENT || bend > 180 - BENT) return;
    const seen = normalize(cross(upper, lower));
    const weight = Math.sin((bend * Math.PI) / 180);
    samples.push([angleAbout(direction, is, seen), weight]);
    inJoint.push([rotate(inverse(pose.rotations[jointOf(source)]), seen), weight]);
  });
  if (samples.length < (axisOfSource ? 1 : FEWEST)) return undefined;
  const isForearm = !isUpper && bends > 0;
  if (isForearm && spreadOf(inJoint) > CONSTANT) return undefined;
  return meanOf(samples).mean;
}

/** The mean deviation of weighted directions from their mean. */
function spreadOf(samples) {
  const mean = normalize(samples.reduce((sum, [axis, weight]) => add(sum, scale(axis, weight)), [0, 0, 0]));
  const weights = samples.reduce((total, [, weight]) => total + weight, 0);
  return samples.reduce((total, [axis, weight]) => total + weight * angle(axis, mean), 0) / weights;
}

/** The mean angle between the palms of both motions, by the line of the knuckles; undefined without fingers. */
function palmOf(side, source, target) {
  const names = ["Hand", "IndexProximal", "LittleProximal"].map((name) => side + name);
  if ([source, target].some(({ bones }) => names.some((name) => bones[name] === undefined))) return undefined;
  const palm = ({ places }, bones) => {
    const [hand, index, little] = names.map((name) => places[bones[name]]);
    return normalize(cross(sub(index, hand), sub(little, hand)));
  };
  const angles = source.poses.map((pose, frame) => angle(palm(pose, source.bones), palm(target.poses[frame], target.bones)));
  return angles.reduce((sum, value) => sum + value, 0) / angles.length;
}

/**
 * The angle between the mean directions of the face and the chest of the target: no person looks aside all the time.
 */
function headOf({ poses, bones, rest, facing }) {
  if (bones.head === undefined || bones.leftUpperArm === undefined) return undefined;
  let sum = [0, 0, 0];
  for (const pose of poses) {
    const line = linesOf(pose.places, bones);
    const x = normalize(line.shoulders);
    const y = normalize(across(line.trunk, x));
    const z = cross(x, y);
    const face = rotate(multiply(pose.rotations[bones.head], inverse(rest.rotations[bones.head])), AXES[facing] ?? facing);
    sum = add(sum, [dot(face, x), dot(face, y), dot(face, z)]);
  }
  return angle(sum, [0, 0, 1]);
}

/**
 * The mean angles between the rotations of the same bones in two motions of one character, the largest
 * first.
 */
export function difference(one, other, bones) {
  const names = Object.keys(bones).filter((bone) => /Arm|Leg|hips|spine|chest|Chest|neck|head|Hand$|Foot/.test(bone));
  const frames = Math.min(one.length, other.length);
  const lines = (poses) => poses.slice(0, frames).map(({ places }) => linesOf(places, bones));
  const heading = headingBetween(lines(one), lines(other));
  const meanOf = (bone) => {
    let sum = 0;
    for (let frame = 0; frame < frames; frame += 1) {
      const [x, y, z, w] = multiply(inverse(multiply(heading, one[frame].rotations[bones[bone]])), other[frame].rotations[bones[bone]]);
      sum += degrees(2 * Math.atan2(Math.hypot(x, y, z), Math.abs(w)));
    }
    return { bone, degrees: sum / frames };
  };
  return names.map(meanOf).sort((a, b) => b.degrees - a.degrees);
}
