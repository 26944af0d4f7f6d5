// Checks the marks beside the motion: contacts, comparison of limbs with a source, and dragged hands and feet.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { twoBone, turned } from "../../src/render/view/reach.js";
import { settled } from "./browser.js";
import { distance, exampleProgram, minus, plus, randomOf } from "./reaching.js";

/** Limbs with goals within and out of reach, and straight and folded limbs. */
function tasks(seed, count) {
  const random = randomOf(seed);
  const point = (size) => [random(size), random(size), random(size)];
  return Array.from({ length: count }, (_, i) => {
    const start = point(2);
    const first = point(0.5);
    const second = i % 10 === 0 ? first.map((value) => value * 0.8) : point(0.5);
    const middle = plus(start, first);
    return [start, middle, plus(middle, second), plus(start, point(i % 5 === 0 ? 3 : 0.6))].map((place) => place.map(Math.fround));
  });
}

export function markChecks({ check, sample, open, mocap, pageOfFiles, pageOfText, fixture }) {
  const walk = fixture("cmu_12_01_walk");

  check("two bones turn in the page as they do in the library", async () => {
    const all = tasks(sample.seed + 1, 2000);
    const input = all.map((places) => places.flat().join(" ")).join("\n");
    const lines = execFileSync(exampleProgram("two_bone"), { input, encoding: "utf8" });
    const found = lines.trim().split("\n").map((line) => line.split(" ").map(Number));
    assert.equal(found.length, all.length);
    all.forEach(([start, middle, end, goal], i) => {
      const { upper, lower, middle: comesTo } = twoBone([start, middle, end], goal);
      const at = plus(start, turned(upper, minus(middle, start)));
      const last = plus(at, turned(lower, minus(end, middle)));
      const told = JSON.stringify([start, middle, end, goal]);
      // A straight limb may bend in any plane; its end is the same.
      const isStraight = i % 10 === 0;
      assert.ok(distance(last, found[i].slice(3, 6)) < 1e-5, `end of ${told}`);
      assert.ok(distance(at, comesTo) < 1e-9, `middle of ${told}`);
      assert.ok(isStraight || distance(at, found[i].slice(0, 3)) < 1e-4, `middle of ${told}`);
      if (isStraight) return;
      for (const [name, q, other] of [["upper", upper, found[i].slice(6, 10)], ["lower", lower, found[i].slice(10, 14)]]) {
        assert.ok(Math.abs(Math.abs(q.reduce((sum, value, k) => sum + value * other[k], 0)) - 1) < 1e-6, `${name} of ${told}`);
      }
    });
  });

  check("a hand and a foot go where they are dragged, and back", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(walk));
    const place = (name) => page.evaluate((name) => {
      const { nodes } = window.mocap.state.clips[0];
      const at = nodes.findIndex(({ bone }) => bone?.name === name);
      return { joint: at, page: window.mocap.onPage(at), file: window.mocap.drawn()[at] };
    }, name);
    await page.evaluate(() => window.mocap.seek(200));
    await settled(page);
    for (const [names, way] of [[["leftUpperArm", "leftLowerArm", "leftHand"], [20, -50]], [["rightUpperLeg", "rightLowerLeg", "rightFoot"], [-30, -40]]]) {
      const before = await Promise.all(names.map(place));
      const [x, y] = before[2].page;
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + way[0] / 2, y + way[1] / 2);
      await page.mouse.move(x + way[0], y + way[1], { steps: 4 });
      await settled(page);
      const after = await Promise.all(names.map(place));
      const aside = distance(after[2].page, [x + way[0], y + way[1]]);
      assert.ok(aside < 1.5, `${names[2]} is ${aside} pixels from the pointer`);
      for (const [from, to] of [[0, 1], [1, 2]]) {
        const [was, is] = [before, after].map((places) => distance(places[from].file, places[to].file));
        assert.ok(Math.abs(was - is) < 1e-4 * was, `${names[from]} was ${was} long and is ${is}`);
      }
      assert.ok(distance(before[0].file, after[0].file) < 1e-6);
      await page.mouse.up();
      // The command on the page makes the same change in the file.
      const shown = await page.evaluate(() => ({ command: document.querySelector("#drag code").textContent, json: document.querySelector("#drag").title }));
      assert.deepEqual(JSON.parse(shown.json).map(({ step, range }) => [step, range]), [["reach", "200f..200f"]]);
      const [, , name, , , ...steps] = shown.command.split(" ");
      assert.equal(name, "cmu_12_01_walk.bvh");
      const edited = pageOfText.path(`${names[2]}.bvh`);
      mocap("edit", walk, "-o", edited, "--force", ...steps);
      const again = await open(browser, pageOfFiles(edited));
      await again.page.evaluate(() => window.mocap.seek(200));
      await settled(again.page);
      const reached = await again.page.evaluate((at) => window.mocap.drawn()[at], after[2].joint);
      // A millimetre, in the unit of CMU.
      assert.ok(distance(reached, after[2].file) < 0.001 / 0.0564, `the command brings ${names[2]} to ${reached}, dragged to ${after[2].file}`);
      await again.close();
      await page.keyboard.press("z");
      await settled(page);
      assert.ok(distance((await place(names[2])).file, before[2].file) < 1e-6, "not put back");
      assert.equal(await page.evaluate(() => document.querySelector("#drag")), null);
    }
    assert.deepEqual(trouble, []);
    await close();
  });

  check("feet at rest are marked, and drawn below the time line", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(walk));
    const bars = () => page.evaluate(() => {
      const canvas = document.querySelector("#rests");
      const { data } = canvas.getContext("2d", { willReadFrequently: true }).getImageData(0, 0, canvas.width, canvas.height);
      return Array.from({ length: canvas.width }, (_, x) => [1, canvas.height - 2].map((y) => data[4 * (y * canvas.width + x) + 3] > 128));
    });
    const columns = await bars();
    for (const side of [0, 1]) {
      const changes = columns.filter((column, x) => x > 0 && column[side] !== columns[x - 1][side]).length;
      assert.ok(changes >= 4, `${changes} changes on side ${side}`);
    }
    // During a bar, the page draws a ball on the foot.
    const balls = () => page.evaluate(() => window.mocap.state.clips[0].contacts.filter((point) =>
      point.intervals.some(([first, last]) => first <= window.mocap.state.clips[0].tick && window.mocap.state.clips[0].tick <= last)).map(({ bone }) => bone));
    await page.evaluate(() => window.mocap.seek(200));
    await settled(page);
    const column = columns[Math.round((200 / 523) * (columns.length - 1))];
    const resting = await balls();
    assert.deepEqual(column, ["left", "right"].map((side) => resting.some((bone) => bone.startsWith(side))));
    const marked = await page.locator("#view").screenshot();
    await page.keyboard.press("x");
    await settled(page);
    assert.ok(!marked.equals(await page.locator("#view").screenshot()));
    assert.ok(!(await page.isVisible("#rests")));
    assert.deepEqual(trouble, []);
    await close();
  });

  check("a retargeted clip beside its source shows how far its limbs are off", async (browser) => {
    const character = fixture(`../characters/${sample.some(["human_vrm0.vrm", "human_game_engine.glb"], 2)[0]}`);
    const moved = pageOfText.path(character.endsWith(".vrm") ? "moved.vrm" : "moved.glb");
    const [report] = JSON.parse(mocap("retarget", walk, character, "-o", moved, "--replace-animations", "--json"));
    const { page, trouble, close } = await open(browser, pageOfFiles(walk, moved));
    assert.equal(await page.getAttribute("#errors", "aria-pressed"), "true");
    const legend = await page.locator("#bone-legend").textContent();
    const [mean, most] = legend.match(/mean ([\d.]+)°, at most ([\d.]+)°/).slice(1).map(Number);
    assert.ok(Math.abs(mean - report.mean_degrees) < 0.1 && Math.abs(most - report.max_degrees) < 0.1, `${legend}: ${report.mean_degrees}, ${report.max_degrees}`);
    const worst = report.limbs.reduce((a, b) => (a.max_degrees > b.max_degrees ? a : b));
    await page.evaluate((tick) => window.mocap.seek(tick), worst.tick);
    await settled(page);
    const shown = await page.evaluate((bone) => {
      const { limbs, nodes, tick } = window.mocap.state.clips[1];
      return limbs.angles[limbs.nodes.findIndex((node) => nodes[node].bone?.name === bone) * limbs.frames + Math.round(tick)] * limbs.step;
    }, worst.bone);
    assert.ok(Math.abs(shown - worst.max_degrees) < 0.1, `${worst.bone}: ${shown}, ${worst.max_degrees}`);
    const colored = await page.locator("#view").screenshot();
    await page.keyboard.press("e");
    await settled(page);
    assert.ok(!colored.equals(await page.locator("#view").screenshot()));
    assert.deepEqual(trouble, []);
    await close();
  });

  check("--character shows a motion on a figure with a skin", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(walk, "--character", fixture("../characters/human_vrm0.vrm")));
    await page.evaluate(() => window.mocap.ready);
    assert.ok(await page.isVisible("#skin"));
    assert.match(await page.textContent("h1"), /cmu_12_01_walk on human_vrm0/);
    // The first of the 524 frames of the walk, a rest pose, is omitted: 523 frames remain, from tick 0 to 522.
    assert.equal(await page.getAttribute("#scrub", "max"), "522");
    // VRM 0 faces -Z, but the page still shows it from the front.
    const [hips, toes] = await page.evaluate(() => {
      const { nodes, drawn } = window.mocap.state.clips[0];
      return ["leftFoot", "leftToes"].map((name) => drawn[nodes.findIndex(({ bone }) => bone?.name === name)]);
    });
    assert.ok(toes[2] > hips[2], `toes at ${toes}, the foot at ${hips}`);
    assert.deepEqual(trouble, []);
    await close();
  });

  check("a phone has room for everything that a figure with a skin has", async (browser) => {
    const phone = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };
    const { page, trouble, close } = await open(browser, pageOfFiles(walk, "--character", fixture("../characters/human_vrm0.vrm")), phone);
    for (const id of ["skin", "skeleton", "bones", "contacts", "errors", "play", "loop"]) {
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box && box.x >= 0 && box.x + box.width <= 390 && box.y + box.height <= 780, id);
    }
    await page.tap("#skin");
    await page.waitForFunction(() => !window.mocap.state.skin);
    assert.deepEqual(trouble, []);
    await close();
  });
}
