// The package in headless Chromium: the same scenes as in Node, the example page, and the speed compared with BVHLoader.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { basename, extname, join } from "node:path";
import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
/** An address that the browser trusts. No server listens there, because this script answers every request. */
const HOST = "http://localhost:9/";

const hash = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** Opens a page. `rootOf` returns the folder for a path. `trouble` collects the messages and the missing files of the page. */
export async function openPage(browser, address, rootOf) {
  const page = await browser.newPage({ viewport: { width: 900, height: 600 } });
  const trouble = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && trouble.push(message.text()));
  page.on("pageerror", (error) => trouble.push(error.message));
  await page.route("**/*", (route) => {
    const { pathname } = new URL(route.request().url());
    try {
      const body = readFileSync(join(rootOf(pathname), decodeURIComponent(pathname)));
      return route.fulfill({ body, contentType: TYPES[extname(pathname)] ?? "application/octet-stream" });
    } catch {
      if (pathname === "/favicon.ico") return route.fulfill({ status: 204 });
      trouble.push(`${pathname} is not there`);
      return route.fulfill({ status: 404 });
    }
  });
  await page.goto(HOST + address);
  return { page, trouble };
}

export function browserChecks(check, { fixtures, all, sample, filesOf, mocap, made }) {
  /** Opens a page of this folder, or of the fixtures. */
  const open = (browser, address) =>
    openPage(browser, address, (pathname) => (pathname.startsWith("/fixtures/") ? join(fixtures, "..") : import.meta.dirname));

  /** Runs `use` in a separate browser. */
  const inBrowser = (use) => async () => {
    const browser = await chromium.launch(launchOptions());
    try {
      await use(browser);
    } finally {
      await browser.close();
    }
  };

  check("browser", "scenes and GLBs in Chromium are those in Node", inBrowser(async (browser) => {
    const { page, trouble } = await open(browser, "browser_check.html");
    await page.waitForFunction(() => window.mocap);
    for (const path of sample.some(all, 24)) {
      const files = filesOf(path);
      const names = files.map(({ name }) => `/fixtures/${path.slice(fixtures.length + 1, -basename(path).length)}${name}`);
      const found = await page.evaluate((names) => window.hashes(names), names);
      const expected = made(() => {
        const scene = mocap.read(files);
        const both = [hash(scene.toJson()), hash(scene.toGlb())];
        scene.free();
        return both;
      });
      assert.deepEqual(found, expected, path);
    }
    assert.deepEqual(trouble, []);
  }));

  check("browser", "the example page plays a walk", inBrowser(async (browser) => {
    const { page, trouble } = await open(browser, "example/index.html");
    await page.waitForFunction(() => window.played > 2);
    assert.equal(await page.evaluate(() => window.result.skeleton.bones.length), 38);
    if (process.env.MOCAP_PICTURE) await page.screenshot({ path: process.env.MOCAP_PICTURE });
    assert.deepEqual(trouble, []);
  }));

  check("browser", "<mocap-player> plays what its attributes say, and tells what is wrong", inBrowser(async (browser) => {
    const { page, trouble } = await open(browser, "example/player.html?file=/fixtures/real/cmu_12_01_walk.bvh&character=/fixtures/characters/human_vrm0.vrm");
    await page.waitForFunction(() => document.title === "cmu_12_01_walk on human_vrm0", undefined, { timeout: 60_000 });
    const player = (act) => page.evaluate(`(() => { const player = document.querySelector("mocap-player"); return ${act}; })()`);
    await page.waitForFunction(() => document.querySelector("mocap-player").currentTime > 0);
    assert.ok(Math.abs(await player("player.duration") - 522 / 120) < 0.01);
    await player("(player.pause(), player.currentTime = 2)");
    await page.waitForFunction(() => Math.abs(document.querySelector("mocap-player").currentTime - 2) < 1e-6 && document.querySelector("mocap-player").paused);
    if (process.env.MOCAP_PICTURES) await page.screenshot({ path: join(process.env.MOCAP_PICTURES, "element.png") });
    await player("(player.removeAttribute('character'), player.setAttribute('src', '/fixtures/real/cmu_short.bvh'))");
    await page.waitForFunction(() => document.title === "cmu_short.bvh");
    await player("player.setAttribute('src', '/fixtures/broken/unknown_channel.bvh')");
    await page.waitForFunction(() => /is not a channel/.test(document.title));
    assert.deepEqual(trouble, []);
    await player("player.setAttribute('src', '/fixtures/absent.bvh')");
    await page.waitForFunction(() => /absent\.bvh: 404/.test(document.title));
  }));

  check("speed", "measures MocapLoader beside BVHLoader in Chromium", inBrowser(async (browser) => {
    const { page } = await open(browser, "browser_check.html");
    await page.waitForFunction(() => window.mocap);
    const { ours, theirs, read } = await page.evaluate(() => window.times("/fixtures/real/cmu_01_01.bvh"));
    const ratio = (theirs / ours).toFixed(1);
    console.log(`cmu_01_01.bvh in Chromium: read ${read.toFixed(1)} ms, MocapLoader ${ours.toFixed(1)} ms, BVHLoader ${theirs.toFixed(1)} ms, ${ratio} times`);
  }));
}
