// Checks the course's demos: the growing chain of matrices, joints turned by hand, dragged ends of chains.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { bentPositions } from "../../src/render/view/fabrik.js";
import { settled } from "./browser.js";
import { distance, exampleProgram, plus, randomOf } from "./reaching.js";

/**
 * Chains of two to eight bones with goals within reach, out of reach and almost at the chain's length, and straight
 * chains.
 */
function chains(seed, count) {
  const random = randomOf(seed);
  const point = (size) => [random(size), random(size), random(size)];
  return Array.from({ length: count }, (_, i) => {
    const places = [point(2)];
    const along = point(0.5);
    for (let bone = 0; bone < 2 + (i % 7); bone++) places.push(plus(places.at(-1), i % 10 === 0 ? along : point(0.5)));
    const whole = places.slice(1).reduce((sum, place, bone) => sum + distance(places[bone], place), 0);
    const way = point(1);
    const far = [0.3, 0.6, 0.999, 1.5][i % 4] * whole;
    return [...places, plus(places[0], way.map((value) => (value / Math.hypot(...way)) * far))].map((place) => place.map(Math.fround));
  });
}

const boneLengths = (places) => places.slice(1).map((place, bone) => distance(places[bone], place));

export function chainChecks({ check, sample, open, mocap, pageOfFiles, pageOfText, fixture }) {
  const lecture = fixture("lecture_Test");

  check("chains bend in the page as they do in the library", async () => {
    const all = chains(sample.seed + 1, 1000);
    const input = all.map((places) => places.flat().join(" ")).join("\n");
    const lines = execFileSync(exampleProgram("chain"), { input, encoding: "utf8" }).trim().split("\n");
    assert.equal(lines.length, all.length);
    all.forEach((places, i) => {
      const goal = places.at(-1);
      const joints = places.slice(0, -1);
      const numbers = lines[i].split(" ").map(Number);
      const found = joints.map((_, joint) => numbers.slice(3 * joint, 3 * joint + 3));
      const bent = bentPositions(joints, goal, 1e-4);
      const told = `chain ${i}: ${JSON.stringify(places)}`;
      boneLengths(joints).forEach((length, bone) => assert.ok(Math.abs(boneLengths(bent)[bone] - length) < 1e-5, told));
      assert.ok(distance(bent.at(-1), found.at(-1)) < 3e-4, `end of ${told}`);
      // A straight chain may bend in any plane. An almost stretched chain may bend by a small angle in any plane.
      if (i % 10 === 0 || i % 4 === 2) return;
      bent.forEach((place, joint) => assert.ok(distance(place, found[joint]) < 1e-3, `joint ${joint} of ${told}: ${place}, not ${found[joint]}`));
    });
  });

  check("the chain grows by a matrix at a time, as the library multiplies it, with its lines and columns", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(lecture));
    await page.evaluate(() => window.mocap.seek(9));
    await page.click("#tree > div:nth-child(4)");
    await settled(page);
    const { chain } = JSON.parse(mocap("chain", lecture, "EndSite_Wrist", "--tick", "9", "--json"));
    // Lines of OFFSET or CHANNELS, and columns of the row, read by hand from the file.
    const marks = [["4,5", "1,2,3,4,5,6"], ["8", ""], ["9", "7,8,9"], ["12", ""], ["13", "10,11,12"], ["16", ""]];
    const before = await page.locator("#view").screenshot();
    for (const [i, part] of chain.entries()) {
      await page.keyboard.press("v");
      await settled(page);
      const shown = await page.evaluate(() => ({
        grown: document.querySelector("#chain-grown").textContent,
        symbols: document.querySelectorAll("#chain-product > span:not(.later)").length,
        matrix: document.querySelector("#matrix").textContent.replaceAll("−", "-").trim().split(/\s+/).map(Number),
        lines: [...document.querySelectorAll("#hierarchy mark")].map((mark) => Number.parseInt(mark.textContent, 10)).join(","),
        columns: document.querySelector("#motion-row").hidden ? "" : document.querySelector("#motion-title").textContent.replace(/^.*columns? /, "").split(" ").join(","),
        words: document.querySelector("#motion-row").hidden ? "" : [...document.querySelectorAll("#motion-row mark")].map((mark) => mark.textContent).join(" "),
      }));
      assert.equal(shown.grown, `${i + 1} of ${chain.length} matrices`);
      assert.equal(shown.symbols, i + 1);
      // Four digits are shown.
      part.product.slice(0, 3).flat().forEach((value, at) => assert.ok(Math.abs(value - shown.matrix[at]) < 6e-4, `${part.symbol}: ${shown.matrix}`));
      assert.deepEqual([shown.lines, shown.columns], marks[i], part.symbol);
      if (i === 4) assert.equal(shown.words, "80.0 0.0 0.0");
    }
    assert.ok(!before.equals(await page.locator("#view").screenshot()), "no frames are drawn");
    await page.keyboard.press("v");
    assert.equal(await page.textContent("#chain-grown"), "the whole product");
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#download-source")]);
    assert.equal(download.suggestedFilename(), "lecture_Test.bvh");
    assert.ok(readFileSync(await download.path()).equals(readFileSync(lecture)), "the file is another");
    assert.deepEqual(trouble, []);
    await close();
  });

  check("a point on a link comes where the command brings it, at every tick and for every joint", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(lecture));
    const shown = async () => (await page.textContent("#point-in-world")).replaceAll("−", "-");
    await page.click("#tree > div:nth-child(3)");
    await page.fill("#point", "0.3, -0.2 0.1");
    for (const row of [2, 3, 4]) {
      await page.click(`#tree > div:nth-child(${row})`);
      const name = await page.evaluate(() => window.mocap.state.clips[0].nodes[window.mocap.state.joint].name);
      for (const tick of [0, 4, 9]) {
        await page.evaluate((tick) => window.mocap.seek(tick), tick);
        await settled(page);
        const found = JSON.parse(mocap("chain", lecture, name, "--tick", String(tick), "--point=0.3,-0.2,0.1", "--json"));
        const numbers = (await shown()).replace("T p = ", "").trim().split(/\s+/).map(Number);
        assert.equal(numbers.length, 3, `${name}: ${await shown()}`);
        found.point_in_world.forEach((value, axis) => assert.ok(Math.abs(value - numbers[axis]) < 6e-4, `${name}, tick ${tick}: ${numbers}`));
      }
    }
    await page.fill("#point", "1, 2");
    assert.match(await shown(), /expected three numbers/);
    assert.equal(await page.getAttribute("#point", "aria-invalid"), "true");
    assert.deepEqual(trouble, []);
    await close();
  });

  check("sliders turn a joint, and the motion puts it back", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(lecture));
    await page.click("#tree > div:nth-child(2)");
    const sliders = page.locator("#slider-list input");
    assert.equal(await sliders.count(), 3);
    for (const name of ["min", "max"]) assert.equal(Math.abs(Number(await sliders.first().getAttribute(name))), 180);
    assert.match(await page.textContent("#euler-order"), /R = Rz Ry Rx .*counter-clockwise/);
    const before = await page.evaluate(() => window.mocap.drawn());
    await sliders.first().fill("90");
    await settled(page);
    // The shoulder at (0.1, 0) has 5 degrees, the elbow 90, the wrist 8.
    const at = (length, degrees) => [length * Math.cos((degrees * Math.PI) / 180), length * Math.sin((degrees * Math.PI) / 180), 0];
    const elbow = plus([0.1, 0, 0], at(2, 5));
    const wrist = plus(elbow, at(1.5, 95));
    const turned = await page.evaluate(() => window.mocap.drawn());
    [[0.1, 0, 0], elbow, wrist, plus(wrist, at(0.5, 103))].forEach((place, i) => assert.ok(distance(place, turned[i]) < 1e-5, `node ${i}: ${turned[i]}`));
    assert.match((await page.textContent("#chain tr:nth-child(3) output")).replaceAll("\u00a0", " "), /^Z 90° {2}Y 0° {2}X 0°$/);
    await page.click("#pose-reset");
    await settled(page);
    assert.deepEqual(await page.evaluate(() => window.mocap.drawn()), before);
    assert.deepEqual(trouble, []);
    await close();
  });

  check("the end of any chain goes where it is dragged, by a step that the page shows", async (browser) => {
    const leg = { file: fixture("cmu_12_01_walk"), end: "EndSite_RightToeBase", way: [-30, -40] };
    for (const { file, end, way } of [{ file: lecture, end: "EndSite_Wrist", way: [-60, -50] }, leg]) {
      const { page, trouble, close } = await open(browser, pageOfFiles(file));
      await page.evaluate(() => window.mocap.seek(5));
      await settled(page);
      const joint = await page.evaluate((end) => window.mocap.state.clips[0].nodes.findIndex(({ name }) => name === end), end);
      const before = await page.evaluate(() => window.mocap.drawn());
      const [x, y] = await page.evaluate((joint) => window.mocap.onPage(joint), joint);
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + way[0] / 2, y + way[1] / 2);
      await page.mouse.move(x + way[0], y + way[1], { steps: 4 });
      await settled(page);
      const is = await page.evaluate((joint) => window.mocap.onPage(joint), joint);
      assert.ok(distance(is, [x + way[0], y + way[1]]) < 1.5, `${end} is at ${is}`);
      await page.mouse.up();
      const after = await page.evaluate(() => window.mocap.drawn());
      const { nodes, metresPerUnit, command } = await page.evaluate(() => {
        const { nodes, metresPerUnit } = window.mocap.state.clips[0];
        return { nodes: nodes.map(({ parent }) => parent), metresPerUnit, command: document.querySelector("#drag code").textContent };
      });
      nodes.forEach((parent, node) => {
        if (parent < 0) return;
        const [was, now] = [before, after].map((places) => distance(places[parent], places[node]));
        assert.ok(Math.abs(was - now) < 1e-4 * was + 1e-9, `the bone to node ${node} was ${was} long and is ${now}`);
      });
      const steps = command.split(" ").slice(5);
      const edited = pageOfText.path("dragged.bvh");
      mocap("edit", file, "-o", edited, "--force", ...steps);
      const again = JSON.parse(mocap("pose", edited, "--tick", "5", "--world", "--json")).nodes[joint].translation;
      assert.ok(distance(again, after[joint]) * metresPerUnit < 1e-3, `the command brings ${end} to ${again}, dragged to ${after[joint]}`);
      // After that, turning a joint does not move the other joints.
      await page.keyboard.press("z");
      await settled(page);
      const back = await page.evaluate(() => window.mocap.drawn());
      back.forEach((place, node) => assert.ok(distance(place, before[node]) < 1e-6, "not put back"));
      assert.deepEqual(trouble, []);
      await close();
    }
  });

  check("between two frames the tick has decimals", async (browser) => {
    const { page, close } = await open(browser, pageOfFiles(lecture));
    for (const [tick, text] of [[0.67, "tick 0.67 / 9"], [3, "tick 3 / 9"], [8.999, "tick 8.99 / 9"]]) {
      await page.evaluate((tick) => window.mocap.seek(tick), tick);
      await settled(page);
      assert.equal(await page.textContent("#tick"), text);
    }
    await close();
  });
}
