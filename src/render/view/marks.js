// Shows ground contacts of a clip, and the angles between its limbs and another clip's limbs.

import { byId, css, make } from "./dom.js";
import { BONE_SIDES, ERRORS, WORST, errorColor } from "./colors.js";

// Whether a point of a foot is at rest at a tick.
export function isAtRest({ intervals }, tick) {
  let [low, high] = [0, intervals.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (intervals[middle][1] < tick) low = middle + 1;
    else high = middle;
  }
  return low < intervals.length && intervals[low][0] <= tick;
}

// Draws the contacts of a clip as bars below the time line, the left side above the right side. `from` and `to` are the
// ends of the time line.
export function drawContacts(canvas, clip, [from, to], isShown) {
  const contacts = isShown ? clip.contacts : [];
  canvas.hidden = !contacts.length || to <= from;
  if (canvas.hidden) return;
  const ratio = Math.min(2, devicePixelRatio || 1);
  Object.assign(canvas, { width: Math.round(canvas.clientWidth * ratio), height: Math.round(canvas.clientHeight * ratio) });
  const pen = canvas.getContext("2d");
  const tick = canvas.width / ((to - from) * clip.ticksPerSecond);
  const start = from * clip.ticksPerSecond;
  for (const { bone, intervals } of contacts) {
    const isLeft = bone.startsWith("left");
    pen.fillStyle = css(isLeft ? BONE_SIDES.left : BONE_SIDES.right);
    for (const [first, last] of intervals) {
      pen.fillRect((first - start) * tick, isLeft ? 0 : canvas.height / 2 + 0.5, Math.max(1, (last - first) * tick), canvas.height / 2 - 0.5);
    }
  }
}

// The angle of the limb that starts at a node, in degrees; null if the limb is not compared.
export function limbError({ limbs, nodes, tick }, id) {
  if (!limbs) return null;
  const limb = limbOf({ limbs, nodes }, id);
  return limb < 0 ? null : limbs.angles[limb * limbs.frames + Math.min(limbs.frames - 1, Math.round(tick))] * limbs.step;
}

// The index of the compared limb of a node, or -1. The limb starts at the node, or at its nearest ancestor with a
// humanoid bone. If this bone starts no compared limb, the index is -1.
export function limbOf({ limbs, nodes }, id) {
  let above = id;
  while (above >= 0 && !nodes[above].bone && !limbs.nodes.includes(above)) above = nodes[above].parent;
  return limbs.nodes.indexOf(above);
}

// The angles of a limb in all frames, in degrees.
export const limbAngles = ({ limbs }, limb) =>
  Float64Array.from(limbs.angles.subarray(limb * limbs.frames, (limb + 1) * limbs.frames), (steps) => steps * limbs.step);

function entry(name, color) {
  const swatch = make("span", { class: "swatch", "aria-hidden": "true" });
  swatch.style.background = css(color);
  return make("span", {}, swatch, name);
}

// Explains the colours: the angles of limbs, or the sides of bones.
export function showLegend({ clips, errors, bones }, hasSkeleton) {
  const limbs = errors && clips.find((clip) => clip.limbs)?.limbs;
  const legend = byId("bone-legend");
  legend.hidden = !limbs && (!bones || !hasSkeleton || !clips.some((clip) => clip.humanoid));
  if (limbs) {
    const steps = [0, 0.5, 1].map((share) => entry(`${WORST * share}°${share === 1 ? " or more" : ""}`, errorColor(WORST * share)));
    legend.replaceChildren(make("span", {}, "limbs against the source:"), ...steps, entry("not compared", ERRORS.none),
      make("span", {}, `mean ${limbs.mean.toFixed(1)}°, at most ${limbs.largest.toFixed(1)}°`));
  } else {
    legend.replaceChildren(entry("left", BONE_SIDES.left), entry("right", BONE_SIDES.right),
      entry("middle", BONE_SIDES.middle), entry("no bone", ERRORS.none), make("span", {}, "greyer: less sure"));
  }
}
