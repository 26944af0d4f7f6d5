// Checks other outputs of the drop page: films, pictures, pages, archives, steps of a dragged hand, motions on robots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

/** The side in pixels of squares whose mean colours are compared: a film has half of a picture's colour resolution. */
const SQUARE = 20;
/** The largest error of a mean, out of 255: for the loss of a film of this size, and for the 256 colours of a GIF. */
const [OFF_FILM, OFF_GIF] = [6, 12];

/** The pictures of a film, decoded by ffmpeg: three bytes per pixel. */
function decoded(path) {
  const raw = execFileSync("ffmpeg", ["-v", "error", "-i", path, "-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], { maxBuffer: 1 << 30 });
  const size = execFileSync("ffprobe", ["-v", "error", "-select_streams", "v", "-show_entries", "stream=width,height", "-of", "csv=p=0", path], { encoding: "utf8" });
  const [width, height] = size.trim().split(",").map(Number);
  const length = 3 * width * height;
  return { width, height, pictures: Array.from({ length: raw.length / length }, (_, i) => raw.subarray(i * length, (i + 1) * length)) };
}

/** The mean of each colour component in each square. */
function squaresOf(pixels, width, height, stride, square) {
  const means = [];
  for (let top = 0; top + square <= height; top += square) {
    for (let left = 0; left + square <= width; left += square) {
      const sum = [0, 0, 0];
      for (let y = top; y < top + square; y++) {
        for (let x = left; x < left + square; x++) for (let part = 0; part < 3; part++) sum[part] += pixels[stride * (y * width + x) + part];
      }
      means.push(...sum.map((value) => value / square ** 2));
    }
  }
  return means;
}

/** The means of the picture `index` that the page draws for a film from 1 s to 2 s. Runs in the page. */
function drawnSquares([index, rate, width, height], square, squaresOf) {
  const { player } = window.desk;
  const { stage, canvas } = player;
  const [target, time] = [[...stage.camera.target], player.state.time];
  stage.size = [width, height];
  stage.before = null;
  for (let at = 0; at <= index; at++) {
    player.state.time = Math.min(2, 1 + at / rate);
    stage.draw();
  }
  const pen = new OffscreenCanvas(width, height).getContext("2d");
  pen.drawImage(canvas, 0, 0);
  stage.size = null;
  stage.camera.target = target;
  player.state.time = time;
  stage.before = null;
  return squaresOf(pen.getImageData(0, 0, width, height).data, width, height, 4, square);
}

/** The arrays of an uncompressed .npz: numbers, or text for names. */
function arraysOf(bytes) {
  const arrays = {};
  for (let at = 0; bytes.readUInt32LE(at) === 0x04034b50; ) {
    const [size, name] = [bytes.readUInt32LE(at + 18), bytes.readUInt16LE(at + 26)];
    const start = at + 30 + name + bytes.readUInt16LE(at + 28);
    const npy = bytes.subarray(start, start + size);
    const values = npy.subarray(10 + npy.readUInt16LE(8));
    const header = npy.toString("latin1", 10, 10 + npy.readUInt16LE(8));
    const isDoubles = /'<f8'/.test(header);
    arrays[bytes.toString("utf8", at + 30, at + 30 + name)] = isDoubles ? Array.from({ length: values.length / 8 }, (_, i) => values.readDoubleLE(8 * i)) : values;
    at = start + size;
  }
  return arrays;
}

export function savingChecks(pageCheck, { open, openPage, fixture, folder, program }) {
  /** Presses a button, and returns the path of the saved file. */
  const made = async (page, selector, name) => {
    const [download] = await Promise.all([page.waitForEvent("download", { timeout: 120_000 }), page.click(selector)]);
    const path = join(folder, name ?? download.suggestedFilename());
    await download.saveAs(path);
    return path;
  };

  pageCheck("an empty page plays a walk", async (browser) => {
    const { page, idle, items, trouble } = await open(browser);
    await page.click("#start-walk");
    await idle();
    const [walk] = await items();
    assert.deepEqual([walk.name, walk.state], ["walk.mclip", "ok"]);
    assert.equal(await page.evaluate(() => window.mocap.state.clips[0].humanoid), true);
    assert.deepEqual(trouble, []);
  });

  pageCheck("a film is what is shown, picture by picture, as ffmpeg decodes it", async (browser) => {
    const { page, drop, trouble } = await open(browser);
    await drop(fixture("real/cmu_12_01_walk.bvh"));
    // Save one second of the motion.
    await page.evaluate(() => { const { player } = window.desk; player.line.range = [1, 2]; player.seekTime(1); player.line.show(); });
    await page.click("#save-film");
    for (const [kind, rate, most] of [["webm", 24, OFF_FILM], ["mp4", 24, OFF_FILM], ["gif", 20, OFF_GIF]]) {
      // Some builds of Chromium do not encode H.264.
      if (await page.locator(`#film-kind [value=${kind}]`).isDisabled()) continue;
      await page.selectOption("#film-kind", kind);
      if (kind !== "gif") await page.selectOption("#film-rate", "24");
      const film = decoded(await made(page, "#film-save", `film.${kind}`));
      assert.equal(film.pictures.length, rate + 1, `${kind}: both ends of a second`);
      for (const index of [0, 7, rate]) {
        const ours = await page.evaluate(`(${drawnSquares})(${JSON.stringify([index, rate, film.width, film.height])}, ${SQUARE}, ${squaresOf})`);
        const theirs = squaresOf(film.pictures[index], film.width, film.height, 3, SQUARE);
        const off = ours.reduce((worst, value, i) => Math.max(worst, Math.abs(value - theirs[i])), 0);
        assert.ok(off < most, `${kind}: picture ${index} is ${off.toFixed(1)} of 255 off`);
      }
    }
    await page.selectOption("#film-kind", "png");
    const png = readFileSync(await made(page, "#film-save", "picture.png"));
    assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [1280, 720]);
    assert.deepEqual(trouble, []);
  });

  pageCheck("a saved page has what was opened in it, with its steps and its character", async (browser) => {
    const { page, drop, idle, trouble } = await open(browser);
    await drop(fixture("real/cmu_short.bvh"));
    await page.evaluate(() => window.desk.change(window.desk.chosen, "steps", ["mirror"]));
    await drop(fixture("characters/human_vrm0.vrm"), fixture("real/cmu_12_01_walk.bvh"));
    await page.click("[aria-label='cmu_short.bvh beside the others']");
    await idle();
    const seen = (page) => page.evaluate(() => window.mocap.state.clips.map(({ name, frames }, index) => [name, frames, window.mocap.drawn(index)[0]]));
    const before = await seen(page);
    assert.equal(before.length, 2);
    const file = await made(page, "#save-page");
    assert.deepEqual(trouble, []);
    const again = await openPage(browser, pathToFileURL(file).href);
    await again.idle();
    assert.deepEqual(await seen(again.page), before);
    assert.deepEqual((await again.page.evaluate(() => window.desk.items.map(({ steps }) => steps))).flat(), ["mirror"]);
    // A saved page can be saved again.
    await again.drop(fixture("real/lecture_Test.bvh"));
    const second = await openPage(browser, pathToFileURL(await made(again.page, "#save-page")).href);
    await second.idle();
    assert.deepEqual((await second.items()).map(({ name }) => name), ["lecture_Test.bvh"]);
    assert.deepEqual([...again.trouble, ...second.trouble], []);
  });

  pageCheck("all motions are one archive, each as it is saved alone", async (browser) => {
    const { page, drop, trouble } = await open(browser);
    await drop(fixture("real/cmu_short.bvh"), fixture("real/lecture_Test.bvh"), fixture("characters/human_default.glb"));
    await page.evaluate(() => window.desk.show([window.desk.items.find(({ name }) => name === "cmu_short.bvh")]));
    const alone = readFileSync(await made(page, "#save-row [data-format=glb]"));
    await page.check("#save-all");
    const archive = await made(page, "#save-row [data-format=glb]", "all.zip");
    execFileSync("unzip", ["-tq", archive]);
    const names = execFileSync("unzip", ["-Z1", archive], { encoding: "utf8" }).trim().split("\n");
    assert.deepEqual(names.filter((name) => !/ on /.test(name)).sort(), ["cmu_short.glb", "lecture_Test.glb"], "a character has no motion");
    assert.ok(execFileSync("unzip", ["-p", archive, "cmu_short.glb"], { maxBuffer: 1 << 28 }).equals(alone));
    assert.deepEqual(trouble, []);
  });

  pageCheck("a dragged hand is kept as a step, and the job makes the same", async (browser) => {
    const { page, drop, idle, trouble } = await open(browser);
    const walk = fixture("real/cmu_12_01_walk.bvh");
    await drop(walk);
    await page.evaluate(() => window.mocap.seek(200));
    const hand = await page.evaluate(() => window.mocap.state.clips[0].nodes.findIndex(({ bone }) => bone?.name === "leftHand"));
    const [x, y] = await page.evaluate((joint) => window.mocap.onPage(joint), hand);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 20, y - 60, { steps: 4 });
    await page.mouse.up();
    const place = () => page.evaluate((joint) => { window.desk.player.stage.draw(); return window.mocap.drawn()[joint]; }, hand);
    const dragged = await place();
    await page.click("#drag .main");
    await idle();
    const { steps, frame } = await page.evaluate(() => ({ steps: window.desk.chosen.steps, frame: Number(/range=(\d+)f/.exec(window.desk.chosen.steps[0])[1]) }));
    assert.match(steps[0], /^reach:limb=left-hand,to=/);
    await page.evaluate((frame) => window.mocap.seek(frame), frame);
    const kept = await place();
    const metres = 0.0254 / 0.45;
    const off = metres * Math.hypot(...kept.map((value, axis) => value - dragged[axis]));
    assert.ok(off < 0.002, `the hand is ${off} m from where it was put`);
    const job = JSON.parse(await page.textContent("#job-text"));
    const [file, output] = ["reach.json", "reach.glb"].map((name) => join(folder, name));
    writeFileSync(file, JSON.stringify({ ...job, source: { ...job.source, inputs: [walk] }, write: { output } }));
    assert.ok(program("run", file), "the program does not take the job");
    const posed = JSON.parse(program("pose", output, "--tick", String(frame), "--world", "--json"));
    const there = posed.nodes.find(({ name }) => name === "LeftHand").translation;
    assert.ok(Math.hypot(...there.map((value, axis) => value - metres * dragged[axis])) < 0.002, `the job puts it at ${there}`);
    assert.deepEqual(trouble, []);
  });

  pageCheck("bones are chosen by joint, and the time line shows a part of the time", async (browser) => {
    const { page, drop, idle, trouble } = await open(browser);
    await drop(fixture("real/cmu_12_01_walk.bvh"));
    await page.click("#tree >> text=LeftShoulder");
    await page.selectOption("#bone-choice", "leftUpperArm");
    await idle();
    const bones = await page.evaluate(() => Object.fromEntries(window.mocap.state.clips[0].nodes.filter(({ bone }) => bone).map(({ name, bone }) => [bone.name, name])));
    assert.equal(bones.leftUpperArm, "LeftShoulder");
    assert.equal(JSON.parse(await page.textContent("#job-text")).source.map.leftUpperArm, "LeftShoulder");
    await page.evaluate(() => window.mocap.seek(300));
    for (const key of [".", ".", "."]) await page.keyboard.press(key);
    const [from, to, tick] = await page.evaluate(() => ["min", "max", "value"].map((name) => Number(document.getElementById("scrub")[name])));
    assert.ok(to - from < 70 && from < 300 && to > 300 && tick === 300, `${from} to ${to}, at ${tick}`);
    assert.equal(await page.isVisible("#part"), true);
    // The time line shows the current time.
    await page.evaluate(() => window.mocap.seek(20));
    await page.waitForFunction(() => Number(document.getElementById("scrub").min) <= 20);
    for (const key of [",", ",", ",", ","]) await page.keyboard.press(key);
    assert.equal(await page.getAttribute("#scrub", "min"), "0");
    assert.equal(await page.isVisible("#part"), false);
    assert.deepEqual(trouble, []);
  });

  pageCheck("a motion on a robot is that of `mocap robot`, with its shapes and limits", async (browser) => {
    const { page, drop, items, trouble, picture } = await open(browser);
    const [walk, g1] = ["real/cmu_short.bvh", "robots/g1_29dof_rev_1_0.urdf"].map(fixture);
    await drop(walk, g1);
    assert.match((await items()).find(({ name }) => name.endsWith(".urdf")).summary, /^a robot, \d+ links$/);
    assert.deepEqual(await page.evaluate(() => window.mocap.state.clips.map(({ name }) => name)), ["cmu_short on g1_29dof_rev_1_0"]);
    assert.equal(await page.evaluate(() => Boolean(window.mocap.state.clips[0].skin)), true, "its links have shapes");
    await page.click("#robot summary");
    assert.equal(await page.locator("#robot-joint optgroup").first().locator("option").count(), 29);
    // The mean of a limb's curve equals the mean in the report.
    const limbs = await page.evaluate(() => window.desk.chosen.answer.retargeted.limbs.map(({ bone, mean_degrees: mean }) => [bone, mean]));
    assert.ok(limbs.length >= 8);
    for (const [bone, mean] of limbs.slice(0, 2)) {
      await page.selectOption("#robot-joint", { label: bone });
      const said = Number(/^([\d.]+)°/.exec(await page.textContent("#robot-speed"))[1]);
      assert.ok(Math.abs(said - mean) < 0.06, `${bone}: ${said} and ${mean}`);
    }
    await picture("robot");
    const found = arraysOf(readFileSync(await made(page, "#save-row [data-format=npz]")));
    const output = join(folder, "robot.npz");
    assert.ok(program("robot", walk, "--robot", g1, "-o", output));
    const expected = arraysOf(readFileSync(output));
    for (const [name, values] of Object.entries(expected)) {
      const off = Math.max(...Array.from(values, (value, i) => Math.abs(Number(value) - Number(found[name][i]))));
      assert.equal(found[name].length, values.length, name);
      assert.ok(off < 0.01, `${name} is ${off} off`);
    }
    // Drop the robot with a mesh: a tetrahedron, as text.
    const corners = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]];
    const faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    const text = faces.map((face) => `facet normal 0 0 0\nouter loop\n${face.map((corner) => `vertex ${corners[corner].join(" ")}\n`).join("")}endloop\nendfacet\n`);
    const stl = join(folder, "pelvis.STL");
    writeFileSync(stl, `solid pelvis\n${text.join("")}endsolid\n`);
    const bodies = await page.evaluate(() => Object.fromEntries(window.mocap.state.clips[0].skin.parts.map(({ name, count }) => [name, count])));
    await page.click("#remove-all");
    await drop(walk, g1, stl);
    const meshes = await page.evaluate(() => Object.fromEntries(window.mocap.state.clips[0].skin.parts.map(({ name, count }) => [name, count])));
    assert.deepEqual(meshes, { ...bodies, "pelvis link": 3 * faces.length });
    const rows = readFileSync(await made(page, "#save-row [data-format=csv]"), "utf8").trim().split("\n");
    assert.equal(rows.length, expected["root_pos.npy"].length / 3 + (/^[a-z]/i.test(rows[0]) ? 1 : 0));
    assert.deepEqual(trouble, []);
  });
}
