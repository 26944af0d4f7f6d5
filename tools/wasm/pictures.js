// Makes the pictures of README.md: states of the drop page in headless Chromium.
//
//   node tools/wasm/pictures.js [NAME..]      # after tools/wasm/check or build; needs ffmpeg

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { launchOptions, savePicture } from "../chromium.mjs";

const here = import.meta.dirname;
const folder = join(here, "pictures");
const fixture = (name) => join(here, "../../fixtures", name);
const DESK = { viewport: { width: 1280, height: 760 } };
const PHONE = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };
const [WALK, G1] = ["real/cmu_12_01_walk.bvh", "robots/g1_29dof_rev_1_0.urdf"].map(fixture);

/** Each picture: its name, the options of the page, and the actions of a person. */
const PICTURES = [
  ["start", DESK, async () => {}],
  ["walk", DESK, async ({ page, open, seek }) => { await open(WALK); await seek(200); await page.click("#tree >> text=LeftFoot"); await page.waitForTimeout(500); }],
  ["character", DESK, async ({ open, seek }) => { await open(WALK, fixture("characters/human_game_engine.glb")); await seek(260); }],
  ["robot", DESK, async ({ page, open, seek }) => { await open(WALK, G1); await page.click("#robot summary"); await page.selectOption("#robot-joint", "3"); await seek(200); await page.locator("#robot-report").scrollIntoViewIfNeeded(); }],
  ["steps", DESK, async ({ page, open }) => { await open(WALK); await page.click("#steps summary"); await page.waitForSelector("#step-name option", { state: "attached" }); await page.locator("#step-row").scrollIntoViewIfNeeded(); }],
  ["broken", { ...DESK, colorScheme: "dark" }, async ({ open }) => { await open(WALK); await open(fixture("broken/unknown_channel.bvh")); }],
  ["film", DESK, async ({ page, open, seek }) => { await open(WALK); await seek(120); await page.click("#save-film"); }],
  ["phone", PHONE, async ({ open, seek }) => { await open(WALK); await seek(120); }],
  ["phone-joint", { ...PHONE, colorScheme: "dark" }, async ({ page, open, seek }) => { await open(WALK); await seek(120); await page.click("#panel-button"); await page.click("#tree >> text=LeftArm"); await page.waitForTimeout(500); }],
];

mkdirSync(folder, { recursive: true });
const wanted = process.argv.slice(2);
for (const [name, options, act] of PICTURES) {
  if (wanted.length && !wanted.includes(name)) continue;
  const browser = await chromium.launch(launchOptions());
  const page = await (await browser.newContext({ reducedMotion: "reduce", ...options })).newPage();
  await page.goto(pathToFileURL(join(here, "mocap.html")).href);
  await page.waitForFunction(() => window.desk?.reader.isReady);
  const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const open = async (...files) => {
    const before = await page.evaluate(() => window.desk.openings);
    await page.setInputFiles("#file-input", files);
    await page.waitForFunction((before) => window.desk.openings > before && !window.desk.opening, before, { timeout: 120_000 });
    await drawn();
  };
  const seek = async (tick) => { await page.evaluate((tick) => window.mocap.seek(tick), tick); await drawn(); };
  await act({ page, open, seek });
  await drawn();
  await savePicture(page, join(folder, `${name}.png`));
  await browser.close();
}
