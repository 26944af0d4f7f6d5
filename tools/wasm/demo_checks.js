// Checks the page on which the user steers a figure, in headless Chromium.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";
import { openPage } from "./browser_checks.js";

const ROOT = join(import.meta.dirname, "../..");

/** The wanted frames per second on an idle machine, and the fewest on any machine. */
const [WANTED, FEWEST] = [60, 15];
/** The largest median ground speed of the ankle or the toes of a foot in stance, in m/s. */
const SLIDE = 0.05;

/** Makes the figure walk ahead and then to the side, and measures how its feet slide. Runs in the page. */
function slideOfFeet() {
  const { figure, hero } = window.demo;
  const ids = ["foot.L", "toe2-1.L", "foot.R", "toe2-1.R"].map((wanted) => hero.nodes.findIndex(({ name }) => name === wanted));
  const places = () => ids.map((id) => [figure.nodeToWorld[16 * id + 12], figure.nodeToWorld[16 * id + 14]]);
  const slides = [];
  // First the figure turns to its walking direction.
  for (let frame = 0; frame < 300; frame += 1) figure.steer(0, 1.2);
  let before = places();
  for (let frame = 0; frame < 600; frame += 1) {
    const isAhead = frame < 300;
    figure.steer(isAhead ? 0 : 1.2, isAhead ? 1.2 : 0);
    const now = places();
    // In every frame of a walk one foot stands, so the slowest point belongs to that foot.
    slides.push(Math.min(...now.map(([x, z], point) => 60 * Math.hypot(x - before[point][0], z - before[point][1]))));
    before = now;
  }
  const at = (part, share) => part.toSorted((a, b) => a - b)[Math.floor(share * part.length)];
  return [slides.slice(0, 300), slides.slice(300)].map((part) => [at(part, 0.5), at(part, 0.9)]);
}

export function demoChecks(check) {
  check("demo", "a figure goes where the keys say", async () => {
    if (!existsSync(join(import.meta.dirname, "demo/moves.mdb"))) execFileSync(join(import.meta.dirname, "demo/build"));
    const browser = await chromium.launch(launchOptions());
    try {
      // The camera is behind the figure, so forward is +Z.
      const { page, trouble } = await openPage(browser, `tools/wasm/demo/index.html?yaw=${Math.PI}`, () => ROOT);
      // Install a gamepad whose stick this check moves.
      await page.evaluate(() => { window.axes = [0, 0]; navigator.getGamepads = () => [null, { axes: window.axes }]; });
      await page.waitForFunction(() => window.demo, null, { timeout: 60_000 });
      const root = () => page.evaluate(() => [...window.demo.figure.root]);
      const picture = async (name) => {
        if (process.env.MOCAP_PICTURES) await page.screenshot({ path: join(process.env.MOCAP_PICTURES, `demo-${name}.png`) });
      };
      const walked = async (key, name) => {
        const before = await root();
        await page.keyboard.down(key);
        // A machine without a graphics card draws few frames per second, and takes several steps in each.
        await page.waitForTimeout(4000);
        await picture(name);
        await page.keyboard.up(key);
        const after = await root();
        return [after[0] - before[0], after[1] - before[1]];
      };
      const forward = await walked("KeyW", "forward");
      assert.ok(forward[1] > 1 && Math.abs(forward[0]) < 0.7 * forward[1], `W: ${forward}`);
      const right = await walked("ArrowRight", "right");
      assert.ok(right[0] < -0.7, `right: ${right}`);
      // Move the stick of the page upwards.
      const box = await page.locator("#stick").boundingBox();
      await page.mouse.move(box.x + 60, box.y + 60);
      await page.mouse.down();
      await page.mouse.move(box.x + 60, box.y + 2);
      const before = await root();
      await page.waitForTimeout(4000);
      await picture("stick");
      assert.ok((await root())[1] - before[1] > 0.7, `${before} ${await root()}`);
      await page.mouse.up();
      // The y axis of a gamepad points down, so this is backwards, to the viewer.
      await page.evaluate(() => { window.axes = [0, 1]; });
      const there = await root();
      await page.waitForTimeout(4000);
      await picture("gamepad");
      assert.ok((await root())[1] - there[1] < -0.7, `${there} ${await root()}`);
      const { frames, microseconds } = await page.evaluate(() => window.demo.rates);
      const size = await page.evaluate(() => [document.getElementById("picture").width, document.getElementById("picture").height]);
      await page.evaluate(() => { window.axes = [0, 0]; });
      await page.waitForTimeout(4000);
      const stands = await root();
      await page.waitForTimeout(1000);
      const later = await root();
      const moved = Math.hypot(later[0] - stands[0], later[1] - stands[1]);
      console.log(`    with nothing asked of it, it goes ${moved.toFixed(2)} m in the fifth second`);
      await picture("stands");
      assert.deepEqual(trouble, []);
      console.log(`    ${frames.toFixed(0)} frames a second (${WANTED}) of ${size.join(" x ")} pixels, ${microseconds.toFixed(0)} µs for the figure`);
      assert.ok(frames >= FEWEST, `${frames} frames a second`);
      const slides = await page.evaluate(slideOfFeet);
      const said = slides.map((slide) => slide.map((speed) => (100 * speed).toFixed(1)).join(" and "));
      console.log(`    feet slide at ${said[0]} cm/s ahead, in the median and the 90th percentile; ${said[1]} in and after a turn`);
      assert.ok(slides[0][0] < SLIDE, `${slides}`);
    } finally {
      await browser.close();
    }
  });
}
