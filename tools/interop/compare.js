// Compares positions of joints: the times, the expected positions, and the errors.

/** The largest error of a joint in a figure of human size, in metres. */
const TOLERANCE = 0.0001;
/** The height up to which this limit holds. In a larger figure, the limit grows with its size. */
const HUMAN_SIZE = 2.5;

/**
 * The compared ticks: both ends, two frames between, and half-way between two frames, where the client interpolates.
 */
export function ticksOf(frames) {
  const last = frames - 1;
  const ticks = [0, Math.floor(last / 3), Math.floor((2 * last) / 3), last];
  if (last >= 2) ticks.push(Math.floor(last / 2) + 0.5);
  return [...new Set(ticks)].sort((a, b) => a - b);
}

/**
 * Makes two functions from the steps that a written file names. One converts a tick of the file to a tick of its
 * source, the other a position in the source to a position in the file. Throws at a step that it cannot repeat.
 */
export function stepsOf(provenance) {
  let ticksBefore = 0;
  let change = (place) => place;
  for (const step of provenance.steps ?? []) {
    if (step.step === "trim") {
      ticksBefore += step.first;
    } else if (step.step === "convert_units") {
      const before = change;
      change = (place) => {
        const [x, y, z] = before(place);
        const turned = step.up === "z" ? [x, z, -y] : [x, y, z];
        return turned.map((value) => value * step.metres_per_unit);
      };
    } else if (step.step === "vrm_humanoid") {
      const before = change;
      const [sine, cosine] = [Math.sin, Math.cos].map((of) => of((step.heading * Math.PI) / 180));
      change = (place) => {
        const [x, y, z] = before(place);
        return [cosine * x + sine * z, y + step.lift, cosine * z - sine * x];
      };
    } else {
      throw new Error(`no way to repeat the step ${step.step}`);
    }
  }
  return { sourceTick: (tick) => tick + ticksBefore, change };
}

/** The largest distance between two lists of positions; NaN if their lengths differ. */
export function largestDistance(places, expected) {
  if (places.length !== expected.length) return NaN;
  let largest = 0;
  places.forEach((place, index) => {
    const distance = Math.hypot(...place.map((value, axis) => value - expected[index][axis]));
    if (!(distance <= largest)) largest = distance;
  });
  return largest;
}

/** The largest allowed error of joints at these positions. */
export function toleranceFor(places) {
  const extents = [0, 1, 2].map((axis) => {
    const values = places.map((place) => place[axis]);
    return Math.max(...values) - Math.min(...values);
  });
  return TOLERANCE * Math.max(1, Math.max(...extents) / HUMAN_SIZE);
}

export const millimetres = (metres) => `${(metres * 1000).toFixed(4)} mm`;
