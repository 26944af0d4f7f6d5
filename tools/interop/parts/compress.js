// Checks the compressed forms within a bound of a millimetre. The validator reads the file and its unpacked copy.
// three.js and, in Chromium, Babylon read the file with their decoders.

import { statSync } from "node:fs";
import { basename, join } from "node:path";

import { withPage } from "../browser.js";
import { largestDistance, millimetres, stepsOf, ticksOf, toleranceFor } from "../compare.js";
import { describe } from "../glb.js";
import { writeUnpacked } from "../meshopt.js";
import { convert, fixtures, outputName, pose, subfolder } from "../mocap.js";
import { open } from "../playback.js";
import { load, placesOf } from "./three.js";
import { messagesAbout } from "./validator.js";

/** The requested bound in metres. */
const BOUND = 0.001;
/** The error of a client's single precision, as a fraction of the limit. */
const ROUNDING = 0.1;
const FORMS = ["int16", "meshopt", "meshopt-khr"];
/**
 * The extensions that Babylon does not know. It must name them in an error: a silent failure or a wrong pose would be
 * worse.
 */
const UNKNOWN_TO_BABYLON = "KHR_meshopt_compression";

async function checkValidator(results, name, form, output) {
  const messages = await messagesAbout(output, form);
  results.check(messages.length === 0, `${name}: ${messages.slice(0, 3).join("\n    ")}`);
  const twin = await writeUnpacked(output, output.replace(/\.glb$/, ".unpacked.glb"));
  const ofTwin = await messagesAbout(twin, "default");
  results.check(ofTwin.length === 0, `${name}, unpacked: ${ofTwin.slice(0, 3).join("\n    ")}`);
}

/** The positions of a file's nodes in three.js, at times in seconds. */
async function playInThree(output, nodes, times) {
  const { objectOfNode, showTime } = await load(output);
  const objects = nodes.map((node) => objectOfNode.get(node.index));
  return times.map((seconds) => {
    showTime(seconds);
    return placesOf(objects);
  });
}

/** Returns the errors of the clients against the file, by client. */
async function checkFile(results, page, address, input, output, form) {
  const name = `${basename(input)}, ${form}`;
  const { json, nodes, frames, frameTime, provenance } = describe(output);
  await checkValidator(results, name, form, output);

  const ticks = ticksOf(frames);
  const times = ticks.map((tick) => tick * frameTime);
  const clients = [{ client: "three.js", places: await playInThree(output, nodes, times) }];
  const answer = await page.evaluate((args) => window.play(...args), [
    `${address}/files/${form}/${basename(output)}`,
    nodes.map((node) => node.name),
    times,
  ]);
  if (json.extensionsRequired?.includes(UNKNOWN_TO_BABYLON)) {
    results.check(answer.refusal?.includes(UNKNOWN_TO_BABYLON), `${name}: Babylon does not refuse it: ${answer.refusal}`);
  } else if (results.check(answer.places, `${name}: Babylon: ${answer.refusal}`)) {
    results.check(answer.bones.length === 1, `${name}: Babylon has ${answer.bones.length} skeletons`);
    clients.push({ client: "Babylon", places: answer.places });
  }

  const { placesAt } = await open(output);
  const { sourceTick, change } = stepsOf(provenance);
  const worst = {};
  ticks.forEach((tick, index) => {
    // Quantized quaternions have a length near 1. mocap normalises them; a client does not always.
    const [unchanged, normalised] = ["unchanged", "normalised"].map((reading) => {
      const inFile = placesAt(times[index], reading);
      return nodes.map((node) => inFile[node.index]);
    });
    const tolerance = toleranceFor(normalised);
    const own = largestDistance(pose(output, tick).map((node) => node.translation), normalised);
    results.check(own <= tolerance, `${name}, tick ${tick}: mocap's pose is ${millimetres(own)} from the file`);
    // Between two frames the bound does not hold, because the source has no frame there.
    const inSource = Number.isInteger(tick) && pose(input, sourceTick(tick)).map((node) => change(node.translation));
    for (const { client, places } of clients) {
      const distance = Math.min(...[unchanged, normalised].map((reading) => largestDistance(places[index], reading)));
      results.check(distance <= tolerance, `${name}, tick ${tick}: ${client} is ${millimetres(distance)} from the file`);
      if (tolerance < 0.00011) worst[client] = Math.max(worst[client] ?? 0, distance);
      if (!inSource) continue;
      const error = largestDistance(places[index], inSource);
      const most = BOUND + ROUNDING * tolerance;
      results.check(error <= most, `${name}, tick ${tick}: ${client} is ${millimetres(error)} from the source`);
    }
  });
  return worst;
}

export async function run(results, folder, sample) {
  const root = subfolder(folder, "compress");
  await withPage(results, root, "babylon.html", async (page, address) => {
    for (const [place, form] of FORMS.entries()) {
      const outputs = subfolder(root, form);
      const worst = {};
      let [files, bytes] = [0, 0];
      for (const input of sample.share(fixtures("real"), place, 2 * FORMS.length)) {
        await results.guard(`${basename(input)}, ${form}`, async () => {
          const output = join(outputs, outputName(input, ".glb"));
          convert(input, output, "--compress", form, "--max-error", `${BOUND * 1000}mm`);
          if (describe(output).frames < 2) return;
          files += 1;
          bytes += statSync(output).size;
          for (const [client, distance] of Object.entries(await checkFile(results, page, address, input, output, form))) {
            worst[client] = Math.max(worst[client] ?? 0, distance);
          }
        });
      }
      results.check(files > 0, `${form}: no file that moves`);
      const distances = Object.entries(worst).map(([client, distance]) => `${client} at most ${millimetres(distance)} off`);
      results.note(`${form}: ${files} files, ${bytes} bytes; ${distances.join(", ")}, in figures of human size`);
    }
  });
}
