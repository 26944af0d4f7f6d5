// three.js in Chromium draws the default file of every moving real fixture, and the check measures the figure in the
// picture.

import { basename, join } from "node:path";

import { withPage } from "../browser.js";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, subfolder } from "../mocap.js";

/** The largest difference from the figure's computed height, in pixels: lines fade out at their ends. */
const SIZE_TOLERANCE = 12;
/** A figure with fewer visible pixels counts as a blank picture. */
const MIN_PIXELS = 300;
/** Standing figures, with the height of the head's joint above the foot's joint, in metres. */
const STANDING = new Map([
  ["cmu_01_01.bvh", [1.2, 1.7]],
  ["cmu_12_01_walk.bvh", [1.2, 1.7]],
]);

async function checkPicture(results, page, address, outputs, input) {
  const name = basename(input);
  const output = convert(input, join(outputs, outputName(input, ".glb")));
  const { frames, frameTime } = describe(output);
  if (frames < 2) return 0;
  const seconds = Math.floor(frames / 2) * frameTime;
  const { size, pixelsPerMetre, headOverFoot } = await page.evaluate(([file, time]) => window.show(file, time), [
    `${address}/files/${basename(output)}`,
    seconds,
  ]);
  const picture = outputName(input, ".png");
  await page.screenshot({ path: join(outputs, picture) });
  const seen = await page.evaluate((png) => window.measure(png), `${address}/files/${picture}`);
  results.check(seen.pixels >= MIN_PIXELS, `${name}: ${seen.pixels} pixels differ from the background`);
  results.check(seen.colours >= 8, `${name}: ${seen.colours} colours, so that there is no shading`);
  for (const [what, pixels, metres] of [["wide", seen.width, size[0]], ["high", seen.height, size[1]]]) {
    const expected = metres * pixelsPerMetre;
    results.check(
      Math.abs(pixels - expected) <= SIZE_TOLERANCE,
      `${name}: ${pixels} pixels ${what}, where ${expected.toFixed(0)} were expected`,
    );
  }
  if (STANDING.has(name)) {
    const [least, most] = STANDING.get(name);
    const isRight = headOverFoot > least && headOverFoot < most;
    results.check(isRight, `${name}: the head is ${headOverFoot} m above the foot`);
    results.check(seen.height > 1.5 * seen.width, `${name}: ${seen.width} by ${seen.height} pixels do not stand`);
  }
  return 1;
}

export async function run(results, folder, sample) {
  const outputs = subfolder(folder, "browser");
  await withPage(results, outputs, "index.html", async (page, address, version) => {
    let pictures = 0;
    for (const input of sample.some(fixtures("real"), 4)) {
      await results.guard(basename(input), async () => {
        pictures += await checkPicture(results, page, address, outputs, input);
      });
    }
    results.note(`Chromium ${version}: ${pictures} pictures`);
  });
}
