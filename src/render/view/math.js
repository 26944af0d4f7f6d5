// Vectors are [x, y, z] and quaternions [x, y, z, w]. Matrices are 16 numbers, column by column, and multiply column
// vectors.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const normalize = (a) => scale(a, 1 / (length(a) || 1));
// The lowest and the highest corner of the bounding box of points. Without points, the box is the origin.
export function boxAround(points) {
  if (!points.length) return [[0, 0, 0], [0, 0, 0]];
  const low = [0, 1, 2].map((axis) => points.reduce((least, point) => Math.min(least, point[axis]), Infinity));
  const high = [0, 1, 2].map((axis) => points.reduce((most, point) => Math.max(most, point[axis]), -Infinity));
  return [low, high];
}
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

// Spherical linear interpolation along the shorter arc from a to b.
export function slerp(a, b, share) {
  let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = cosine < 0 ? -1 : 1;
  cosine *= sign;
  let [from, to] = [1 - share, share];
  if (cosine < 0.9995) {
    const angle = Math.acos(cosine);
    [from, to] = [Math.sin(from * angle) / Math.sin(angle), Math.sin(to * angle) / Math.sin(angle)];
  }
  const mixed = [0, 1, 2, 3].map((i) => from * a[i] + to * sign * b[i]);
  const size = Math.hypot(...mixed) || 1;
  return mixed.map((value) => value / size);
}

// The matrix translation x rotation x scale.
export function compose(t, q, s) {
  const [x, y, z, w] = q;
  return [
    (1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0,
    2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z + x * w) * s[1], 0,
    2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0,
    t[0], t[1], t[2], 1,
  ];
}

export function multiply(a, b) {
  const out = new Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

export const transformPoint = (m, p) => [0, 1, 2].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);

// The position on the screen, from -1 to 1 in x and y. The last number is the distance from the camera.
export function project(m, p) {
  const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
  const [x, y] = transformPoint(m, p);
  return [x / w, y / w, w];
}

// The inverse of the rotation and scale of a matrix, without translation.
export function inverseLinear(m) {
  const [x, y, z] = [0, 4, 8].map((start) => m.slice(start, start + 3));
  const rows = [cross(y, z), cross(z, x), cross(x, y)].map((row, _, [first]) => scale(row, 1 / dot(x, first)));
  return [0, 1, 2].flatMap((column) => [...rows.map((row) => row[column]), 0]).concat([0, 0, 0, 1]);
}

// The rotation R1 R2 R3 by angles in degrees about the axes of `order` (0 for x, 1 for y, 2 for z).
export function rotationOf(angles, order) {
  return angles.reduce((rotation, angle, i) => {
    const turn = [0, 0, 0, Math.cos((angle * Math.PI) / 360)];
    turn[order[i]] = Math.sin((angle * Math.PI) / 360);
    return quaternionProduct(rotation, turn);
  }, [0, 0, 0, 1]);
}

export const quaternionProduct = ([a, b, c, d], [x, y, z, w]) => [
  d * x + a * w + b * z - c * y, d * y - a * z + b * w + c * x, d * z + a * y - b * x + c * w, d * w - a * x - b * y - c * z,
];

// The angles in degrees, for R = R1 R2 R3 about the axes of `order` (0 for x, 1 for y, 2 for z).
export const eulerAngles = (q, order) => matrixAngles(compose([0, 0, 0], q, [1, 1, 1]), order);

// The angles of a matrix, which may include a scale.
export function matrixAngles(m, order) {
  const sizes = [0, 4, 8].map((start) => length(m.slice(start, start + 3)) || 1);
  const at = (row, column) => m[4 * column + row] / sizes[column];
  const [i, j, k] = order;
  const sign = (j - i + 3) % 3 === 1 ? 1 : -1;
  const sine = clamp(sign * at(i, k), -1, 1);
  const straight = Math.abs(sine) < 0.9999999;
  const first = straight ? Math.atan2(-sign * at(j, k), at(k, k)) : Math.atan2(sign * at(k, j), at(j, j));
  const third = straight ? Math.atan2(-sign * at(i, j), at(i, i)) : 0;
  return [first, Math.asin(sine), third].map((angle) => (angle * 180) / Math.PI);
}

// Of all angles of the same rotation, the angles nearest to the angles of the previous tick.
export function nearestAngles(before, [a, b, c]) {
  const near = [[a, b, c], [a + 180, 180 - b, c + 180]].map((angles) =>
    angles.map((angle, i) => angle - 360 * Math.round((angle - before[i]) / 360)));
  const distance = (angles) => angles.reduce((sum, angle, i) => sum + Math.abs(angle - before[i]), 0);
  return distance(near[1]) < distance(near[0]) ? near[1] : near[0];
}
