// Checks the drop page in headless Chromium as a person uses it: opened from a file, with dropped files.

import assert from "node:assert/strict";
import { cpSync, mkdirSync, readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { basename, extname, join } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";
import { accessChecks } from "./access_checks.js";
import { openingChecks } from "./opening_checks.js";
import { fromBase128, toBase128 } from "./page/base128.js";
import { savingChecks } from "./saving_checks.js";

const PAGE = join(import.meta.dirname, "mocap.html");
const LARGEST = 2.8e6;

// With MOCAP_PICTURES=FOLDER, the checks write screenshots to the folder.

/** Opens the page, with functions for a person's actions. `trouble` collects every message, error and request. */
const open = (browser, options) => openPage(browser, pathToFileURL(PAGE).href, options);

/** Like `open`, for another page. */
async function openPage(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 760 }, acceptDownloads: true, reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  const trouble = [];
  page.on("console", (message) => trouble.push(message.text()));
  page.on("pageerror", (error) => trouble.push(error.message));
  context.on("request", (request) => request.url() !== address && !/^(data|blob):/.test(request.url()) && trouble.push(`request: ${request.url()}`));
  await page.goto(address);
  await page.waitForFunction(() => window.desk?.reader.isReady);
  const devtools = await context.newCDPSession(page);
  const idle = async () => {
    await page.waitForFunction(() => {
      const { reader, items, opening } = window.desk;
      return !opening && !reader.working && !reader.waiting.length && items.length > 0 && items.every(({ state }) => state !== "waiting");
    });
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  };
  const drop = async (x, ...files) => {
    const before = await page.evaluate(() => window.desk.openings);
    const data = { items: [], files, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"]) await devtools.send("Input.dispatchDragEvent", { type, x, y: 380, data });
    await page.waitForFunction((before) => window.desk.openings > before, before);
    await idle();
  };
  return {
    page,
    trouble,
    idle,
    /** Drops files and folders on the page beside the picture, as a desktop does. */
    drop: (...files) => drop(200, ...files),
    /** Drops files on the picture. */
    dropOnFigure: (...files) => drop(640, ...files),
    items: () => page.evaluate(() => window.desk.items.map(({ name, state, summary, error }) => ({ name, state, summary, code: error?.code, line: error?.line }))),
    async saved(format, folder) {
      const [download] = await Promise.all([page.waitForEvent("download"), page.click(`#save-row [data-format=${format}]`)]);
      const path = join(folder, download.suggestedFilename());
      await download.saveAs(path);
      return path;
    },
    async picture(name) {
      if (process.env.MOCAP_PICTURES) await page.screenshot({ path: join(process.env.MOCAP_PICTURES, `${name}.png`) });
    },
    close: () => context.close(),
  };
}

export function pageChecks(check, { fixtures, folder, program, sample }) {
  const fixture = (name) => join(fixtures, name);
  const pageCheck = (name, use, part = "page") => check(part, name, async () => {
    const browser = await chromium.launch(launchOptions());
    try {
      await use(browser);
    } finally {
      await browser.close();
    }
  });

  check("page", "the page is small enough", () => {
    const { size } = statSync(PAGE);
    assert.ok(size <= LARGEST, `${size} bytes`);
  });

  check("page", "bytes come back from text that an element of HTML keeps", () => {
    for (let length = 0; length < 600; length++) {
      // Many numbers, and bytes whose first seven bits are a replaced character: 0, 13 (from 26) and 60 (from 120).
      for (const bytes of [(k) => k * k * 37 + length * 11, () => 0, () => 26, () => 120].map((byte) => Uint8Array.from({ length }, (_, k) => byte(k)))) {
        const text = toBase128(bytes);
        assert.doesNotMatch(text, /[\0\r<]/);
        assert.deepEqual(fromBase128(text), bytes);
      }
    }
  });

  openingChecks(pageCheck, { open, fixture, folder, program });
  savingChecks(pageCheck, { open, openPage, fixture, folder, program });
  accessChecks(pageCheck, { open, fixture });

  pageCheck("every format can be dropped and is drawn as the library says", async (browser) => {
    const { page, drop, items, trouble, picture } = await open(browser);
    const drops = [
      ["real/cmu_12_01_walk.bvh"], ["real/cmu_01.asf", "real/cmu_01_01.amc"], ["real/hand_take.c3d"], ["characters/human_default.glb"],
      ["skeletons/human_vrm1.gltf"], ["characters/human_vrm0.vrm"], ["real/run.fbx"],
      ["characters/arnaud.fbx"],
    ];
    for (const names of drops) {
      await drop(...names.map(fixture));
      const item = (await items()).at(-1);
      assert.equal(item.state, "ok", `${item.name}: ${item.summary}`);
      const motion = fixture(names.at(-1));
      const shown = await page.evaluate(async (tick) => {
        window.mocap.seek(tick);
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        return { drawn: window.mocap.drawn(), name: window.mocap.state.clips[0].name, tick: window.mocap.state.clips[0].tick };
      }, 5);
      assert.equal(shown.name, basename(motion));
      const args = shown.tick ? ["--tick", String(shown.tick)] : ["--tick", "0"];
      const posed = JSON.parse(program("pose", motion, ...args, "--world", "--json") ?? "null");
      if (!posed) continue;
      const places = posed.nodes.map((node) => node.translation);
      const size = Math.max(...places.map((place) => Math.hypot(...place.map((value, axis) => value - places[0][axis]))));
      places.forEach((place, node) => {
        const offset = Math.hypot(...place.map((value, axis) => value - shown.drawn[node][axis]));
        assert.ok(offset < 1e-3 * size, `${shown.name}: node ${node} is ${offset} off`);
      });
      await picture(`drop-${extname(motion).slice(1)}`);
    }
    assert.deepEqual(trouble, []);
  });

  pageCheck("a saved VRMA can be dropped again", async (browser) => {
    const { drop, items, saved, trouble } = await open(browser);
    await drop(fixture("real/cmu_12_01_walk.bvh"));
    await drop(await saved("vrma", folder));
    const [walk, vrma] = await items();
    assert.deepEqual([vrma.name, vrma.state], ["cmu_12_01_walk.vrma", "ok"]);
    assert.equal(vrma.summary.split(", ")[1], walk.summary.split(", ")[1]);
    assert.deepEqual(trouble, []);
  });

  pageCheck("a broken file is explained with its line, and the next one is read", async (browser) => {
    const { page, drop, items, trouble, picture } = await open(browser);
    await drop(fixture("broken/unknown_channel.bvh"));
    assert.deepEqual((await items()).map(({ state, code, line }) => [state, code, line]), [["error", "unknown-channel", 5]]);
    const said = await page.textContent("#finding-list");
    for (const part of ["is not a channel", "line 5, column 14", "CHANNELS 6 Xpositon", "^^^^^^^^", "did you mean Xposition?"]) assert.ok(said.includes(part), part);
    await picture("broken");
    await drop(fixture("real/lecture_Test.bvh"));
    assert.equal((await items())[1].state, "ok");
    assert.equal(await page.evaluate(() => window.mocap.state.clips[0].name), "lecture_Test.bvh");
    assert.deepEqual(trouble, []);
  });

  pageCheck("every broken fixture is an error on the page, never its end", async (browser) => {
    const { drop, items, trouble } = await open(browser);
    const broken = readdirSync(fixture("broken")).filter((name) => extname(name) === ".bvh").map((name) => fixture(`broken/${name}`));
    await drop(...sample.some(broken, 30), fixture("real/lecture_Test.bvh"));
    const all = await items();
    assert.ok(all.every(({ state, code }) => state !== "error" || !["defect", "out-of-memory"].includes(code)), JSON.stringify(all));
    assert.equal(all.find(({ name }) => name === "lecture_Test.bvh").state, "ok");
    assert.deepEqual(trouble, []);
  });

  pageCheck("a reader that ends is started again, and the page says so", async (browser) => {
    const { page, drop, items, trouble } = await open(browser);
    await drop(fixture("real/lecture_Test.bvh"));
    const ended = await page.evaluate(async () => {
      const { reader } = window.desk;
      const asked = reader.ask({ call: "show", item: { ...window.desk.request(window.desk.items[0]), id: 99 }, name: "x" });
      reader.stop();
      return asked.then(() => "answered", (error) => error.code);
    });
    assert.equal(ended, "stopped");
    assert.match(await page.textContent("#notice"), /^Stopped\. Press a file in the list/);
    await drop(fixture("real/cmu_short.bvh"));
    assert.deepEqual((await items()).map(({ state }) => state), ["ok", "ok"]);
    // Likewise if the module ends during a call.
    await page.evaluate(() => window.desk.reader.take({ id: -1, error: { code: "defect", message: "a defect of the library: made up" } }));
    assert.match(await page.textContent("#notice"), /ended and was started again: a defect/);
    await drop(fixture("real/z_up_dab.bvh"));
    assert.equal((await items()).at(-1).state, "ok");
    assert.deepEqual(trouble, []);
  });

  pageCheck("a folder of twenty clips is a list, by hand and by keys", async (browser) => {
    const clips = join(folder, "take");
    mkdirSync(join(clips, "second"), { recursive: true });
    for (let clip = 0; clip < 18; clip++) cpSync(fixture("real/lecture_Test.bvh"), join(clips, `clip ${clip}.bvh`));
    cpSync(fixture("real/cmu_short.bvh"), join(clips, "second/short.bvh"));
    cpSync(fixture("broken/empty.bvh"), join(clips, "second/empty.bvh"));
    writeFileSync(join(clips, "notes.txt"), "no motion");
    const { page, drop, items, trouble, picture } = await open(browser);
    await drop(clips);
    const all = await items();
    assert.equal(all.length, 20);
    assert.deepEqual(all.map(({ name }) => name).slice(0, 3), ["clip 0.bvh", "clip 1.bvh", "clip 2.bvh"]);
    assert.deepEqual(all.filter(({ state }) => state === "error").map(({ name }) => name), ["empty.bvh"]);
    assert.match(await page.textContent("#notice"), /notes\.txt/);
    const playing = () => page.evaluate(() => window.mocap.state.clips.map(({ name }) => name));
    assert.deepEqual(await playing(), ["clip 0.bvh"]);
    await page.keyboard.press("PageDown");
    await page.waitForFunction(() => window.mocap.state.clips[0].name === "clip 1.bvh");
    await page.click("text=short.bvh");
    await page.waitForFunction(() => window.mocap.state.clips[0].name === "short.bvh");
    await page.click("[aria-label='clip 3.bvh beside the others']");
    await page.waitForFunction(() => window.mocap.state.clips.length === 2);
    assert.deepEqual(await playing(), ["short.bvh", "clip 3.bvh"]);
    await picture("folder");
    // Open the same folder with the button.
    await page.setInputFiles("#folder-input", clips);
    await page.waitForFunction(() => window.desk.openings === 2 && !window.desk.opening);
    assert.equal((await items()).length, 20, "no file is there twice");
    assert.deepEqual(trouble, []);
  });

  pageCheck("what was assumed can be changed, and the motion trimmed", async (browser) => {
    const { page, drop, idle, saved, trouble, picture } = await open(browser);
    const walk = fixture("real/cmu_12_01_walk.bvh");
    await drop(walk);
    assert.match(await page.textContent("#unit-reason"), /^cmu: /);
    const clip = () => page.evaluate(() => ({ unit: window.mocap.state.clips[0].metresPerUnit, up: window.mocap.state.clips[0].up, frames: window.mocap.state.clips[0].frames }));
    assert.equal((await clip()).up, "+y");
    await page.selectOption("#unit", "cm");
    await idle();
    await page.selectOption("#up", "z");
    await idle();
    assert.deepEqual(await clip(), { unit: 0.01, up: "+z", frames: 524 });
    await page.selectOption("#first-frame", "drop");
    await idle();
    await page.click("#trim summary");
    await page.fill("#trim-last", "119");
    await page.press("#trim-last", "Enter");
    await idle();
    assert.equal((await clip()).frames, 119);
    await page.evaluate(() => window.mocap.seek(9));
    await page.click("#trim-first-here");
    await idle();
    // Without the rest pose, frame 9 of the motion is frame 10 of the file.
    assert.equal(await page.inputValue("#trim-first"), "10");
    assert.equal((await clip()).frames, 110);
    await picture("changed");
    const expected = join(folder, "expected.glb");
    const args = ["--unit", "cm", "--up", "z", "--drop-first-frame", "yes", "--trim", "10f..119f"];
    assert.ok(program("convert", "--quiet", ...args, walk, expected), "the program does not take the same options");
    assert.ok(readFileSync(await saved("glb", folder)).equals(readFileSync(expected)), "GLB");
    await page.selectOption("#unit", "other");
    await page.fill("#metres", "0.5");
    await page.press("#metres", "Enter");
    await idle();
    assert.equal((await clip()).unit, 0.5);
    await page.click("#trim-none");
    await idle();
    assert.equal((await clip()).frames, 523);
    assert.deepEqual(trouble, []);
  });

  pageCheck("steps are those of the program, and are taken back; job and command line make the file that is saved", async (browser) => {
    const { page, drop, idle, saved, trouble, picture } = await open(browser);
    const walk = fixture("real/cmu_12_01_walk.bvh");
    await drop(walk);
    const frames = () => page.evaluate(() => window.mocap.state.clips[0].frames);
    const commanded = async (name) => {
      // The page saved a file with this name, so the program uses another name.
      const output = join(folder, `${name}-${(await page.textContent("#command-text")).split(" ").at(-1)}`);
      const line = (await page.textContent("#command-text")).replaceAll("'", "").split(" ");
      const words = line.map((word) => (word === basename(walk) ? walk : word)).slice(1, -1);
      assert.ok(program(...words, output), `the program does not take ${words.join(" ")}`);
      const job = JSON.parse(await page.textContent("#job-text"));
      const file = join(folder, `${name}.json`);
      const made = join(folder, `${name}.glb`);
      writeFileSync(file, JSON.stringify({ ...job, source: { ...job.source, inputs: [walk] }, write: { output: made } }));
      assert.ok(program("run", file), "the program does not take the job");
      const found = readFileSync(await saved("glb", folder));
      // Compare only the numbers of the motion. The JSON before them differs, because the page converts the scene last.
      const numbers = (glb) => glb.subarray(20 + glb.readUInt32LE(12));
      return [output, made].map((file) => numbers(readFileSync(file)).equals(numbers(found)));
    };
    const whole = await frames();
    await page.click("#steps summary");
    await page.waitForSelector("#step-name option", { state: "attached" });
    await page.selectOption("#step-name", "trim");
    await page.fill("#step-key-range", "1..2");
    await page.click("#step-add");
    await idle();
    assert.ok(await frames() < whole / 2, `${await frames()} of ${whole} frames`);
    assert.equal(await page.locator("#step-list li").count(), 1);
    await picture("steps");
    // Trimming needs no sine, so the numbers equal the program's.
    assert.deepEqual(await commanded("trimmed"), [true, true]);
    await page.selectOption("#step-name", "smooth");
    await page.fill("#step-key-cut-off", "no number");
    await page.click("#step-add");
    await idle();
    assert.match(await page.textContent("#notice"), /^Not changed: /);
    await page.click("#step-undo");
    await idle();
    assert.equal(await frames(), whole);
    await page.selectOption("#up", "z");
    await idle();
    assert.deepEqual(await commanded("turned"), [true, true]);
    assert.deepEqual(trouble, []);
  });

  pageCheck("the chain of a joint names the lines of the file", async (browser) => {
    const { page, drop, trouble } = await open(browser);
    await drop(fixture("real/lecture_Test.bvh"));
    await page.click("#tree >> text=Wrist");
    assert.equal((await page.textContent("#chain-product")).replace(/\s+/g, " ").trim(), "T = J0 L1 J1 L2 J2");
    assert.ok((await page.locator("#chain tr").count()) >= 5);
    assert.deepEqual(trouble, []);
  });

  pageCheck("a motion is put on a character, and saved files are those of the program", async (browser) => {
    const { page, drop, idle, items, saved, trouble, picture } = await open(browser);
    const [walk, character] = ["real/cmu_12_01_walk.bvh", "characters/human_vrm0.vrm"].map(fixture);
    await drop(walk, character);
    // Both files were dropped together, so the motion is retargeted at once.
    assert.deepEqual((await items()).map(({ name }) => name), ["human_vrm0.vrm", "cmu_12_01_walk.bvh", "cmu_12_01_walk on human_vrm0"].sort((a, b) => a.includes(" on ") - b.includes(" on ") || a.localeCompare(b)));
    assert.deepEqual(await page.evaluate(() => window.mocap.state.clips.map(({ name }) => name)), ["cmu_12_01_walk on human_vrm0"]);
    await page.click("#opened .item >> text=cmu_12_01_walk.bvh");
    await idle();
    for (const [format, args] of [["glb", ["convert", "--quiet", walk]], ["bvh", ["convert", "--quiet", walk]], ["csv", ["fk", walk, "-o"]], ["png", ["sheet", walk, "-o"]]]) {
      const expected = join(folder, `expected.${format}`);
      assert.ok(program(...args, expected), `the program writes no ${format}`);
      const found = await saved(format, folder);
      if (format !== "bvh") assert.ok(readFileSync(found).equals(readFileSync(expected)), format);
    }
    await page.click("#onto summary");
    assert.equal(await page.locator("#character option:checked").textContent(), "human_vrm0.vrm");
    await page.click("#put-on");
    await page.waitForFunction(() => window.mocap.state.clips.length === 2);
    await idle();
    assert.equal((await items()).length, 3, "it is there already");
    assert.equal(await page.evaluate(() => Boolean(window.mocap.state.clips[0].skin)), true);
    await picture("retarget");
    const glb = await saved("glb", folder);
    const { vrm } = JSON.parse(program("info", glb, "--json") ?? "{}");
    assert.notEqual(vrm, null);
    const { validateBytes } = (await import("gltf-validator")).default;
    for (const path of [glb, await saved("vrma", folder)]) {
      const { issues } = await validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 10 });
      assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages));
    }
    assert.deepEqual(trouble, []);
  });

  pageCheck("nothing can leave the page: every way out is refused", async (browser) => {
    let heard = 0;
    const server = createServer((_, response) => { heard++; response.end("{}"); });
    await new Promise((done) => server.listen(0, "127.0.0.1", done));
    const address = `http://127.0.0.1:${server.address().port}/stolen`;
    await fetch(address);
    assert.equal(heard, 1, "the server hears what is sent");
    const { page, drop, trouble } = await open(browser);
    await drop(fixture("real/lecture_Test.bvh"));
    assert.deepEqual(trouble, []);
    const refused = await page.evaluate(async (address) => {
      const violations = [];
      document.addEventListener("securitypolicyviolation", ({ effectiveDirective }) => violations.push(effectiveDirective));
      const isRefused = (run) => Promise.resolve().then(run).then(() => false, () => true);
      const found = {
        fetch: await isRefused(() => fetch(address)),
        request: await isRefused(() => new Promise((done, failed) => {
          const request = new XMLHttpRequest();
          request.open("GET", address);
          request.onload = done;
          request.onerror = failed;
          request.send();
        })),
        script: await isRefused(() => import(address)),
      };
      try { new WebSocket(address.replace("http", "ws")); } catch { /* Some browsers throw, others tell later. */ }
      navigator.sendBeacon(address, "x");
      new Image().src = address;
      const worker = new Worker(URL.createObjectURL(new Blob([`fetch("${address}").then(() => postMessage(false), () => postMessage(true))`])));
      found.worker = await new Promise((done) => { worker.onmessage = ({ data }) => done(data); });
      await new Promise((done) => setTimeout(done, 300));
      return { ...found, violations };
    }, address);
    server.close();
    assert.equal(heard, 1, "nothing came from the page");
    const { violations, ...ways } = refused;
    assert.deepEqual(ways, { fetch: true, request: true, script: true, worker: true });
    for (const directive of ["connect-src", "img-src", "script-src-elem"]) assert.ok(violations.includes(directive), `${directive}: ${violations}`);
    assert.ok(violations.filter((name) => name === "connect-src").length >= 4, String(violations));
  });

  pageCheck("a phone has room for it, light and dark", async (browser) => {
    for (const colorScheme of ["light", "dark"]) {
      const { page, drop, trouble, picture, close } = await open(browser, { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true, colorScheme });
      await picture(`phone-start-${colorScheme}`);
      await drop(fixture("broken/unknown_channel.bvh"));
      await picture(`phone-broken-${colorScheme}`);
      await drop(fixture("real/cmu_12_01_walk.bvh"));
      assert.equal(await page.getAttribute("html", "data-theme"), colorScheme);
      await picture(`phone-${colorScheme}`);
      await page.tap("#desk-button");
      assert.ok(await page.isVisible("#opened"));
      await picture(`phone-desk-${colorScheme}`);
      await page.tap("#panel-button");
      assert.ok(await page.isVisible("#tree") && !(await page.isVisible("#opened")));
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is wider than the window");
      assert.deepEqual(trouble, []);
      await close();
    }
  });

  pageCheck("every control has a name", async (browser) => {
    const { page, drop } = await open(browser);
    await drop(fixture("real/cmu_12_01_walk.bvh"), fixture("real/cmu_short.bvh"));
    const nameless = await page.evaluate(() => {
      const controls = Array.from(document.querySelectorAll("#desk :is(button, select, progress, input:not([hidden])), #desk-button"));
      const nameOf = (control) => control.getAttribute("aria-label") || control.textContent.trim() || control.labels?.[0]?.textContent;
      return controls.filter((control) => !nameOf(control)).map((control) => control.outerHTML);
    });
    assert.deepEqual(nameless, []);
  });

  pageCheck("a clip of 2 MB is drawn soon after the drop", async (browser) => {
    const { page, drop } = await open(browser);
    // Wait until the reader is ready. A person needs longer to find a file.
    await page.waitForFunction(() => window.desk.reader.isWarm);
    const clip = fixture("real/cmu_01_01.bvh");
    await page.evaluate(() => {
      document.addEventListener("drop", () => { window.droppedAt = performance.now(); }, { capture: true });
      const { player } = window.desk;
      const frame = player.frame.bind(player);
      player.frame = (now) => { frame(now); window.drawnAt ??= performance.now(); };
    });
    const times = [];
    for (let round = 0; round < 4; round++) {
      await page.evaluate(() => { window.drawnAt = undefined; });
      // Use a new file, because the page does not read an open file again.
      const fresh = join(folder, `clip ${round}.bvh`);
      cpSync(clip, fresh);
      await drop(fresh);
      times.push(await page.evaluate(() => window.drawnAt - window.droppedAt));
    }
    console.log(`cmu_01_01.bvh on the page: ${times.map((time) => time.toFixed(0)).join(", ")} ms from the drop to the picture`);
  }, "speed");
}
