// Converts BVH to GLB with a separate, small module. The types are in bvh.d.ts.

import { MocapError, bytesOf } from "./error.js";
import { compile } from "./load.js";

/** A function from the bytes or the text of a BVH file to the bytes of a GLB. */
export async function loadBvh(source) {
  const module = await compile(source, () => new URL("mocap_bvh.wasm", import.meta.url), "mocap_bvh.wasm");
  let exports = new WebAssembly.Instance(module, {}).exports;

  return (file, { skeletonMesh = true } = {}) => {
    const bytes = bytesOf(file);
    const address = exports.mocap_bvh_input(bytes.length) >>> 0;
    if (!address) throw new MocapError({ code: "out-of-memory", message: `there is not enough memory for the ${bytes.length} bytes of the file` });
    new Uint8Array(exports.memory.buffer, address, bytes.length).set(bytes);
    let failed;
    try {
      failed = exports.mocap_bvh_to_glb(skeletonMesh ? 1 : 0);
    } catch {
      // After a trap the state of an instance is undefined.
      exports = new WebAssembly.Instance(module, {}).exports;
      throw new MocapError({ code: "out-of-memory", message: "the file could not be converted: most likely there is not enough memory for it" });
    }
    const answer = new Uint8Array(exports.memory.buffer, exports.mocap_bvh_output() >>> 0, exports.mocap_bvh_output_length()).slice();
    if (failed) throw new MocapError(JSON.parse(new TextDecoder().decode(answer)));
    return answer;
  };
}
