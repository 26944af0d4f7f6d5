// Writes NumPy's files: .npy for an array, .npz for several arrays.
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html

import { zipOf } from "./archive.js";

/** The header is padded to a multiple of this number of bytes. */
const ALIGNMENT = 64;
const MAGIC = [0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0];

function npyOf(kind, shape, values) {
  const tuple = shape.length === 1 ? `(${shape[0]},)` : `(${shape.join(", ")})`;
  const dictionary = `{'descr': '${kind}', 'fortran_order': False, 'shape': ${tuple}, }`;
  const room = ALIGNMENT * Math.ceil((MAGIC.length + 2 + dictionary.length + 1) / ALIGNMENT) - MAGIC.length - 2;
  const header = new TextEncoder().encode(`${dictionary.padEnd(room - 1)}\n`);
  const bytes = new Uint8Array(MAGIC.length + 2 + room + values.byteLength);
  bytes.set([...MAGIC, room & 255, room >> 8]);
  bytes.set(header, MAGIC.length + 2);
  bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), MAGIC.length + 2 + room);
  return bytes;
}

/** Encodes texts for NumPy: 32-bit characters, each text padded to the length of the longest. */
function textsOf(texts) {
  const letters = texts.map((text) => Array.from(text, (letter) => letter.codePointAt(0)));
  const longest = Math.max(1, ...letters.map(({ length }) => length));
  const values = new Uint32Array(longest * texts.length);
  letters.forEach((codes, index) => values.set(codes, longest * index));
  return npyOf(`<U${longest}`, [texts.length], values);
}

/** The motion of a robot, with the arrays that `mocap retarget` writes. */
export function npzOfRobot({ fps, frames, joints, contacts, rootPositions, rootRotations, positions }) {
  const arrays = {
    root_pos: npyOf("<f8", [frames, 3], rootPositions),
    root_rot: npyOf("<f8", [frames, 4], rootRotations),
    dof_pos: npyOf("<f8", [frames, joints.length], positions),
    fps: npyOf("<f8", [], Float64Array.of(fps)),
    dof_names: textsOf(joints.map(({ name }) => name)),
    contacts: npyOf("|b1", [frames, 2], Uint8Array.from(contacts.flat(), Number)),
  };
  return zipOf(Object.entries(arrays).map(([name, bytes]) => ({ name: `${name}.npy`, bytes })));
}
