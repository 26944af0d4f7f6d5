// Compares the small module of the package, which only converts BVH to GLB, with the program.

import assert from "node:assert/strict";
import { readFileSync, statSync } from "node:fs";
import { extname, join } from "node:path";
import { loadBvh } from "./package/bvh.js";
import { MocapError } from "./package/index.js";

export function smallChecks(check, { all, sample, made, written, assertSame, partsOf }) {
  check("same", "the small module writes the GLB of the program, and its errors", async () => {
    const bvhToGlb = await loadBvh();
    for (const path of sample.some(all.filter((path) => extname(path) === ".bvh" && !path.includes("broken")), 6)) {
      const bytes = made(() => bvhToGlb(readFileSync(path)));
      const expected = written(".glb", "convert", "--quiet", path);
      if (bytes === null || expected === null) {
        assertSame(bytes, expected, path);
        continue;
      }
      const [[json, floats], [expectedJson, expectedFloats]] = [partsOf(bytes), partsOf(expected)];
      // Ignore the asset, which has the name and the hash of the file, and the name of the clip, which is the file's.
      const named = ({ asset, animations, ...rest }) => ({ ...rest, animations: animations?.map(({ name, ...animation }) => animation) });
      assert.deepEqual(named(json), named(expectedJson), path);
      assert.deepEqual(floats, expectedFloats, path);
    }
    assert.throws(() => bvhToGlb("HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n"), { code: "invalid-number", line: 3, column: 12 });
    assert.throws(() => bvhToGlb(""), MocapError);
    const { size } = statSync(join(import.meta.dirname, "package/mocap_bvh.wasm"));
    assert.ok(size < statSync(join(import.meta.dirname, "package/mocap.wasm")).size / 6, `${size} bytes`);
  });
}
