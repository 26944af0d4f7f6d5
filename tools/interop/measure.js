// Measures the error of a file against its source: every joint and End Site in every frame of the source, in double
// precision. It uses no code of mocap: bvh.js reads the source, and playback.js the file.

import { placesInRow, readBvh } from "./bvh.js";
import { open } from "./playback.js";

/**
 * The expected positions of a written file, frame by frame: the positions of the source in metres with Y up.
 *
 * @param {(place: number[]) => number[]} change see `stepsOf` in compare.js
 */
export function placesOfSource(path, change) {
  const motion = readBvh(path);
  return {
    names: motion.joints.map(({ name }) => name),
    frameTime: motion.frameTime,
    frames: motion.rows.map((row) => placesInRow(motion, row).map(change)),
  };
}

/** The ways in which clients read a file. The way with the larger error counts. */
const READINGS = ["unchanged", "normalised"];

/**
 * The largest distance of a joint from its expected position, and the root mean square of all distances, in metres.
 *
 * @param {string} path
 * @param {ReturnType<typeof placesOfSource>} source
 */
export async function errorsOf(path, { names, frameTime, frames }) {
  const { indexOf, placesAt } = await open(path);
  const nodes = names.map((name) => indexOf.get(name));
  const missing = names.filter((_, joint) => nodes[joint] === undefined);
  if (missing.length > 0) throw new Error(`${path}: no node is called ${missing.join(", ")}`);
  const errors = READINGS.map((reading) => {
    let [most, squares] = [0, 0];
    frames.forEach((expected, frame) => {
      const places = placesAt(frame * frameTime, reading);
      expected.forEach((place, joint) => {
        const distance = Math.hypot(...place.map((value, axis) => value - places[nodes[joint]][axis]));
        if (!(distance <= most)) most = distance;
        squares += distance * distance;
      });
    });
    return { most, rms: Math.sqrt(squares / (frames.length * names.length)) };
  });
  return { most: Math.max(...errors.map(({ most }) => most)), rms: Math.max(...errors.map(({ rms }) => rms)) };
}
