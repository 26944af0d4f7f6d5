// `mocap verify` on the default file of every real fixture: double-precision kinematics of the source against the
// file as the Rust crate `gltf` reads it, at every frame and joint.

import { basename, join } from "node:path";

import { convert, fixtures, mocap, outputName, subfolder } from "../mocap.js";
import { millimetres } from "../compare.js";

/** The largest error allowed in a default file, in metres. */
const MAX_ERROR = 0.00002;

export async function run(results, folder) {
  const outputs = subfolder(folder, "verify");
  let worst = { max_error: 0, file: "none" };
  for (const input of fixtures("real")) {
    await results.guard(basename(input), () => {
      const output = convert(input, join(outputs, outputName(input, ".glb")));
      const verification = JSON.parse(mocap("verify", input, output, "--json", "--max-error", "1000m"));
      const { max_error, missing, joints } = verification;
      results.check(max_error < MAX_ERROR, `${basename(input)}: ${millimetres(max_error)} off`);
      results.check(missing.length === 0, `${basename(input)}: ${missing.length} of ${joints} joints are missing`);
      if (max_error > worst.max_error) worst = { max_error, file: basename(input) };
    });
  }
  results.note(`at most ${millimetres(worst.max_error)} off, in ${worst.file}`);
}
