// Encodes numbers as bytes, for the files of films.

/** The number of bytes in a list of pieces. */
export const bytesOfAll = (parts) => parts.reduce((sum, part) => sum + part.length, 0);

/** A number in `count` bytes, the highest byte first. */
export function bigEndian(number, count) {
  const bytes = new Uint8Array(count);
  for (let at = count - 1, rest = number; at >= 0; at--, rest = Math.floor(rest / 256)) bytes[at] = rest % 256;
  return bytes;
}
