// Bytes as text: four bytes are five letters, a quarter more; in base64 they are a third more.

// The letters from "(" on. "}" takes the place of "<", which could end an element.
const FIRST = 40;
const LESS_THAN = 60;
const INSTEAD = 125;

/** @param {Uint8Array} bytes */
export function toBase85(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += 4) {
    let number = 0;
    for (let k = 0; k < 4; k++) number = number * 256 + (bytes[at + k] ?? 0);
    const letters = [];
    for (let k = 0; k < 5; k++) {
      const code = FIRST + (number % 85);
      letters.unshift(code === LESS_THAN ? INSTEAD : code);
      number = Math.floor(number / 85);
    }
    // The last bytes, if fewer than four, are one letter more than they are.
    text += String.fromCharCode(...letters.slice(0, bytes.length - at + 1));
  }
  return text;
}

/** @param {string} text */
export function fromBase85(text) {
  const numbers = new DataView(new ArrayBuffer(Math.ceil(text.length / 5) * 4));
  for (let at = 0; at < text.length; at += 5) {
    let number = 0;
    for (let k = at; k < at + 5; k++) {
      const code = k < text.length ? text.charCodeAt(k) : FIRST + 84;
      number = number * 85 + (code === INSTEAD ? LESS_THAN : code) - FIRST;
    }
    numbers.setUint32((at / 5) * 4, number);
  }
  return new Uint8Array(numbers.buffer, 0, Math.floor((text.length * 4) / 5));
}
