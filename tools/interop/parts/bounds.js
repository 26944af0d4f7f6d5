// Checks bounds from a tenth of a millimetre to a centimetre in every form: measure.js compares every joint in every
// frame in double precision. mocap must refuse a bound that a form cannot keep.

import { basename, join } from "node:path";

import { millimetres, stepsOf } from "../compare.js";
import { describe } from "../glb.js";
import { errorsOf, placesOfSource } from "../measure.js";
import { convert, outputName, realFixture, subfolder } from "../mocap.js";

const FORMS = ["none", "int16", "meshopt", "meshopt-khr"];
/** In millimetres. */
const BOUNDS = [0.1, 0.5, 1, 10];
/** mocap's error for a bound that a form cannot keep. */
const REFUSAL = "[error-bound]";

/** The real files that bvh.js reads: they have motion, and use no dialect. */
const FILES = [
  "biovision_example1.bvh",
  "blender_two_joints.bvh",
  "cmu_01_01.bvh",
  "cmu_12_01_walk.bvh",
  "cmu_mixed_rotation_orders.bvh",
  "cmu_salsa_poser_names.bvh",
  "hip_knee_ankle_names.bvh",
  "kinect_openni.bvh",
  "leap_hand_end_site_lowercase.bvh",
  "lecture_Test.bvh",
  "makehuman_zombie_walk.bvh",
  "mocopi_jump_six_channels.bvh",
  "motionbuilder_vicon_walk.bvh",
  "perception_neuron_moving_positions.bvh",
  "rokoko_dance.bvh",
  "z_up_dab.bvh",
];

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "bounds");
  for (const [place, form] of FORMS.entries()) {
    let [files, refused, most] = [0, 0, 0];
    const inputs = sample.share(FILES.map(realFixture), place, FORMS.length);
    for (const [row, input] of inputs.entries()) {
      const plain = convert(input, join(outputs, outputName(input, ".glb")), "--mesh", "none");
      const source = placesOfSource(input, stepsOf(describe(plain).provenance).change);
      for (const bound of sample.share(BOUNDS, row, BOUNDS.length)) {
        const name = `${basename(input)}, ${form}, ${bound} mm`;
        await results.guard(name, async () => {
          const output = join(outputs, outputName(input, `.${form}.${bound}mm.glb`));
          try {
            convert(input, output, "--mesh", "none", "--compress", form, "--max-error", `${bound}mm`);
          } catch (error) {
            if (!error.stderr.includes(REFUSAL)) throw error;
            results.check(form !== "none", `${name}: refused, where 32-bit floats can keep it`);
            refused += 1;
            return;
          }
          files += 1;
          const errors = await errorsOf(output, source);
          results.check(errors.most * 1000 <= bound, `${name}: ${millimetres(errors.most)} off`);
          most = Math.max(most, (errors.most * 1000) / bound);
        });
      }
    }
    results.note(`${form}: ${files} files, at most ${most.toFixed(3)} of their bounds off; ${refused} bounds refused`);
  }
}
