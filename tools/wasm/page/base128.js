// Encodes bytes as UTF-8 text: seven bits become a character of one byte, so the text is a seventh longer. Base64 text is a
// third longer.

/** Characters that an HTML element does not preserve (NUL and carriage return), and "<", which could end the element. */
const REPLACED = [0, 13, 60];

// Such a character becomes a character of two bytes: its index in this list, counted from FIRST, and the next seven
// bits. LAST replaces FIRST if no bits follow.
const FIRST = 2;
const LAST = FIRST + REPLACED.length;

/** @param {Uint8Array} bytes */
export function toBase128(bytes) {
  const parts = [];
  let codes = [];
  let held = -1;
  const put = (seven) => {
    const place = held < 0 ? REPLACED.indexOf(seven) : -1;
    if (place >= 0) {
      held = place;
      return;
    }
    codes.push(held < 0 ? seven : ((FIRST + held) << 7) | seven);
    held = -1;
    // Larger batches would exceed the number of arguments of a call.
    if (codes.length === 4096) {
      parts.push(String.fromCharCode(...codes));
      codes = [];
    }
  };
  let bits = 0;
  let count = 0;
  for (const byte of bytes) {
    bits = ((bits << 8) | byte) & 0x7fff;
    for (count += 8; count >= 7; count -= 7) put((bits >> (count - 7)) & 127);
  }
  if (count) put((bits << (7 - count)) & 127);
  if (held >= 0) codes.push((LAST + held) << 7);
  return parts.join("") + String.fromCharCode(...codes);
}

/** @param {string} text */
export function fromBase128(text) {
  // The size if every character has fourteen bits.
  const bytes = new Uint8Array(Math.floor((text.length * 14) / 8));
  let length = 0;
  let bits = 0;
  let count = 0;
  const take = (seven) => {
    bits = ((bits << 7) | seven) & 0x7fff;
    count += 7;
    if (count < 8) return;
    count -= 8;
    bytes[length++] = bits >> count;
  };
  for (let at = 0; at < text.length; at++) {
    const code = text.charCodeAt(at);
    const place = code >> 7;
    if (place) take(REPLACED[place < LAST ? place - FIRST : place - LAST]);
    if (place < LAST) take(code & 127);
  }
  return bytes.slice(0, length);
}
