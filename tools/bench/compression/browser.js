// Measures decode.js in Chromium, which loads everything from a local server.

import { mkdtempSync, rmSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";

import { launchOptions } from "../../chromium.mjs";

const { chromium } = createRequire(join(import.meta.dirname, "../../interop/package.json"))("playwright-core");
const tools = join(import.meta.dirname, "../..");
const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };

/** `input` is JSON; bytes in it are base64. */
export async function inChromium(input) {
  const server = createServer(async (request, response) => {
    const path = decodeURIComponent(request.url);
    try {
      if (path === "/") return response.writeHead(200, { "content-type": "text/html" }).end("<title>decode</title>");
      if (path === "/input") return response.writeHead(200).end(JSON.stringify(input));
      response.writeHead(200, { "content-type": TYPES[extname(path)] }).end(await readFile(join(tools, path)));
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const profile = mkdtempSync(join(tmpdir(), "mocap-decode-"));
  const context = await chromium.launchPersistentContext(profile, { ...launchOptions(), headless: true });
  try {
    const page = await context.newPage();
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    const times = await page.evaluate(async () => {
      const [{ decodeTimes }, { MeshoptDecoder }, { load }] = await Promise.all([
        import("/bench/compression/decode.js"),
        import("/interop/node_modules/meshoptimizer/meshopt_decoder.mjs"),
        import("/wasm/package/index.js"),
      ]);
      await MeshoptDecoder.ready;
      const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      const { packed, clips } = await (await fetch("/input")).json();
      return decodeTimes({
        decoder: MeshoptDecoder,
        mocap: await load(),
        packed: Object.fromEntries(Object.entries(packed).map(([name, { views, bytes }]) => [name, { views, bytes: bytesOf(bytes) }])),
        clips: Object.fromEntries(Object.entries(clips).map(([name, bytes]) => [name, bytesOf(bytes)])),
      });
    });
    return { ...times, version: context.browser().version() };
  } finally {
    await context.close();
    server.close();
    rmSync(profile, { recursive: true, force: true });
  }
}
