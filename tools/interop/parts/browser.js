// Chromium without a screen: three.js draws the default file of every moving real fixture, and the picture is measured.

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { basename, extname, join } from "node:path";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

import { launchOptions } from "../../chromium.mjs";
import { describe } from "../glb.js";
import { convert, fixtures, outputName, subfolder } from "../mocap.js";

const VIEWPORT = { width: 480, height: 480 };
/** How far the figure in the picture may be from its computed height, in pixels: lines fade out at tips. */
const SIZE_TOLERANCE = 12;
/** A figure of which fewer pixels are seen is taken for a blank picture. */
const MIN_PIXELS = 300;
/** Figures of which it is known that they stand, and how high the head's joint is above the foot's, in metres. */
const STANDING = new Map([
  ["cmu_01_01.bvh", [1.2, 1.7]],
  ["cmu_12_01_walk.bvh", [1.2, 1.7]],
]);
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".glb": "model/gltf-binary", ".png": "image/png" };

/** A server on this machine alone for the page, its modules and the written files. */
async function serve(outputs) {
  const roots = {
    page: fileURLToPath(new URL("../page/", import.meta.url)),
    modules: fileURLToPath(new URL("../node_modules/", import.meta.url)),
    files: outputs,
  };
  const server = createServer(async (request, response) => {
    const [, root, ...rest] = decodeURIComponent(new URL(request.url, "http://127.0.0.1").pathname).split("/");
    try {
      const path = join(roots[root], ...rest);
      const bytes = await readFile(path);
      response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { server, address: `http://127.0.0.1:${server.address().port}` };
}

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

export async function run(results, folder) {
  const outputs = subfolder(folder, "browser");
  const profile = mkdtempSync(join(tmpdir(), "mocap-chromium-"));
  const { server, address } = await serve(outputs);
  const context = await chromium.launchPersistentContext(profile, {
    ...launchOptions(),
    headless: true,
    viewport: VIEWPORT,
  });
  try {
    const page = await context.newPage();
    page.on("pageerror", (error) => results.check(false, `the page: ${error}`));
    await page.goto(`${address}/page/index.html`);
    await page.waitForFunction(() => window.isReady);
    let pictures = 0;
    for (const input of fixtures("real")) {
      await results.guard(basename(input), async () => {
        pictures += await checkPicture(results, page, address, outputs, input);
      });
    }
    results.note(`Chromium ${context.browser().version()}: ${pictures} pictures`);
  } finally {
    await context.close();
    server.close();
    rmSync(profile, { recursive: true, force: true });
  }
}
