// Uses the pages of `mocap view` as a person does, and compares their drawing with `mocap pose`.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { appendFileSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { Sample } from "../interop/sample.js";
import { savePicture } from "../chromium.mjs";
import { launch, open, settled } from "./browser.js";
import { chainChecks } from "./chain_checks.js";
import { filmChecks } from "./film_checks.js";
import { markChecks } from "./mark_checks.js";
import { skinChecks } from "./skin_checks.js";

const { values } = parseArgs({
  options: { all: { type: "boolean", default: false }, only: { type: "string", default: "" }, pictures: { type: "boolean", default: false } },
});
const sample = Sample.chosen(values.all);

const FILES = ["lecture_Test", "cmu_12_01_walk", "z_up_dab", "mocopi_jump_six_channels", "leap_hand_end_site_lowercase"];
/** As a fraction of the figure's height. */
const MAX_ERROR = 1e-3;

const fixture = (name) => fileURLToPath(new URL(`../../fixtures/real/${name.includes(".") ? name : `${name}.bvh`}`, import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "mocap-view-"));
const PICTURES = "pictures of the documents";
const only = values.pictures ? PICTURES : values.only;

function mocap(...args) {
  return execFileSync(process.env.MOCAP, args, { encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "pipe"] });
}

/** Writes a page of some files and returns its address; options begin with a dash. */
function pageOfFiles(...files) {
  const path = join(folder, `${files.map((file) => basename(file)).join("+")}.html`);
  mocap("view", ...files, "-o", path);
  return pathToFileURL(path).href;
}

const pageOf = (...names) => pageOfFiles(...names.map(fixture));

/** Writes a file and a page of it, and returns both. */
function pageOfText(name, text, ...options) {
  const [file, path] = [join(folder, name), join(folder, `${name}.html`)];
  writeFileSync(file, text);
  mocap("view", file, ...options, "-o", path);
  return { file, path, address: pathToFileURL(path).href };
}

/** The folder of such a file. */
pageOfText.path = (name) => join(folder, name);

const worldPositions = (name, tick) => filePositions(fixture(name), tick);
const filePositions = (file, tick) =>
  JSON.parse(mocap("pose", file, "--tick", String(tick), "--world", "--json")).nodes.map((node) => node.translation);

/** The largest distance between two lists of positions, as a fraction of the extent of the second list. */
function difference(found, expected) {
  assert.equal(found.length, expected.length);
  const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const extent = Math.max(...expected.map((place) => distance(place, expected[0])));
  return Math.max(...found.map((place, i) => distance(place, expected[i]))) / extent;
}

const tick = async (page) => Number(await page.inputValue("#scrub"));
const chosen = (page) => page.evaluate(() => window.mocap.state.joint);
const pressed = (page, id) => page.getAttribute(`#${id}`, "aria-pressed");
const jointNamed = (page, name) => page.evaluate((name) => window.mocap.state.clips[0].nodes.findIndex((node) => node.name === name), name);
const jointPlace = (page, joint, clip = 0) => page.evaluate(([j, c]) => window.mocap.onPage(j, c), [joint, clip]);

/** Taps again, as a person does, if a page that is busy drawing missed the first touch. */
async function tapUntil(page, selector, taken) {
  for (let tries = 1; ; tries++) {
    await page.tap(selector);
    try {
      return await page.waitForFunction(taken, null, { timeout: 5000 });
    } catch (error) {
      if (tries === 3) throw error;
    }
  }
}

const checks = [];
const check = (name, run) => name.includes(only) && checks.push([name, run]);

for (const [turn, renderer] of ["WebGL", "Canvas 2D"].entries()) {
  for (const name of sample.share(FILES, turn, FILES.length)) {
    check(`${name}: what ${renderer} draws is what the library says`, async (browser) => {
      const address = pageOf(name) + (renderer === "WebGL" ? "" : "#canvas2d");
      const { page, trouble, close } = await open(browser, address);
      assert.equal(await page.evaluate(() => window.mocap.renderer), renderer);
      const last = Number(await page.getAttribute("#scrub", "max"));
      for (const at of new Set([0, 1, Math.floor(last / 3), last / 2, last - 1, last])) {
        await page.evaluate((tick) => window.mocap.seek(tick), at);
        await settled(page);
        const drawn = await page.evaluate(() => window.mocap.drawn());
        const error = difference(drawn, worldPositions(name, at));
        assert.ok(error < MAX_ERROR, `tick ${at}: ${error} of the height`);
      }
      assert.deepEqual(trouble, []);
      await close();
    });
  }
}

check("something is drawn, and moves", async (browser) => {
  for (const hash of ["", "#canvas2d"]) {
    const { page, close } = await open(browser, pageOf("cmu_12_01_walk") + hash);
    const first = await page.locator("#view").screenshot();
    await page.keyboard.press("End");
    await settled(page);
    const last = await page.locator("#view").screenshot();
    assert.ok(!first.equals(last));
    assert.ok(first.length > 10_000, `a picture of ${first.length} bytes is empty`);
    await close();
  }
});

check("play goes at the speed of life, faster and slower, and stops", async (browser) => {
  const { page, close } = await open(browser, pageOf("mocopi_jump_six_channels"));
  const atFrame = () => page.evaluate(() => new Promise((done) => requestAnimationFrame((now) => done([window.mocap.state.time, now]))));
  const pace = async () => {
    const [before, start] = await atFrame();
    await page.waitForTimeout(1500);
    const [after, end] = await atFrame();
    return (after - before) / ((end - start) / 1000);
  };
  await page.click("#play");
  const one = await pace();
  await page.selectOption("#speed", "2");
  const two = await pace();
  await page.keyboard.press("Escape");
  await page.click("#play");
  assert.ok(Math.abs(one - 1) < 0.1, `${one} seconds a second`);
  assert.ok(Math.abs(two - 2) < 0.2, `${two} seconds a second`);
  assert.equal(await pace(), 0);
  await close();
});

check("keys play, step, seek, loop and choose", async (browser) => {
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"));
  // The page opens after the T-pose in the first frame.
  assert.equal(await tick(page), 1);
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowLeft");
  await settled(page);
  assert.equal(await tick(page), 2);
  await page.keyboard.press("Shift+ArrowRight");
  await settled(page);
  assert.equal(await tick(page), 12);
  await page.keyboard.press("End");
  await settled(page);
  assert.equal(await tick(page), 523);
  await page.keyboard.press("l");
  assert.equal(await pressed(page, "loop"), "false");
  await page.keyboard.press("Home");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.mocap.state.time > 0.1);
  await page.keyboard.press("Space");
  await page.keyboard.press("/");
  await page.keyboard.type("rightfoot");
  assert.equal(await page.locator("#tree > div:visible").count(), 1);
  await page.keyboard.press("Enter");
  assert.equal(await page.textContent("#joint-name"), "RightFoot");
  await page.keyboard.press("Escape");
  await page.keyboard.press("j");
  assert.equal(await page.textContent("#joint-name"), "RightToeBase");
  await page.keyboard.press("t");
  assert.equal(await pressed(page, "trail"), "true");
  const theme = await page.getAttribute("html", "data-theme");
  await page.keyboard.press("n");
  assert.notEqual(await page.getAttribute("html", "data-theme"), theme);
  await page.keyboard.press("?");
  assert.ok(await page.isVisible("#help"));
  await page.keyboard.press("Escape");
  assert.ok(!(await page.isVisible("#help")));
  assert.deepEqual(trouble, []);
  await close();
});

check("the tree is walked and chosen in by keys", async (browser) => {
  const { page, close } = await open(browser, pageOf("lecture_Test"));
  await page.focus("#tree > div");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  assert.equal(await page.getAttribute("#tree > div:nth-child(2)", "aria-selected"), "true");
  assert.equal(await page.textContent("#joint-name"), "Elbow");
  await close();
});

check("a mouse hovers, chooses, turns, moves, zooms and scrubs", async (browser) => {
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"));
  await page.keyboard.press("f");
  const hand = await jointNamed(page, "LeftHand");
  const [x, y] = await jointPlace(page, 4);
  await page.mouse.move(x, y);
  await settled(page);
  assert.match(await page.textContent("#tip"), /^LeftFoot\nleftFoot, sure: .*\nlocal .*\nworld /);
  await page.mouse.click(x, y);
  assert.equal(await page.textContent("#joint-name"), "LeftFoot");
  for (const [act, what] of [
    // A point beside the foot, because a press on the foot would drag it.
    [async () => { await page.mouse.move(x + 60, y); await page.mouse.down(); await page.mouse.move(x + 90, y + 30, { steps: 4 }); await page.mouse.up(); }, "turned"],
    [async () => { await page.keyboard.down("Shift"); await page.mouse.down(); await page.mouse.move(x, y, { steps: 4 }); await page.mouse.up(); await page.keyboard.up("Shift"); }, "moved"],
    [async () => { await page.mouse.wheel(0, -300); }, "zoomed"],
  ]) {
    const before = await jointPlace(page, hand);
    await act();
    await settled(page);
    const after = await jointPlace(page, hand);
    assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) > 5, `not ${what}`);
  }
  assert.equal(await page.textContent("#joint-name"), "LeftFoot");
  const bar = await page.locator("#scrub").boundingBox();
  await page.mouse.click(bar.x + bar.width / 2, bar.y + bar.height / 2);
  await settled(page);
  assert.ok(Math.abs((await tick(page)) - 261) < 15, `tick ${await tick(page)}`);
  await page.locator("#euler-curves").scrollIntoViewIfNeeded();
  const curves = await page.locator("#euler-curves").boundingBox();
  await page.mouse.click(curves.x + curves.width / 4, curves.y + 10);
  await settled(page);
  assert.ok(Math.abs((await tick(page)) - 131) < 5, `tick ${await tick(page)}`);
  assert.deepEqual(trouble, []);
  await close();
});

check("fingers choose, turn and pinch on a phone", async (browser) => {
  const phone = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"), phone);
  const size = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(size[0] <= size[1], "the page is wider than the phone");
  const hand = await jointNamed(page, "LeftHand");
  const [x, y] = await jointPlace(page, 10);
  await page.touchscreen.tap(x, y);
  await page.waitForFunction(() => window.mocap.state.joint >= 0);
  assert.ok(await page.isVisible("#position-curves"));
  await page.tap("#all-joints");
  await page.tap("#panel-button");
  assert.ok(!(await page.isVisible("#tree")));
  const touch = await page.context().newCDPSession(page);
  const send = (type, points) =>
    touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const before = await jointPlace(page, hand);
  await send("touchStart", [[180, 200]]);
  await send("touchMove", [[230, 200]]);
  await send("touchMove", [[280, 210]]);
  await send("touchEnd", []);
  await settled(page);
  const turned = await jointPlace(page, hand);
  assert.ok(Math.hypot(turned[0] - before[0], turned[1] - before[1]) > 5, "not turned");
  const spread = async () => {
    const [a, b] = [await jointPlace(page, 0), await jointPlace(page, hand)];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  const small = await spread();
  await send("touchStart", [[170, 200], [220, 200]]);
  await send("touchMove", [[140, 200], [250, 200]]);
  await send("touchMove", [[110, 200], [280, 200]]);
  await send("touchEnd", []);
  await settled(page);
  assert.ok((await spread()) > 1.5 * small, "not zoomed");
  await tapUntil(page, "#panel-button", () => document.querySelector("#panel").classList.contains("open"));
  await page.tap("#tree > div:nth-child(1)");
  assert.equal(await page.textContent("#joint-name"), "Hips");
  const curves = await page.locator("#position-curves").boundingBox();
  assert.ok(curves.y > 0 && curves.y + curves.height < 780, `curves from ${curves.y} on`);
  await page.tap("#play");
  await page.waitForFunction(() => window.mocap.state.time > 0.1);
  assert.deepEqual(trouble, []);
  await close();
});

check("the chain names the lines of the file, and the values of the tick", async (browser) => {
  const { page, close } = await open(browser, pageOf("lecture_Test"));
  await page.keyboard.press("End");
  await page.click("#tree > div:nth-child(3)");
  await settled(page);
  assert.equal((await page.textContent("#chain-product")).trim(), "T = J0 L1 J1 L2 J2");
  const rows = await page.locator("#chain tr").evaluateAll((rows) =>
    rows.map((row) => [...row.children].slice(2).map((cell) => cell.textContent.replaceAll("\u00a0", " "))));
  // The last row of the file is 1.0 0.18 0 50 0 0 100 0 0 80 0 0.
  assert.deepEqual(rows, [
    ["5", "1  0.18  0  ·  Z 50°  Y 0°  X 0°"],
    ["8", "2  0  0"],
    ["9", "Z 100°  Y 0°  X 0°"],
    ["12", "1.5  0  0"],
    ["13", "Z 80°  Y 0°  X 0°"],
  ]);
  const [wrist] = worldPositions("lecture_Test", 9).slice(2, 3);
  const shown = (await page.textContent("#world-position")).replaceAll("−", "-").trim().split(/\s+/).map(Number);
  shown.forEach((value, axis) => assert.ok(Math.abs(value - wrist[axis]) < 1e-3, `${shown} is not ${wrist}`));
  await close();
});

check("several files stand side by side, or over one another where their files put them", async (browser) => {
  const names = ["cmu_12_01_walk", "mocopi_jump_six_channels", "z_up_dab"];
  const { page, trouble, close } = await open(browser, pageOf(...names));
  const roots = async () => Promise.all(names.map((_, clip) => jointPlace(page, 0, clip)));
  const apart = await roots();
  assert.ok(apart[1][0] - apart[0][0] > 60 && apart[2][0] - apart[1][0] > 60, "not side by side");
  await page.click("#arrange");
  await settled(page);
  assert.deepEqual(await page.evaluate(() => window.mocap.state.clips.flatMap(({ shift }) => shift)), Array(9).fill(0), "not overlaid");
  await page.click("#files .file:nth-child(2) .file-name");
  await page.evaluate(() => window.mocap.seek(300));
  await settled(page);
  // One time for all: 300 ticks of the second clip are 5 seconds, which is after the end of the first.
  for (const [clip, at] of [[0, 523], [1, 300], [2, 150]]) {
    const drawn = await page.evaluate((clip) => window.mocap.drawn(clip), clip);
    assert.ok(difference(drawn, worldPositions(names[clip], at)) < MAX_ERROR, names[clip]);
  }
  const [x, y] = await jointPlace(page, 5, 2);
  await page.mouse.click(x, y);
  assert.ok((await chosen(page)) >= 0);
  assert.deepEqual(trouble, []);
  await close();
});

check("one time line for all clips: each is as long as it is, and the longest is the end", async (browser) => {
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk", "mocopi_jump_six_channels"));
  const seconds = () => page.evaluate(() => window.mocap.state.time);
  // 801 ticks of the second clip at 60 a second are 1602 of the first at 120.
  assert.equal(Number(await page.getAttribute("#scrub", "max")), 1602);
  for (const focus of ["#stage", "#scrub", "#tree > div", "#play", "#speed"]) {
    await page.focus(focus);
    await page.keyboard.press("End");
    await settled(page);
    assert.ok(Math.abs((await seconds()) - 801 / 60) < 1e-3, `${focus}: ${await seconds()} s`);
    assert.match(await page.textContent("#tick"), /^tick 523 \/ 523, over$/);
    await page.keyboard.press("Home");
    assert.equal(await seconds(), 0, focus);
  }
  const lanes = await page.locator("#lanes span").evaluateAll((lanes) => lanes.map((lane) => lane.getBoundingClientRect().width));
  assert.ok(Math.abs(lanes[0] / lanes[1] - 523 / 120 / (801 / 60)) < 0.02, `${lanes}`);
  await page.focus("#search");
  await page.keyboard.type("ab");
  await page.keyboard.press("Home");
  await page.keyboard.type("c");
  assert.equal(await page.inputValue("#search"), "cab");
  assert.deepEqual(trouble, []);
  await close();
});

check("the camera looks at the middle of any figure", async (browser) => {
  for (const name of sample.some(["run.fbx", "huesitos.fbx", "py_c3d_motion.c3d", "optotrak.c3d", "hand_take.c3d", "z_up_dab", "slimevr_headset_root"], 3)) {
    const { page, trouble, close } = await open(browser, pageOf(name));
    const places = await page.evaluate(() => window.mocap.state.clips[0].nodes.flatMap((node, joint) => (node.inBody ? [window.mocap.onPage(joint)] : [])));
    const box = await page.locator("#stage").boundingBox();
    for (const [axis, size] of [[0, box.width], [1, box.height]]) {
      const along = places.map((place) => (place[axis] - [box.x, box.y][axis]) / size);
      const [low, high] = [Math.min(...along), Math.max(...along)];
      assert.ok(low > 0 && high < 1, `${name} is outside the picture: ${low} to ${high}`);
      assert.ok(Math.abs((low + high) / 2 - 0.5) < 0.12, `${name} is not in the middle: ${low} to ${high}`);
    }
    assert.deepEqual(trouble, []);
    await close();
  }
});

check("the bones of a humanoid have colours and names, and none where there is no humanoid", async (browser) => {
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"));
  const labels = () => page.locator("#labels span:visible").allTextContents();
  assert.ok((await labels()).includes("leftLowerLeg"));
  assert.ok(await page.isVisible("#bone-legend"));
  assert.match(await page.locator("#tree > div").nth(await jointNamed(page, "LeftLeg")).textContent(), /leftLowerLeg$/);
  const shown = await page.locator("#view").screenshot();
  await page.keyboard.press("b");
  await settled(page);
  assert.deepEqual(await labels(), []);
  assert.ok(!(await page.isVisible("#bone-legend")));
  assert.ok(!shown.equals(await page.locator("#view").screenshot()));
  await page.fill("#search", "leftlowerleg");
  assert.equal(await page.locator("#tree > div:visible").count(), 1);
  assert.deepEqual(trouble, []);
  await close();
  const hand = await open(browser, pageOf("leap_hand_end_site_lowercase"));
  assert.ok(!(await hand.page.isVisible("#bones")) && !(await hand.page.isVisible("#bone-legend")));
  await hand.close();
});

check("names of a file stay text", async (browser) => {
  const names = ["</script><img/src=x>", "a\u202eb", "c\u0007\u001b[2J", "-->&amp;"];
  const joints = names.reduceRight((inner, name) => `JOINT ${name}\n{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n${inner || "End Site\n{\nOFFSET 0 1 0\n}\n"}}\n`, "");
  const text = `HIERARCHY\n${joints.replace("JOINT", "ROOT")}MOTION\nFrames: 2\nFrame Time: 0.1\n${"0 ".repeat(12)}\n${"5 ".repeat(12)}\n`;
  const { address } = pageOfText("a<b>&\u202e'{{keys}}.bvh", text);
  const { page, trouble, close } = await open(browser, address);
  const tree = (await page.locator("#tree > div").allTextContents()).slice(0, names.length);
  assert.deepEqual(tree, ["</script><img/src=x>", "a\\u{202e}b", "c\\u{7}\\u{1b}[2J", "-->&amp;"]);
  assert.equal(await page.textContent("h1"), "a<b>&\\u{202e}'{{keys}}");
  assert.equal(await page.locator("img").count(), 0);
  assert.deepEqual(trouble, []);
  await close();
});

check("--trim and --fps show a part, and other frames", async (browser) => {
  const text = readFileSync(fixture("cmu_12_01_walk"));
  const { file, address } = pageOfText("part.bvh", text, "--trim", "120f..240f", "--fps", "30");
  const { page, close } = await open(browser, address);
  assert.equal(await page.getAttribute("#scrub", "max"), "30");
  for (const [at, source] of [[0, 120], [30, 240]]) {
    await page.evaluate((tick) => window.mocap.seek(tick), at);
    await settled(page);
    const error = difference(await page.evaluate(() => window.mocap.drawn()), filePositions(file, source));
    assert.ok(error < MAX_ERROR, `tick ${at}: ${error}`);
  }
  await close();
});

check("a long take is packed, within the bound that the page states, and its curves are drawn", async (browser) => {
  const [head, rows] = readFileSync(fixture("cmu_01_01"), "latin1").split(/(?<=Frame Time:.*\n)/);
  const times = Math.ceil(9000 / rows.trim().split("\n").length);
  const long = `${head.replace(/(?<=Frames:\s*)\d+/, (count) => count * times)}${`${rows.trim()}\n`.repeat(times)}`;
  const { file, path, address } = pageOfText("long.bvh", long);
  const packed = [...readFileSync(path, "latin1").matchAll(/id="clip-0-\d+">([^<]*)/g)].reduce((sum, [, text]) => sum + text.length, 0);
  assert.ok(packed < 0.15 * long.length, `${packed} characters for ${long.length} of BVH`);
  const { page, trouble, close } = await open(browser, address);
  const [last, stated, metres] = await page.evaluate(() => [window.mocap.state.clips[0].duration, window.mocap.state.clips[0].packingError, window.mocap.state.clips[0].metresPerUnit]);
  assert.ok(stated > 0 && stated < 2e-4, `${stated} m`);
  assert.match(await page.textContent(".facts"), /keys packed, joints within 0\.\d+ mm of the file/);
  let largest = 0;
  for (const at of [last, 0, 4097, Math.floor(last / 2)]) {
    await page.evaluate((tick) => window.mocap.seek(tick), at);
    await settled(page);
    const expected = filePositions(file, at);
    const drawn = await page.evaluate(() => window.mocap.drawn());
    const distances = drawn.map((place, i) => metres * Math.hypot(...place.map((value, axis) => value - expected[i][axis])));
    largest = Math.max(largest, ...distances);
  }
  // The numbers of `mocap pose` have six digits.
  assert.ok(largest <= stated + 1e-5, `${largest} m, the page states ${stated} m`);
  assert.ok(largest > 0);
  await page.keyboard.press("j");
  await page.waitForFunction(() => window.mocap.state.clips[0].cached?.complete);
  assert.deepEqual(trouble, []);
  await close();
});

// Only with `--all`, because this check writes 300 MB.
if (values.all) check("the page of an hour has about 20 MB, within the bound that it states, and plays", async (browser) => {
  const [head, text] = readFileSync(fixture("cmu_01_01"), "latin1").split(/(?<=Frame Time:.*\n)/);
  const rows = text.trim().split("\n").map((row) => row.trim().split(/\s+/).map(Number));
  const HOUR = 3600 * 120;
  // Forth and back with a slow sway, so that no two rounds are equal.
  const rowAt = (frame) => {
    const [at, sway] = [frame % (2 * rows.length), Math.sin(frame / 7001)];
    return rows[at < rows.length ? at : 2 * rows.length - 1 - at].map((value, column) => (value + 0.3 * sway * ((column % 5) - 2)).toFixed(4)).join(" ");
  };
  const path = pageOfText.path("hour.bvh");
  writeFileSync(path, head.replace(/(?<=Frames:\s*)\d+/, HOUR));
  for (let first = 0; first < HOUR; first += 10_000) {
    appendFileSync(path, Array.from({ length: Math.min(10_000, HOUR - first) }, (_, row) => `${rowAt(first + row)}\n`).join(""));
  }
  const address = pageOfFiles(path);
  const { size } = statSync(fileURLToPath(address));
  assert.ok(size < 21e6, `${size} bytes`);
  const { page, trouble, close } = await open(browser, address);
  const [stated, metres] = await page.evaluate(() => [window.mocap.state.clips[0].packingError, window.mocap.state.clips[0].metresPerUnit]);
  assert.ok(stated > 0 && stated < 1.5e-3, `${stated} m`);
  for (const at of [0, 4127, 4128, 200_000, HOUR - 1]) {
    await page.evaluate((tick) => window.mocap.seek(tick), at);
    await settled(page);
    const expected = filePositions(path, at);
    const drawn = await page.evaluate(() => window.mocap.drawn());
    const largest = Math.max(...drawn.map((place, i) => metres * Math.hypot(...place.map((value, axis) => value - expected[i][axis]))));
    assert.ok(largest <= stated + 1e-5, `tick ${at}: ${largest} m, the page states ${stated} m`);
  }
  await page.keyboard.press(" ");
  await page.waitForFunction((before) => window.mocap.state.time > before, await page.evaluate(() => window.mocap.state.time));
  assert.deepEqual(trouble, []);
  await close();
});

check("the download is a GLB", async (browser) => {
  const { page, trouble, close } = await open(browser, pageOf("cmu_12_01_walk"));
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#download")]);
  assert.equal(download.suggestedFilename(), "cmu_12_01_walk.glb");
  const bytes = readFileSync(await download.path());
  assert.equal(bytes.toString("latin1", 0, 4), "glTF");
  assert.equal(bytes.readUInt32LE(8), bytes.length);
  assert.deepEqual(trouble, []);
  await close();
});

check("a folder's list opens its clips", async (browser) => {
  const path = join(folder, "list.html");
  // Some fixtures cannot be read, which gives exit code 3.
  assert.throws(() => mocap("view", fileURLToPath(new URL("../../fixtures/real", import.meta.url)), "-o", path), { status: 3 });
  const { page, trouble, close } = await open(browser, pathToFileURL(path).href);
  const cards = await page.locator("[data-name]").count();
  assert.ok(cards > 20);
  assert.match(await page.locator("[data-name='cmu_12_01_walk.bvh']").textContent(), /4\.36 s, 524 frames/);
  assert.match(await page.locator("[data-name='brackets_in_numbers.bvh']").textContent(), /is not a number/);
  await page.fill("input", "walk");
  assert.ok((await page.locator("[data-name]:visible").count()) < cards);
  assert.deepEqual(trouble, []);
  await page.click("[data-name='cmu_12_01_walk.bvh'] a");
  await page.waitForFunction(() => window.mocap?.drawn().length > 30);
  await close();
});

check("a page opens without a word whatever is in the file", async (browser) => {
  // Small files, still files, files without motion, with motion of every joint, with several roots, and unusual files.
  const path = join(folder, "dialects.html");
  mocap("view", fileURLToPath(new URL("../../fixtures/dialects", import.meta.url)), "-o", path);
  const list = await open(browser, pathToFileURL(path).href);
  const links = await list.page.locator("[data-name] a").evaluateAll((links) => links.map((link) => link.href));
  await list.close();
  assert.ok(links.length > 60);
  for (const link of sample.some(links, 8)) {
    const { page, trouble, close } = await open(browser, `${link}#canvas2d`);
    await page.keyboard.press("Space");
    await page.keyboard.press("k");
    await page.keyboard.press("t");
    await settled(page);
    const places = (await page.evaluate(() => window.mocap.drawn())).flat();
    assert.ok(places.length > 0 && places.every(Number.isFinite), link);
    assert.deepEqual(trouble, [], link);
    await close();
  }
});

check("every control has a name, and words stand out from what is behind them", async (browser) => {
  for (const colorScheme of ["light", "dark"]) {
    const { page, close } = await open(browser, pageOf("cmu_12_01_walk"), { colorScheme });
    await page.keyboard.press("j");
    const faults = await page.evaluate(() => {
      const channels = (color) => color.match(/[\d.]+/g).map(Number);
      const luminance = (color) => {
        const [r, g, b] = channels(color).map((part) => part / 255).map((part) => (part <= 0.03928 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
      };
      const behind = (element) => {
        for (let e = element; e; e = e.parentElement) {
          const color = getComputedStyle(e).backgroundColor;
          if (/^rgb\(/.test(color)) return color;
        }
        return "rgb(255, 255, 255)";
      };
      const faults = [];
      for (const element of document.querySelectorAll("button, input, select, canvas")) {
        const label = element.ariaLabel || element.textContent.trim() || element.labels?.[0]?.textContent;
        if (!label) faults.push(`no name: ${element.outerHTML}`);
      }
      for (const element of document.querySelectorAll("body *:not(script, option)")) {
        const hasText = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
        if (!hasText || !element.checkVisibility() || element.disabled) continue;
        const [a, b] = [luminance(getComputedStyle(element).color), luminance(behind(element))];
        const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        if (contrast < 4.5) faults.push(`contrast ${contrast.toFixed(2)}: ${element.textContent.trim().slice(0, 30)}`);
      }
      return faults;
    });
    assert.deepEqual(faults, [], colorScheme);
    await close();
  }
});

for (const more of [chainChecks, skinChecks, markChecks, filmChecks]) more({ check, sample, open, mocap, pageOf, pageOfFiles, pageOfText, fixture });

if (values.pictures) {
  check(PICTURES, async (browser) => {
    const take = async (document, address, options, tick, act) => {
      const { page, close } = await open(browser, address, { reducedMotion: "reduce", ...options });
      await page.evaluate((tick) => window.mocap.seek(tick), tick);
      await settled(page);
      await act(page);
      await settled(page);
      await savePicture(page, fileURLToPath(new URL(`../../${document}`, import.meta.url)));
      await close();
    };
    const walk = fixture("cmu_12_01_walk");
    await take("fixtures/pictures/view.png", pageOfFiles(walk), {}, 200, async (page) => {
      await page.mouse.click(...(await jointPlace(page, 3)));
      await page.keyboard.press("t");
      await page.mouse.move(20, 400);
    });
    const hero = join(folder, "hero_walk.glb");
    mocap("retarget", walk, fixture("../characters/human_game_engine.glb"), "-o", hero);
    await take("docs/player-compared.png", pageOfFiles(walk, hero), {}, 200, async () => {});
    await take("docs/how-to/lecture.png", pageOf("lecture_Test"), { viewport: { width: 1000, height: 880 } }, 4, async (page) => {
      await page.click("#tree > div:nth-child(4)");
      for (let matrices = 0; matrices < 3; matrices++) await page.keyboard.press("v");
      await page.evaluate(() => document.querySelector("#chain-product").scrollIntoView());
    });
  });
}

let browser = await launch();

/** Runs a check, and returns its faults. After a fault, the next check has a new browser. */
async function faultOf(run) {
  try {
    await run(browser);
    return null;
  } catch (error) {
    await browser.close();
    browser = await launch();
    return String(error.message).replaceAll("\n", "\n        ");
  }
}

let failed = 0;
/** A third of the checks, unless the command names some or has `--all`. Checks use the seed modulo 2 to 8 to select
 * files. 840 is a multiple of these numbers, so the choice of checks does not depend on the choice of files. */
const chosenChecks =
  values.all || only ? checks : new Sample(false, Math.floor(sample.seed / 840)).some(checks, 3);
for (const [name, run] of chosenChecks) {
  const start = performance.now();
  let fault = await faultOf(run);
  if (fault) {
    // On a busy machine, a browser that draws in software sometimes loses a touch or a frame. The check prints this.
    console.log(`again   ${name}\n        ${fault}`);
    fault = await faultOf(run);
  }
  if (fault) failed++;
  const seconds = ((performance.now() - start) / 1000).toFixed(1);
  console.log(fault ? `FAILED  ${name}\n        ${fault}` : `ok      ${name}, ${seconds} s`);
}
await browser.close();
rmSync(folder, { recursive: true });
console.log(`${chosenChecks.length - failed} passed, ${failed} failed`);
process.exitCode = failed ? 1 : 0;
