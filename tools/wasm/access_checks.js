// Accessibility of the drop page: axe-core finds no violation, and controls are large enough for fingers.

import assert from "node:assert/strict";
import axe from "axe-core";

/** The least width and height of a control on a touch screen, in pixels. */
const FINGER = 44;
const PHONE = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };

/** The violations that axe-core finds, as text. */
async function violationsOf(page) {
  await page.evaluate(axe.source);
  const { violations } = await page.evaluate(() => globalThis.axe.run({ resultTypes: ["violations"] }));
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 100)).join(" | ")}`);
}

/** Controls that are too small for a finger. */
const smallOf = (page) => page.evaluate((least) => {
  const controls = Array.from(document.querySelectorAll("button, select, input, summary, [role=treeitem]"));
  // A checkbox can also be pressed on its label.
  const shown = controls.filter((control) => control.checkVisibility() && control.type !== "checkbox");
  const size = (control) => { const { width, height } = control.getBoundingClientRect(); return { control: control.id || control.textContent, width, height }; };
  return shown.map(size).filter(({ width, height }) => width < least || height < least).map((found) => JSON.stringify(found));
}, FINGER - 0.5);

export function accessChecks(pageCheck, { open, fixture }) {
  for (const colorScheme of ["light", "dark"]) {
    for (const [name, options] of [["a desk", {}], ["a phone", PHONE]]) {
      pageCheck(`axe-core finds nothing on ${name}, ${colorScheme}`, async (browser) => {
        const { page, drop, trouble } = await open(browser, { ...options, colorScheme });
        const isPhone = options === PHONE;
        const states = [
          ["the empty page", async () => {}],
          ["a broken file", () => drop(fixture("broken/unknown_channel.bvh"))],
          ["a motion on a character", () => drop(fixture("real/cmu_short.bvh"), fixture("characters/human_vrm0.vrm"))],
          ["morph targets", async () => { if (isPhone) await page.click("#panel-button"); await page.click("#morphs summary"); }],
          ["the files", () => isPhone && page.click("#desk-button")],
          ["the steps", async () => { await page.click("#opened .item >> text=cmu_short.bvh"); await page.click("#steps summary"); await page.waitForSelector("#step-name option", { state: "attached" }); }],
          ["a joint", async () => { if (isPhone) await page.click("#panel-button"); await page.click("#tree >> text=LeftArm"); }],
          ["the keys", () => page.click("#help-button")],
          ["a film", async () => { await page.keyboard.press("Escape"); await page.evaluate(() => window.desk.player.film.open()); }],
          ["a robot", async () => {
            await page.keyboard.press("Escape");
            await drop(fixture("real/cmu_short.bvh"), fixture("robots/g1_29dof_rev_1_0.urdf"));
            if (isPhone) await page.click("#desk-button");
            await page.click("#robot summary");
          }],
        ];
        for (const [state, reach] of states) {
          await reach();
          assert.deepEqual(await violationsOf(page), [], state);
          if (isPhone) assert.deepEqual(await smallOf(page), [], `${state}: too small for a finger`);
          assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${state}: wider than the window`);
        }
        assert.deepEqual(trouble, []);
      });
    }
  }
}
