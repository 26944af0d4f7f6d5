// Measures speeds and accelerations of feet, and how fast they slide in contact, without code of mocap.

import { length, scale, sub } from "../roll/math.js";

const SIDES = ["left", "right"];
const LEGS = SIDES.flatMap((side) => ["UpperLeg", "LowerLeg", "Foot", "Toes"].map((bone) => `${side}${bone}`));

/** A joint of a foot is in contact if its height above its resting level is less than this, in metres, ... */
const HEIGHT = 0.03;
/** ... and slower over the ground than this, in metres a second, ... */
const SLOW = 0.15;
/** ... for this long, in seconds: a swinging foot is slow for a frame where it turns back. */
const LASTS = 0.08;
/** The time around a moment that counts, in seconds: a lock may move an acceleration to the next frame. */
const AROUND = 0.25;
/**
 * Speeds and accelerations below these limits, in m/s and m/s2, are no movement; nor are those below this fraction of
 * the largest.
 */
const STILL = { speed: 0.1, acceleration: 2 };
const OF_FASTEST = 0.25;

/** The leg joints of a figure, with their indices. */
export const jointsOf = (bones) => LEGS.filter((bone) => bones[bone] !== undefined).map((bone) => [bone, bones[bone]]);

/**
 * Compares the feet of three motions: the source, scaled to the target; the target with free feet; and the target with
 * locked feet. A ratio compares a locked joint at one moment with the same free joint around this moment. The result
 * has the worst ratio of any joint and moment, and the largest values of the clip.
 */
export function compare(source, free, lock, seconds) {
  const joints = SIDES.flatMap((side) => [`${side}Foot`, `${side}Toes`]).filter((bone) => free[0][bone]);
  const worst = (of, still) => {
    const rows = joints.map((bone) => {
      const [was, without, is] = [source, free, lock].map((frames) => (frames[0][bone] ? of(frames.map((frame) => frame[bone]), seconds) : [NaN]));
      const around = Math.max(1, Math.round(AROUND / seconds));
      const floor = Math.max(still, OF_FASTEST * Math.max(...without));
      const ratios = is.map((value, frame) => value / Math.max(floor, ...without.slice(Math.max(0, frame - around), frame + around + 1)));
      const ratio = Math.max(...ratios);
      const most = (values) => Math.max(...values);
      return { source: most(was), free: most(without), lock: most(is), ratio, bySource: most(is) / Math.max(most(was), still), bone, frame: ratios.indexOf(ratio) + 1 };
    });
    return rows.reduce((a, b) => (a.ratio >= b.ratio ? a : b));
  };
  return {
    speed: worst(speeds, STILL.speed),
    acceleration: worst(accelerations, STILL.acceleration),
    slide: slides(source, [free, lock], seconds),
  };
}

/** Central differences over two frames. */
function speeds(places, seconds) {
  return places.slice(2).map((place, frame) => length(sub(place, places[frame])) / (2 * seconds));
}

function accelerations(places, seconds) {
  return places.slice(2).map((place, frame) => length(sub(sub(place, scale(places[frame + 1], 2)), scale(places[frame], -1))) / seconds ** 2);
}

/**
 * The mean speed over the ground of feet, in the frames in which the source's feet are in contact. A foot that turns
 * about its ball or its heel does not slide. So only the slowest of its joints that are low in the source counts.
 */
function slides(source, targets, seconds) {
  const sums = [0, 0, 0];
  let contacts = 0;
  const level = Object.fromEntries(["Foot", "Toes"].map((bone) => [bone, levelOf(source, bone)]));
  const over = (frames, bones, frame) => {
    const speeds = bones.map((bone) => {
      const [x, , z] = sub(frames[frame + 1][bone], frames[frame][bone]);
      return Math.hypot(x, z) / seconds;
    });
    return Math.min(Infinity, ...speeds);
  };
  for (const side of SIDES) {
    const low = (frame) => {
      const bones = ["Foot", "Toes"].filter((bone) => source[frame][side + bone]?.[1] < level[bone] + HEIGHT && targets[0][frame][side + bone]);
      return bones.map((bone) => side + bone);
    };
    let run = [];
    for (let frame = 0; frame < source.length; frame += 1) {
      const bones = frame + 1 < source.length ? low(frame) : [];
      if (over(source, bones, Math.min(frame, source.length - 2)) < SLOW) {
        run.push([frame, bones]);
        continue;
      }
      if (run.length * seconds >= LASTS) {
        contacts += run.length;
        for (const [at, joints] of run) [source, ...targets].forEach((frames, index) => (sums[index] += over(frames, joints, at)));
      }
      run = [];
    }
  }
  const [was, free, lock] = sums.map((sum) => sum / Math.max(contacts, 1));
  return { contacts, source: was, free, lock };
}

/** The resting level of a joint of both feet: the fifth percentile of the lower joint. */
function levelOf(frames, bone) {
  const heights = frames.map((frame) => Math.min(...SIDES.map((side) => frame[side + bone]?.[1] ?? Infinity))).sort((a, b) => a - b);
  return heights[Math.floor((heights.length - 1) / 20)];
}
