// The page where a figure is walked, in headless Chromium.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";
import { openPage } from "./browser_checks.js";

const ROOT = join(import.meta.dirname, "../..");

export function demoChecks(check) {
  check("demo", "a figure goes where the keys say", async () => {
    if (!existsSync(join(import.meta.dirname, "demo/moves.mdb"))) execFileSync(join(import.meta.dirname, "demo/build"));
    const browser = await chromium.launch(launchOptions());
    try {
      // Seen from behind: forward is +Z.
      const { page, trouble } = await openPage(browser, `tools/wasm/demo/index.html?yaw=${Math.PI}`, () => ROOT);
      await page.waitForFunction(() => window.demo, null, { timeout: 60_000 });
      const root = () => page.evaluate(() => [...window.demo.figure.root]);
      const picture = async (name) => {
        if (process.env.MOCAP_PICTURES) await page.screenshot({ path: join(process.env.MOCAP_PICTURES, `demo-${name}.png`) });
      };
      const walked = async (key, name) => {
        const before = await root();
        await page.keyboard.down(key);
        // A machine without a graphics card makes up for few frames a second by several steps in each.
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
      // The stick of the page, upwards.
      const box = await page.locator("#stick").boundingBox();
      await page.mouse.move(box.x + 60, box.y + 60);
      await page.mouse.down();
      await page.mouse.move(box.x + 60, box.y + 2);
      const before = await root();
      await page.waitForTimeout(4000);
      await picture("stick");
      assert.ok((await root())[1] - before[1] > 0.7, `${before} ${await root()}`);
      await page.mouse.up();
      await page.waitForTimeout(2500);
      await picture("stands");
      assert.deepEqual(trouble, []);
      const { frames, microseconds } = await page.evaluate(() => window.demo.rates);
      console.log(`    ${frames.toFixed(0)} frames a second, ${microseconds.toFixed(0)} µs for the figure`);
    } finally {
      await browser.close();
    }
  });
}
