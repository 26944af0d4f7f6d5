// Errors, and the conversion of input bytes. The types are in index.d.ts.

/** An error of a file, an option or the memory. */
export class MocapError extends Error {
  constructor(finding, warnings = []) {
    const { code, message, file, location, pointer, joint, expected, found, help } = finding;
    const place = [file, location?.line, location?.column].filter((part) => part !== undefined).join(":");
    super(place ? `${place}: ${message}` : message);
    this.name = "MocapError";
    Object.assign(this, { code, reason: message, file, pointer, joint: joint ?? undefined });
    Object.assign(this, { expected: expected ?? undefined, found: found ?? undefined, help: help ?? undefined });
    this.line = location?.line;
    this.column = location?.column;
    this.length = location?.length;
    this.text = location?.text;
    this.warnings = warnings.map(flat);
  }
}

/** A diagnostic whose location fields are moved to the top level. */
export function flat({ location, ...diagnostic }) {
  return { ...diagnostic, line: location?.line, column: location?.column, length: location?.length, text: location?.text };
}

export function bytesOf(data) {
  if (typeof data === "string") return new TextEncoder().encode(data);
  if (data instanceof ArrayBuffer) return new Uint8Array(data);
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  throw new TypeError("the bytes of a file are a Uint8Array, an ArrayBuffer or a string");
}
