// Programs from npm that make .glb files smaller.

import { execFileSync } from "node:child_process";
import { fileURLToPath } from "node:url";

const PROGRAMS = fileURLToPath(new URL("node_modules/.bin/", import.meta.url));

const run = (program, args) => execFileSync(`${PROGRAMS}${program}`, args, { stdio: ["ignore", "pipe", "pipe"] });

/** `-kn` keeps the names of the nodes. Without names, gltfpack removes nodes that it does not need for drawing. */
const gltfpack = (...options) => ({
  name: ["gltfpack -kn", ...options].join(" "),
  pack: (input, output) => run("gltfpack", ["-kn", ...options, "-i", input, "-o", output]),
});

const gltfTransform = (...command) => ({
  name: ["gltf-transform", ...command].join(" "),
  pack: (input, output) => run("gltf-transform", [command[0], input, output, ...command.slice(1)]),
});

/** The packer that keeps every key at its time, in the extension that most clients know. mocap is compared with it. */
export const YARDSTICK = gltfpack("-cc", "-af", "0");

/** @type {{ name: string, pack: (input: string, output: string) => void }[]} */
export const PACKERS = [
  gltfpack(),
  gltfpack("-cc"),
  gltfpack("-c", "-af", "0"),
  YARDSTICK,
  gltfpack("-cc", "-af", "0", "-ce", "khr"),
  gltfTransform("resample"),
  gltfTransform("meshopt"),
  gltfTransform("optimize"),
];
