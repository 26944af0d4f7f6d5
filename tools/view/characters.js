// Makes the README's picture of characters: one motion on each of fixtures/characters, drawn by the player.
//
//   node characters.js [OUT] [MOTION] [TICK]        MOCAP names the program

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { crc32, deflateSync } from "node:zlib";
import { launch, open, settled } from "./browser.js";

const path = (name) => fileURLToPath(new URL(`../../fixtures/${name}`, import.meta.url));
const [out = path("pictures/characters.png"), motion = path("real/z_up_dab.bvh"), tick = "75"] = process.argv.slice(2);
const CHARACTERS = ["human_default.glb", "human_vrm0.vrm", "arnaud.fbx", "human_game_engine.glb"];
const SIZE = { width: 1000, height: 380 };

/** An image of RGBA as a small PNG: without alpha, with 64 steps of each colour, each row less the one above it. */
function png(pixels, { width, height }) {
  const color = (x, y, channel) => (y < 0 ? 0 : Math.min(255, Math.round(pixels[4 * (y * width + x) + channel] / 4) * 4));
  const rows = Buffer.alloc(height * (1 + 3 * width));
  let at = 0;
  for (let y = 0; y < height; y++) {
    rows[at++] = 2;
    for (let x = 0; x < width; x++) for (let channel = 0; channel < 3; channel++) rows[at++] = color(x, y, channel) - color(x, y - 1, channel);
  }
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, sum]);
  };
  const header = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0]);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  const signature = Buffer.from("89504e470d0a1a0a", "hex");
  return Buffer.concat([signature, chunk("IHDR", header), chunk("IDAT", deflateSync(rows, { level: 9 })), chunk("IEND", Buffer.alloc(0))]);
}

const mocap = process.env.MOCAP ?? fileURLToPath(new URL("../../target/release/mocap", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "mocap-characters-"));
const run = (...args) => execFileSync(mocap, args, { stdio: ["ignore", "ignore", "pipe"] });

const moved = CHARACTERS.map((name) => {
  const file = join(folder, basename(name).replace(".fbx", ".glb"));
  run("retarget", motion, path(`characters/${name}`), "-o", file, ...(name.endsWith(".fbx") ? [] : ["--replace-animations"]));
  return file;
});
const page = join(folder, "characters.html");
run("view", ...moved, "-o", page);

const browser = await launch();
const opened = await open(browser, pathToFileURL(page).href, { viewport: SIZE, colorScheme: "light", deviceScaleFactor: 2 });
// The picture alone, without what is around it and over it.
await opened.page.addStyleTag({ content: "header, footer, #panel, #shows, #hud, #labels, #tip { display: none !important; }" });
await opened.page.evaluate(() => window.mocap.ready);
await opened.page.keyboard.press("x");
await opened.page.evaluate((tick) => {
  window.mocap.seek(tick);
  window.mocap.frame({ apart: 1.2, yaw: Math.PI - 0.12, pitch: 0.07, closer: 0.5 });
}, Number(tick));
await settled(opened.page);
// Drawn twice as large, so that edges are smooth.
const large = (await opened.page.screenshot()).toString("base64");
const pixels = await opened.page.evaluate(async ([large, width, height]) => {
  const bytes = Uint8Array.from(atob(large), (letter) => letter.charCodeAt(0));
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const pen = canvas.getContext("2d");
  pen.imageSmoothingQuality = "high";
  pen.drawImage(await createImageBitmap(new Blob([bytes], { type: "image/png" })), 0, 0, width, height);
  return Array.from(pen.getImageData(0, 0, width, height).data);
}, [large, SIZE.width, SIZE.height]);
const picture = png(pixels, SIZE);
if (opened.trouble.length) throw new Error(opened.trouble.join("\n"));
await browser.close();
rmSync(folder, { recursive: true });
writeFileSync(out, picture);
console.log(`${out}: ${picture.length} bytes`);
