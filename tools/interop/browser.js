// Opens a page of page/ in Chromium without a screen. A local server provides the page, its modules and the written
// files.

import { mkdtempSync, rmSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

import { launchOptions } from "../chromium.mjs";

const VIEWPORT = { width: 480, height: 480 };
const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".cjs": "text/javascript",
  ".glb": "model/gltf-binary",
  ".png": "image/png",
};

async function serve(outputs) {
  const roots = {
    page: fileURLToPath(new URL("page/", import.meta.url)),
    modules: fileURLToPath(new URL("node_modules/", import.meta.url)),
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

/**
 * Opens a page of page/ and passes it to `body`, with the address of the server and Chromium's version. The server has
 * the files of `outputs` under /files. An error in the page is a failed check.
 */
export async function withPage(results, outputs, name, body) {
  const profile = mkdtempSync(join(tmpdir(), "mocap-chromium-"));
  const { server, address } = await serve(outputs);
  const context = await chromium.launchPersistentContext(profile, { ...launchOptions(), headless: true, viewport: VIEWPORT });
  try {
    const page = await context.newPage();
    page.on("pageerror", (error) => results.check(false, `the page: ${error}`));
    await page.goto(`${address}/page/${name}`);
    await page.waitForFunction(() => window.isReady);
    await body(page, address, context.browser().version());
  } finally {
    await context.close();
    server.close();
    rmSync(profile, { recursive: true, force: true });
  }
}
