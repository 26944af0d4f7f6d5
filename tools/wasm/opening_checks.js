// Checks how the drop page opens files: playing, combining a motion and a character, the list, and the picture.

import assert from "node:assert/strict";
import { cpSync, readFileSync } from "node:fs";
import { join } from "node:path";

export function openingChecks(pageCheck, { open, fixture, folder, program }) {
  const playing = (page) => page.evaluate(() => window.mocap.state.clips.map(({ name }) => name));
  /** The smallest and largest position of the figure's joints in the picture, from 0 (left, top) to 1 (right, bottom). */
  const inPicture = (page) => page.evaluate(() => {
    const { player } = window.desk;
    const { clip, stage, canvas } = player;
    stage.draw();
    const places = clip.drawn.filter((_, id) => clip.nodes[id].inBody).map((place) => stage.onCanvas(place));
    const of = (axis, size) => [Math.min(...places.map((place) => place[axis])) / size, Math.max(...places.map((place) => place[axis])) / size];
    return [...of(0, canvas.clientWidth), ...of(1, canvas.clientHeight)];
  });
  const isWithin = (parts) => parts.every((part) => part > 0 && part < 1);
  const chooseRow = async ({ page, idle }, name) => {
    await page.click(`#opened .item >> text="${name}"`);
    await idle();
  };

  pageCheck("a motion plays on opening, after its rest pose, and not where the system asks for stillness", async (browser) => {
    const { page, drop, trouble } = await open(browser, { reducedMotion: "no-preference" });
    await page.evaluate(() => { window.desk.player.advance = (seconds) => { (window.advanced ??= []).push(seconds); }; });
    await drop(fixture("real/cmu_12_01_walk.bvh"));
    const { isPlaying, tick, steps } = await page.evaluate(() => ({ isPlaying: window.mocap.state.playing, tick: window.desk.player.tick, steps: window.advanced }));
    assert.equal(isPlaying, true);
    assert.ok(Math.abs(tick - 1) < 1e-6, `it starts at tick ${tick}, and tick 0 is the rest pose`);
    assert.equal(steps[0], 0, "the first picture is of the start");
    assert.ok(isWithin(await inPicture(page)));
    assert.deepEqual(trouble, []);
    const still = await open(browser);
    await still.drop(fixture("real/cmu_12_01_walk.bvh"));
    assert.equal(await still.page.evaluate(() => window.mocap.state.playing), false);
  });

  pageCheck("the figure stays in the picture when unit, up and time change", async (browser) => {
    const { page, drop, idle, trouble } = await open(browser);
    await drop(fixture("real/cmu_12_01_walk.bvh"));
    await page.evaluate(() => window.mocap.seek(400));
    for (const [control, value] of [["#unit", "m"], ["#unit", "mm"], ["#up", "z"], ["#up", "-y"], ["#unit", ""]]) {
      await page.selectOption(control, value);
      await idle();
      assert.ok(isWithin(await inPicture(page)), `${control} ${value}: ${await inPicture(page)}`);
      assert.ok(Math.abs(await page.evaluate(() => window.desk.player.tick) - 400) < 1e-6);
    }
    assert.deepEqual(trouble, []);
  });

  pageCheck("Frame sees the skin whole", async (browser) => {
    const { page, drop, trouble } = await open(browser);
    await drop(fixture("characters/human_vrm0.vrm"));
    // Compute the position of every vertex in the picture with the renderer's matrices.
    const parts = await page.evaluate(() => {
      const { stage, clip } = window.desk.player;
      stage.frameAll();
      stage.draw();
      const [low, high] = stage.boxOf(clip);
      const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0, 1, 2].map((axis) => (bits >> axis) & 1 ? high[axis] : low[axis]));
      const joints = clip.drawn.reduce((most, place) => Math.max(most, place[1]), -Infinity);
      const canvas = window.desk.player.canvas;
      return { isAbove: high[1] > joints, places: corners.map((corner) => stage.onCanvas(corner)).map(([x, y]) => [x / canvas.clientWidth, y / canvas.clientHeight]) };
    });
    assert.ok(parts.isAbove, "the skin of the head is above its joints");
    assert.ok(isWithin(parts.places.flat()), String(parts.places));
    assert.deepEqual(trouble, []);
  });

  pageCheck("a character is greeted as one, and what is dropped on the figure goes on it", async (browser) => {
    const { page, drop, dropOnFigure, items, trouble, picture } = await open(browser);
    await drop(fixture("characters/human_default.glb"));
    const [character] = await items();
    assert.match(character.summary, /^a character, \d+ joints$/);
    assert.match(await page.textContent("#chosen-facts"), /Drop a motion on the figure/);
    assert.equal(await page.isVisible("#findings"), false, "that it has no motion is no warning");
    await picture("character");
    await dropOnFigure(fixture("real/cmu_12_01_walk.bvh"));
    assert.deepEqual(await playing(page), ["cmu_12_01_walk on human_default"]);
    // A new character takes over the motion, and a new motion keeps the character.
    await dropOnFigure(fixture("characters/human_vrm0.vrm"));
    assert.deepEqual(await playing(page), ["cmu_12_01_walk on human_vrm0"]);
    await dropOnFigure(fixture("real/cmu_short.bvh"));
    assert.deepEqual(await playing(page), ["cmu_short on human_vrm0"]);
    // A file dropped beside the picture opens alone. A file that cannot be retargeted opens alone with a notice.
    await drop(fixture("real/z_up_dab.bvh"));
    assert.deepEqual(await playing(page), ["z_up_dab.bvh"]);
    await drop(fixture("characters/human_vrm0.vrm"), fixture("real/lecture_Test.bvh"));
    assert.match(await page.textContent("#notice"), /lecture_Test\.bvh cannot be retargeted to human_vrm0\.vrm/);
    assert.ok((await items()).every(({ state }) => state === "ok"));
    assert.deepEqual(trouble, []);
  });

  pageCheck("each file is in the list once, and goes from it by itself or with all", async (browser) => {
    const opened = await open(browser);
    const { page, drop, items, trouble } = opened;
    const names = async () => (await items()).map(({ name }) => name);
    await drop(fixture("real/lecture_Test.bvh"), fixture("real/cmu_short.bvh"), fixture("broken/empty.bvh"));
    await drop(fixture("real/cmu_short.bvh"));
    assert.deepEqual(await names(), ["cmu_short.bvh", "empty.bvh", "lecture_Test.bvh"]);
    // The details show the error, and a text names the file in the picture.
    await chooseRow(opened, "empty.bvh");
    assert.equal(await page.textContent("#not-shown"), "The picture shows cmu_short.bvh.");
    await page.click("[aria-label='Remove cmu_short.bvh from the list']");
    await opened.idle();
    assert.deepEqual(await names(), ["empty.bvh", "lecture_Test.bvh"]);
    await chooseRow(opened, "lecture_Test.bvh");
    assert.deepEqual(await playing(page), ["lecture_Test.bvh"]);
    await page.click("#remove-all");
    assert.deepEqual(await names(), []);
    assert.ok(await page.isVisible("#start-box"));
    await drop(fixture("real/cmu_short.bvh"));
    assert.deepEqual(await playing(page), ["cmu_short.bvh"]);
    assert.deepEqual(trouble, []);
  });

  pageCheck("what was stopped is no error, and is read again", async (browser) => {
    const { page, drop, idle, items, trouble } = await open(browser);
    const file = join(folder, "stopped.bvh");
    cpSync(fixture("real/lecture_Test.bvh"), file);
    await page.evaluate(() => {
      const { reader } = window.desk;
      const ask = reader.ask.bind(reader);
      reader.ask = (...request) => { const asked = ask(...request); reader.ask = ask; reader.stop(); return asked; };
    });
    await drop(file);
    assert.deepEqual((await items()).map(({ state, code }) => [state, code]), [["stopped", undefined]]);
    assert.equal(await page.textContent("#chosen-facts"), "Reading was stopped.");
    await page.click("#again");
    await idle();
    assert.equal((await items())[0].state, "ok");
    assert.deepEqual(trouble, []);
  });

  pageCheck("every clip of a file can be chosen", async (browser) => {
    const { page, drop, idle, trouble } = await open(browser);
    const [walk, short] = ["real/cmu_12_01_walk.bvh", "real/cmu_short.bvh"].map(fixture);
    const file = join(folder, "two_clips.glb");
    assert.ok(program("retarget", walk, short, fixture("characters/human_default.glb"), "-o", file), "the program puts no two motions on a character");
    await drop(file);
    assert.equal(await page.locator("#clip option").count(), 3);
    const frames = () => page.evaluate(() => window.mocap.state.clips[0].frames);
    // The expected frames are the frames of the BVH without the rest pose.
    const framesOf = (path) => Number(/Frames:\s*(\d+)/.exec(readFileSync(path, "latin1"))[1]);
    const whole = await frames();
    await page.selectOption("#clip", "1");
    await idle();
    assert.ok([0, 1].includes(framesOf(short) - await frames()), `${await frames()} of ${framesOf(short)}`);
    await page.selectOption("#clip", "0");
    await idle();
    assert.equal(await frames(), whole);
    assert.ok([0, 1].includes(framesOf(walk) - whole));
    assert.deepEqual(trouble, []);
  });
}
