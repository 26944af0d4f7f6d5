// Plays a walk in a new project of every host, and makes the table of the README from the results.
//
//   node run.js [WORDS..] [--write]
//
// WORDS select the hosts whose names contain one of the words. --write writes the table to ../README.md. Without --write, the
// table in the README must equal the new table. Projects are removed at the end. The packages come from npm.

import assert from "node:assert/strict";
import { execFile, execFileSync, spawn } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { dirname, extname, join } from "node:path";
import { promisify, parseArgs } from "node:util";
import { chromium } from "playwright-core";
import * as THREE from "three";
import { BVHLoader } from "three/examples/jsm/loaders/BVHLoader.js";
import { launchOptions } from "../../chromium.mjs";
import { HOSTS } from "./hosts.js";

const here = import.meta.dirname;
const WALK = join(here, "../../../fixtures/real/cmu_12_01_walk.bvh");
const [JOINT, FRAME] = ["LeftHand", 300];
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };
const PATIENCE = 240_000;
/** The content security policy that the README states. */
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; worker-src 'self'; img-src data:";

/** Files of project/ that only one host has. */
const OF_ONE = new Set(["next_page.js", "fiber.jsx"]);

const run = promisify(execFile);

/** The expected position of the joint, from three.js's BVHLoader, which is independent of the package. */
function expectedPlace() {
  const { skeleton, clip } = new BVHLoader().parse(readFileSync(WALK, "latin1"));
  const [root] = skeleton.bones;
  const mixer = new THREE.AnimationMixer(root);
  mixer.clipAction(clip).play();
  const [, seconds] = /Frame Time:\s*(\S+)/.exec(readFileSync(WALK, "latin1"));
  mixer.setTime(FRAME * Number(seconds));
  root.updateMatrixWorld(true);
  return skeleton.bones.find(({ name }) => name === JOINT).getWorldPosition(new THREE.Vector3()).toArray();
}

/** The first block of code of a language in the README of the package. */
function blockOf(language) {
  const [, code] = new RegExp("```" + language + "\\n([^]*?)```").exec(readFileSync(join(here, "../package/README.md"), "utf8"));
  return code;
}

/** Makes a project with the package that `npm pack` has made. */
async function project(host, tarball) {
  const folder = mkdtempSync(join(tmpdir(), "mocap-host-"));
  for (const name of readdirSync(join(here, "project"))) if (!OF_ONE.has(name)) cpSync(join(here, "project", name), join(folder, name));
  const files = { "package.json": '{ "name": "project", "private": true, "type": "module" }\n', ...host.files };
  for (const [name, content] of Object.entries(files)) {
    const path = join(folder, name);
    mkdirSync(dirname(path), { recursive: true });
    if (content.from) cpSync(join(here, "project", content.from), path);
    else if (content.readme) writeFileSync(path, blockOf(content.readme));
    else writeFileSync(path, content);
  }
  // Vite and Next.js serve this folder at the root of their pages.
  mkdirSync(join(folder, "public"), { recursive: true });
  cpSync(WALK, join(folder, "public/walk.bvh"));
  cpSync(WALK, join(folder, "walk.bvh"));
  await run("npm", ["install", "--no-audit", "--no-fund", "--loglevel=error", tarball, "three@0.187", ...host.install], { cwd: folder, timeout: PATIENCE });
  return folder;
}

/** Serves the files of a folder on a free port, with a policy for the pages. */
async function serverOf(folder, policy) {
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, "http://host");
    const path = pathname === "/walk.bvh" ? WALK : join(folder, pathname === "/" ? "index.html" : decodeURIComponent(pathname));
    const found = statSync(path, { throwIfNoEntry: false })?.isFile();
    const type = TYPES[extname(path)] ?? "application/octet-stream";
    response.writeHead(found ? 200 : 404, { "content-type": type, ...(policy && { "content-security-policy": policy }) });
    response.end(found ? readFileSync(path) : "not found");
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { port: server.address().port, close: () => server.close() };
}

async function freePort() {
  const { port, close } = await serverOf(".");
  close();
  return port;
}

/** Starts the server of a host, and waits until it answers. */
async function serverByCommand(command, folder) {
  const port = await freePort();
  const started = spawn(command.replace("PORT", port), { cwd: folder, shell: true, detached: true, stdio: "ignore" });
  const close = () => process.kill(-started.pid);
  for (const start = Date.now(); Date.now() - start < PATIENCE; await new Promise((done) => setTimeout(done, 200))) {
    if (await fetch(`http://127.0.0.1:${port}/`).then(() => true, () => false)) return { port, close };
  }
  close();
  throw new Error(`no answer from: ${command}`);
}

/** The result of a page of a server. */
async function playedIn(browser, port) {
  const page = await browser.newPage();
  const said = [];
  page.on("console", (message) => message.type() === "error" && said.push(message.text()));
  page.on("pageerror", (error) => said.push(error.message));
  try {
    await page.goto(`http://127.0.0.1:${port}/?joint=${JOINT}&frame=${FRAME}`, { timeout: PATIENCE });
    await page.waitForFunction(() => window.played, undefined, { timeout: 60_000 });
    return await page.evaluate(() => window.played);
  } catch (error) {
    throw new Error(`${error.message.split("\n")[0]}; the page said: ${said.join("; ").slice(0, 600)}`);
  } finally {
    await page.close();
  }
}

async function played(host, folder, browser) {
  for (const command of host.build ?? []) {
    await run("sh", ["-c", command], { cwd: folder, timeout: PATIENCE, env: { ...process.env, NEXT_TELEMETRY_DISABLED: "1" } });
  }
  if (host.run) {
    const { stdout } = await run("sh", ["-c", `${host.run} "$0" ${JOINT} ${FRAME}`, WALK], { cwd: folder, timeout: PATIENCE });
    return JSON.parse(stdout);
  }
  const server = host.serve.includes("PORT") ? await serverByCommand(host.serve, folder) : await serverOf(join(folder, host.serve), host.hasInline ? undefined : POLICY);
  try {
    return await playedIn(browser, server.port);
  } finally {
    server.close();
  }
}

/** Tries a host. Returns the error if the walk is not at the expected position. */
async function tried(host, tarball, browser, expected) {
  let folder;
  try {
    folder = await project(host, tarball);
    const { error, frameCount, posed, mixed } = await played(host, folder, browser);
    assert.equal(error, undefined);
    assert.equal(frameCount, 524);
    for (const found of [posed, mixed]) {
      found.forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]) < 1e-3, `${JOINT} is at ${found}, not at ${expected}`));
    }
    return null;
  } catch (error) {
    return `${error.message}\n${error.stderr ?? ""}${error.stdout ?? ""}`.trim();
  } finally {
    if (folder) rmSync(folder, { recursive: true, force: true });
  }
}

/** The table of hosts as Markdown. */
const tableOf = (hosts) => ["| host | what it needs |", "|---|---|", ...hosts.map(({ name, needs }) => `| ${name} | ${needs} |`)].join("\n");

/** Compares or writes the table between the marks in the README. */
function compareTable(write) {
  const path = join(here, "../README.md");
  const before = readFileSync(path, "utf8");
  const after = before.replace(/(<!-- hosts -->\n)[^]*?(\n<!-- end -->)/, (_, start, end) => `${start}${tableOf(HOSTS)}${end}`);
  if (write) writeFileSync(path, after);
  else assert.equal(before, after, "the table of hosts in README.md is another: bundlers/run.js --write");
}

/** Tries the hosts, and returns the failures. */
export async function tryHosts({ words = [], write = false } = {}) {
  const packed = mkdtempSync(join(tmpdir(), "mocap-pack-"));
  const name = execFileSync("npm", ["pack", "--silent", "--pack-destination", packed, join(here, "../package")], { encoding: "utf8" }).trim();
  const browser = await chromium.launch(launchOptions());
  const hosts = HOSTS.filter((host) => words.length === 0 || words.some((word) => host.name.includes(word)));
  const expected = expectedPlace();
  const failures = [];
  for (const host of hosts) {
    const failure = await tried(host, join(packed, name), browser, expected);
    console.log(`${failure === null ? "plays" : "FAILS"}  ${host.name}`);
    if (failure !== null) failures.push(`${host.name}: ${failure}`);
  }
  await browser.close();
  rmSync(packed, { recursive: true, force: true });
  // The table only lists hosts that played the walk.
  if (failures.length === 0 && words.length === 0) compareTable(write);
  return failures;
}

if (process.argv[1] === import.meta.filename) {
  const { values, positionals } = parseArgs({ options: { write: { type: "boolean" } }, allowPositionals: true });
  const failures = await tryHosts({ words: positionals, write: values.write });
  for (const failure of failures) console.log(failure.slice(0, 3000));
  process.exitCode = failures.length > 0 ? 1 : 0;
}
