// Vectors as [x, y, z] and rotations as quaternions [x, y, z, w], in double precision.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const normalize = (a) => scale(a, 1 / (length(a) || 1));
export const across = (a, axis) => sub(a, scale(axis, dot(a, axis)));
export const degrees = (radians) => (radians * 180) / Math.PI;

/** The angle between two directions, in degrees. */
export const angle = (a, b) => degrees(Math.atan2(length(cross(a, b)), dot(a, b)));

/** The angle about `axis` from `a` to `b`, in degrees. */
export const angleAbout = (axis, a, b) => degrees(Math.atan2(dot(cross(a, b), axis), dot(across(a, axis), across(b, axis))));

export const multiply = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
  aw * bw - ax * bx - ay * by - az * bz,
];
export const inverse = ([x, y, z, w]) => [-x, -y, -z, w];
export const identity = [0, 0, 0, 1];

export function rotate([x, y, z, w], v) {
  const u = [x, y, z];
  const t = scale(cross(u, v), 2);
  return add(add(v, scale(t, w)), cross(u, t));
}

export function aboutAxis(axis, radians) {
  return [...scale(normalize(axis), Math.sin(radians / 2)), Math.cos(radians / 2)];
}

export function unit(q) {
  const norm = Math.hypot(...q) || 1;
  return q.map((part) => part / norm);
}

/** The angle between two rotations, in degrees. */
export function between(a, b) {
  const [x, y, z, w] = multiply(inverse(a), b);
  return degrees(2 * Math.atan2(Math.hypot(x, y, z), Math.abs(w)));
}

/** The rotation whose matrix has these columns, which are at right angles and of length 1. */
export function fromColumns(x, y, z) {
  const trace = x[0] + y[1] + z[2];
  if (trace > 0) {
    const s = 2 * Math.sqrt(trace + 1);
    return unit([(y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s, s / 4]);
  }
  if (x[0] > y[1] && x[0] > z[2]) {
    const s = 2 * Math.sqrt(1 + x[0] - y[1] - z[2]);
    return unit([s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s, (y[2] - z[1]) / s]);
  }
  if (y[1] > z[2]) {
    const s = 2 * Math.sqrt(1 + y[1] - x[0] - z[2]);
    return unit([(y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s, (z[0] - x[2]) / s]);
  }
  const s = 2 * Math.sqrt(1 + z[2] - x[0] - y[1]);
  return unit([(z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4, (x[1] - y[0]) / s]);
}

/** Angles in degrees about Z, then Y, then X of the rotated axes, for `CHANNELS 3 Zrotation Yrotation Xrotation`. */
export function eulerZyx(q) {
  const [x, y, z] = [rotate(q, [1, 0, 0]), rotate(q, [0, 1, 0]), rotate(q, [0, 0, 1])];
  const pitch = Math.asin(Math.max(-1, Math.min(1, -x[2])));
  if (Math.abs(x[2]) > 1 - 1e-12) return [degrees(Math.atan2(-y[0], y[1])), degrees(pitch), 0];
  return [degrees(Math.atan2(x[1], x[0])), degrees(pitch), degrees(Math.atan2(y[2], z[2]))];
}

/** Random numbers between 0 and 1, the same in every run (mulberry32). */
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** A uniformly distributed random rotation (K. Shoemake, "Uniform random rotations", Graphics Gems III, 1992). */
export function randomRotation(next) {
  const [a, b, c] = [next(), 2 * Math.PI * next(), 2 * Math.PI * next()];
  return [Math.sqrt(1 - a) * Math.sin(b), Math.sqrt(1 - a) * Math.cos(b), Math.sqrt(a) * Math.sin(c), Math.sqrt(a) * Math.cos(c)];
}
