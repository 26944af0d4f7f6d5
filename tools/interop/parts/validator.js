// Runs the Khronos validator on every readable fixture in every form. No message of any severity is allowed, except the
// messages in exceptions.json.

import { readFileSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { basename, dirname, extname, join } from "node:path";

import validator from "gltf-validator";

import { REFUSED, convert, fixtures, outputName, realFixture, subfolder } from "../mocap.js";

const MODES = [
  { name: "default", extension: ".glb", options: [] },
  { name: "beside", extension: ".gltf", options: [] },
  { name: "embedded", extension: ".gltf", options: ["--embed"] },
  { name: "segmented", extension: ".glb", options: ["--mesh", "segmented"] },
  { name: "no-mesh", extension: ".glb", options: ["--mesh", "none"] },
  { name: "keep-constant", extension: ".glb", options: ["--keep-constant"] },
  { name: "root-motion", extension: ".glb", options: ["--root-motion"], isOfRoot: true },
  { name: "resampled", extension: ".glb", options: ["--fps", "30", "--rest", "frame:0", "--in-place"], isOfRoot: true },
];
// Marker files, which have no root.
const POINTS = [".c3d", ".trc"];
const SEVERITIES = ["error", "warning", "info", "hint"];
const EXCEPTIONS = JSON.parse(readFileSync(new URL("../exceptions.json", import.meta.url))).validator;

/** The messages about a file that no exception allows, as text. */
export async function messagesAbout(path, mode) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path)), {
    uri: basename(path),
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(join(dirname(path), decodeURIComponent(uri)))),
  });
  const isAllowed = ({ code, pointer }) =>
    EXCEPTIONS.some(
      (allowed) =>
        allowed.code === code && (allowed.mode ?? mode) === mode && (pointer ?? "").endsWith(allowed.pointer ?? ""),
    );
  return report.issues.messages
    .filter((message) => !isAllowed(message))
    .map((message) => `${SEVERITIES[message.severity]} ${message.code} at ${message.pointer}: ${message.message}`);
}

/** mocap's message about a file that it does not convert; empty if it converts the file. */
function refusalOf(input, folder, options = []) {
  try {
    convert(input, join(folder, "refused.glb"), ...options);
    return "";
  } catch (error) {
    return error.stderr.toString();
  }
}

export async function run(results, folder, sample) {
  const inputs = [...fixtures("real"), ...fixtures("dialects")];
  for (const [place, mode] of MODES.entries()) {
    const outputs = subfolder(folder, `validator/${mode.name}`);
    let files = 0;
    for (const input of sample.share(inputs, place, MODES.length)) {
      await results.guard(`${basename(input)}, ${mode.name}`, async () => {
        if (mode.isOfRoot && POINTS.includes(extname(input))) {
          const refusal = refusalOf(input, folder, mode.options);
          results.check(refusal.includes("[unrepresentable]"), `${basename(input)}, ${mode.name}: ${refusal}`);
          return;
        }
        const output = convert(input, join(outputs, outputName(input, mode.extension)), ...mode.options);
        const messages = await messagesAbout(output, mode.name);
        const some = messages.slice(0, 3).join("\n    ");
        results.check(messages.length === 0, `${basename(input)}, ${mode.name}: ${messages.length} messages\n    ${some}`);
        files += 1;
      });
    }
    results.note(`${mode.name}: ${files} files`);
  }
  for (const { file, code } of REFUSED) {
    results.check(refusalOf(realFixture(file), folder).includes(`[${code}]`), `${file} is not refused with ${code}`);
  }
}
