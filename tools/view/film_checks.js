// Checks the pictures and films that a page saves, and the visible part of its time line.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { settled } from "./browser.js";

/** The four letters in every file of a kind, and their position. */
const MARKS = { png: ["PNG", 1], gif: ["GIF8", 0], webm: ["webm", 0], mp4: ["ftyp", 4] };

export function filmChecks({ check, open, pageOf }) {
  check("a picture and films are saved, of the part of the time that is shown", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"));
    await page.evaluate(() => window.mocap.seek(200));
    await settled(page);
    for (let presses = 0; presses < 5; presses++) await page.keyboard.press(".");
    const [least, most] = await page.evaluate(() => ["min", "max"].map((end) => Number(document.getElementById("scrub")[end])));
    assert.ok(most - least < 20 && least <= 200 && most >= 200, `${least} to ${most}`);
    const whole = await page.evaluate(() => ["left", "width"].map((side) => document.getElementById("rests").getBoundingClientRect()[side]));
    assert.ok(whole[1] > 0);
    await page.keyboard.press("p");
    for (const [kind, [mark, at]] of Object.entries(MARKS)) {
      if (await page.locator(`#film-kind [value=${kind}]`).isDisabled()) continue;
      await page.selectOption("#film-kind", kind);
      await page.selectOption("#film-size", "");
      const [download] = await Promise.all([page.waitForEvent("download"), page.click("#film-save")]);
      assert.equal(download.suggestedFilename(), `cmu_12_01_walk.${kind}`);
      const bytes = readFileSync(await download.path());
      const found = bytes.indexOf(mark, at, "latin1");
      assert.ok(at ? found === at : found >= 0 && found < 96, `${kind} has no ${mark}`);
    }
    await page.keyboard.press("Escape");
    // The page is unchanged.
    assert.equal(Number(await page.inputValue("#scrub")), 200);
    for (let presses = 0; presses < 6; presses++) await page.keyboard.press(",");
    assert.equal(await page.getAttribute("#scrub", "max"), "523");
    assert.equal(await page.isVisible("#part"), false);
    assert.deepEqual(trouble, []);
    await close();
  });
}
