// Matrices of 4 by 4 numbers in double precision, column by column.

/** The product: `a` after `b`. The last row of both is 0 0 0 1. */
export function multiply(a, b) {
  const product = new Array(16).fill(0);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 3; row += 1) {
      let sum = column === 3 ? a[12 + row] : 0;
      for (let k = 0; k < 3; k += 1) sum += a[4 * k + row] * b[4 * column + k];
      product[4 * column + row] = sum;
    }
  }
  product[15] = 1;
  return product;
}

export function fromTranslation([x, y, z]) {
  return [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
}

/** A rotation about an axis, 0 for x, by an angle in radians. */
export function rotation(axis, angle) {
  const [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
  const turn = fromTranslation([0, 0, 0]);
  turn[4 * next + next] = Math.cos(angle);
  turn[4 * next + last] = Math.sin(angle);
  turn[4 * last + next] = -Math.sin(angle);
  turn[4 * last + last] = Math.cos(angle);
  return turn;
}

/** Scale, then rotation, then translation. A quaternion whose length is not 1 stretches. */
export function compose([tx, ty, tz], [x, y, z, w], [sx, sy, sz]) {
  return [
    (1 - 2 * (y * y + z * z)) * sx, 2 * (x * y + w * z) * sx, 2 * (x * z - w * y) * sx, 0,
    2 * (x * y - w * z) * sy, (1 - 2 * (x * x + z * z)) * sy, 2 * (y * z + w * x) * sy, 0,
    2 * (x * z + w * y) * sz, 2 * (y * z - w * x) * sz, (1 - 2 * (x * x + y * y)) * sz, 0,
    tx, ty, tz, 1,
  ];
}
