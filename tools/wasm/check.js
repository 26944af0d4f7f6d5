// Compares the outputs of the package with the outputs of the program, for all fixtures.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join } from "node:path";
import { parseArgs } from "node:util";
import * as THREE from "three";
import { BVHLoader } from "three/examples/jsm/loaders/BVHLoader.js";
import { Sample } from "../interop/sample.js";
import { browserChecks } from "./browser_checks.js";
import { tryHosts } from "./bundlers/run.js";
import { clipChecks } from "./clip_checks.js";
import { controllerChecks } from "./controller_checks.js";
import { demoChecks } from "./demo_checks.js";
import { MocapError, load } from "./package/index.js";
import { MocapLoader } from "./package/three.js";
import { pageChecks } from "./page_checks.js";
import { quickest } from "./quickest.js";
import { smallChecks } from "./small_checks.js";

const { values, positionals } = parseArgs({
  options: { all: { type: "boolean", default: false }, only: { type: "string", default: "" } },
  allowPositionals: true,
});
const sample = Sample.chosen(values.all);
const root = join(import.meta.dirname, "../..");
const fixtures = join(root, "fixtures");
const folder = mkdtempSync(join(tmpdir(), "mocap-wasm-"));

const READ = [".bvh", ".amc", ".asf", ".c3d", ".gltf", ".glb", ".vrm", ".vrma", ".fbx"];
const all = ["real", "skeletons", "characters", "made", "dialects", "broken"]
  .flatMap((name) => readdirSync(join(fixtures, name)).map((file) => join(fixtures, name, file)))
  .filter((path) => READ.includes(extname(path)));
const real = (name) => join(fixtures, "real", name);

/** A file for the package. An .amc motion also has the .asf skeletons in its folder. */
function filesOf(path) {
  const beside = extname(path) === ".amc" ? readdirSync(dirname(path)).filter((name) => extname(name) === ".asf") : [];
  return [basename(path), ...beside].map((name) => ({ name, bytes: readFileSync(join(dirname(path), name)) }));
}

/** Runs the program. Returns its output, or null if it fails. */
function program(...args) {
  const { status, stdout } = spawnSync(process.env.MOCAP, args, { maxBuffer: 1 << 30 });
  return status === 0 ? stdout : null;
}

/** The file that the program writes, or null if it fails. */
function written(extension, ...args) {
  const out = join(folder, `out${extension}`);
  rmSync(out, { force: true });
  // Remove an earlier buffer: without its .gltf its owner is unknown, so the program would not replace it.
  rmSync(join(folder, "out.bin"), { force: true });
  return program(...args, extension === ".json" ? "" : out) && readFileSync(out);
}

/** The result of `make`, or null if it fails with an error of the package. */
function made(make) {
  try {
    return make();
  } catch (error) {
    if (!(error instanceof MocapError) || ["defect", "out-of-memory", "freed"].includes(error.code)) throw error;
    return null;
  }
}

function assertSame(found, expected, what) {
  if (expected === null || found === null) return assert.equal(found === null, expected === null, `${what}: only one of the two fails`);
  const place = Buffer.compare(Buffer.from(found), Buffer.from(expected));
  assert.equal(place, 0, `${what}: ${found.length} bytes are not the ${expected.length} of the program`);
}

/**
 * Compares BVH files: words are equal, and numbers within a relative error. WebAssembly has no sine and no arc tangent, so the
 * last bits come from another library.
 */
function assertNearText(found, expected, share) {
  if (found === null || expected === null) return assertSame(found, expected, ".bvh");
  const [ours, theirs] = [found, expected.toString()].map((text) => text.split(/\s+/));
  assert.equal(ours.length, theirs.length, ".bvh");
  ours.forEach((word, index) => {
    const same = word === theirs[index] || Math.abs(word - theirs[index]) < share * Math.max(1, Math.abs(word));
    assert.ok(same, `.bvh: ${word} is ${theirs[index]} in the file of the program`);
  });
}

/** The JSON and the floats of a `.glb`, or of a `.gltf` with its buffers. */
function partsOf(bytes) {
  const floats = (buffer) => new Float32Array(Uint8Array.from(buffer).buffer, 0, buffer.length >> 2);
  const data = Buffer.from(bytes);
  if (data.toString("latin1", 0, 4) !== "glTF") {
    const { buffers, ...json } = JSON.parse(data.toString());
    // A buffer is in the file, or in a separate file.
    const bytes = (uri) => (uri.startsWith("data:") ? Buffer.from(uri.split(",")[1], "base64") : readFileSync(join(folder, uri)));
    return [json, buffers.map(({ uri }) => floats(bytes(uri)))];
  }
  const length = data.readUInt32LE(12);
  return [JSON.parse(data.toString("utf8", 20, 20 + length)), [floats(data.subarray(28 + length))]];
}

/**
 * Compares glTF files of retargeted motions: numbers are within 1e-3. Sums of products differ in the last bit with other
 * vector instructions. The arc cosine, which computes the angle between two directions, enlarges such a difference to 3.5e-4 rad.
 */
function assertNearGltf(found, expected, share = 1e-3) {
  if (found === null || expected === null) return assertSame(found, expected, "glTF");
  const [[json, ours], [expectedJson, theirs]] = [partsOf(found), partsOf(expected)];
  assertNear(json, expectedJson, share);
  ours.forEach((floats, buffer) => {
    assert.equal(floats.length, theirs[buffer].length);
    const off = (value, i) => Math.abs(value - theirs[buffer][i]) / Math.max(1, Math.abs(value));
    const most = floats.reduce((most, value, i) => Math.max(most, off(value, i)), 0);
    assert.ok(most < share, `a number of the buffer is ${most} of itself off`);
  });
}

/** Compares values. Numbers may differ by a fraction `share` of their value, or of 1 if they are smaller. */
function assertNear(found, expected, share, place = "") {
  if (typeof expected === "number" && typeof found === "number") {
    assert.ok(Math.abs(found - expected) <= share * Math.max(1, Math.abs(expected)), `${place}: ${found} is ${expected} in the program`);
  } else if (expected !== null && typeof expected === "object" && found !== null && typeof found === "object") {
    assert.deepEqual(Object.keys(found), Object.keys(expected), place);
    for (const key of Object.keys(expected)) assertNear(found[key], expected[key], share, `${place}/${key}`);
  } else {
    assert.deepEqual(found, expected, place);
  }
}

const mocap = await load();
/** Scenes that are freed at the end of a check. */
const scenes = [];
const kept = (scene) => (scenes.push(scene), scene);

const checks = [];
const check = (part, name, run) => checks.push({ part, name, run });

check("types", "programs with the types compile, with `using` and without", () => {
  const tsc = join(import.meta.dirname, "node_modules/typescript/bin/tsc");
  const compiled = (file, lib) => {
    const args = [tsc, "--noEmit", "--strict", "--target", "esnext", "--module", "nodenext", "--lib", lib];
    const { status, stdout } = spawnSync(process.execPath, [...args, join(import.meta.dirname, file)], { encoding: "utf8" });
    assert.equal(status, 0, `${file}: ${stdout}`);
  };
  compiled("types_check.ts", "esnext,dom,esnext.disposable");
  // Most projects do not use `using`, and their TypeScript lacks Symbol.dispose.
  compiled("types_check_es2020.ts", "es2020,dom");
});

for (const path of sample.some(all, 8)) {
  const name = path.slice(fixtures.length + 1);
  check("same", `${name}: scene, GLB, BVH and VRMA are those of the program`, () => {
    const files = filesOf(path);
    const scene = (options) => mocap.read(files, options);
    const dump = program("dump", "--raw", "--json", path);
    const found = made(() => {
      const whole = kept(scene({ collapseKeys: false }));
      return `${whole.toJson()}\n`;
    });
    const bytes = (write) => made(() => kept(scene())[write]());
    const glb = written(".glb", "convert", "--quiet", path);
    if ([".amc", ".asf", ".fbx"].includes(extname(path))) {
      // Their rotations use the sine of the standard library. The rotations of BVH use mocap's own sine.
      if (found === null || dump === null) assertSame(found, dump, "dump");
      else assertNear(JSON.parse(found), JSON.parse(dump), 1e-6);
      assertNearGltf(bytes("toGlb"), glb, 1e-6);
    } else {
      assertSame(found, dump, "dump");
      assertSame(bytes("toGlb"), glb, ".glb");
    }
    const share = extname(path) === ".bvh" ? 1e-9 : 1e-6;
    assertNearText(bytes("toBvh"), written(".bvh", "convert", "--quiet", path), share);
    assertNearGltf(bytes("toVrma"), written(".vrma", "convert", "--quiet", path));
  });
}

check("same", "arrays stand on the body that is given, and positions are solved, as with the program", () => {
  const arrays = (name) => join(fixtures, "arrays", name);
  const file = (path) => ({ name: basename(path), bytes: readFileSync(path) });
  const bvh = (path, options) => kept(mocap.read(readFileSync(path), basename(path), options)).toBvh();
  const expected = (path, ...options) => written(".bvh", "convert", "--quiet", path, ...options);
  // The angles in degrees come from 32-bit rotations, with another sine and arc tangent.
  const share = 1e-4;
  for (const [motion, body] of [
    [arrays("phuma_69.npy"), real("cmu_12_01_walk.bvh")],
    [arrays("smplx_protocol_4.pkl"), arrays("body_smpl.pkl")],
    // The motion and the body have the same name.
    [arrays("smplx_protocol_4.pkl"), arrays("smplx_protocol_4.pkl")],
  ]) {
    assertNearText(bvh(motion, { body: file(body) }), expected(motion, "--body", body), share);
  }
  assert.throws(() => bvh(real("cmu_short.bvh"), { body: file(real("cmu_short.bvh")) }), { code: "invalid-value" });
  const points = arrays("points_smpl22.npy");
  assertNearText(bvh(points, { joints: "smpl22", lengths: "moving" }), expected(points, "--joint-set", "smpl22", "--lengths", "moving"), share);
  assert.throws(() => bvh(points, { joints: "no-such" }), { code: "invalid-value" });
});

check("same", "angles, forces, gait and reports are those of the program", () => {
  /** The columns of a table as the program writes it as text. */
  const assertTable = (table, text) => {
    const [names, ...rows] = text.toString().trimEnd().split("\n").map((line) => line.split(","));
    assert.deepEqual(["time", ...table.columns], names);
    assert.equal(table.frameCount, rows.length);
    assert.equal(table.units.length, table.columns.length);
    rows.forEach((row, frame) => row.forEach((cell, column) => {
      const own = column === 0 ? frame / table.frameRate : table.values[frame * table.columns.length + column - 1];
      assert.ok(Math.abs(own - cell) < 2e-3 * Math.max(1, Math.abs(cell)), `${names[column]} ${frame}: ${own} is ${cell} in the program`);
    }));
  };
  const plates = kept(mocap.read(readFileSync(join(fixtures, "made/plates.c3d")), "plates.c3d"));
  assertTable(plates.groundForces(), program("forces", join(fixtures, "made/plates.c3d"), "-o", "-", "--quiet"));
  assertTable(plates.analog(), program("analog", join(fixtures, "made/plates.c3d"), "-o", "-", "--quiet"));
  assert.deepEqual(plates.recorded.events.map(({ label, context }) => [label, context]), [["Foot Strike", "Left"], ["Foot Off", "Right"], ["Foot Strike", "Right"]]);
  assert.equal(plates.solved, null);
  assert.throws(() => plates.gait(), MocapError);

  const walk = kept(mocap.read(readFileSync(real("cmu_12_01_walk.bvh")), "walk.bvh"));
  assertTable(walk.jointAngles(), program("angles", real("cmu_12_01_walk.bvh"), "-o", "-", "--quiet"));
  const { file, ...gait } = JSON.parse(program("gait", real("cmu_12_01_walk.bvh"), "--json"));
  assertNear(walk.gait(), gait, 1e-4);
  assert.equal(walk.recorded, null);

  const bytes = readFileSync(join(fixtures, "markers/cmu_01_01.c3d"));
  const take = kept(mocap.read(bytes, "cmu_01_01.c3d", { markers: "auto", static: { name: "standing.c3d", bytes } }));
  const args = ["info", "--json", join(fixtures, "markers/cmu_01_01.c3d"), "--markers", "auto", "--static", join(fixtures, "markers/cmu_01_01.c3d")];
  assertNear(take.solved, JSON.parse(program(...args)).solved, 1e-3);
});

check("same", "diagnostics and assumptions are those of `mocap check`", () => {
  const paths = sample.some(all, 4);
  const { stdout } = spawnSync(process.env.MOCAP, ["check", "--json", ...paths], { encoding: "utf8", maxBuffer: 1 << 28 });
  const lines = stdout.trim().split("\n").map((line) => JSON.parse(line));
  assert.equal(lines.length, paths.length);
  for (const expected of lines) {
    const found = mocap.check(filesOf(expected.file));
    assert.equal(found.status, expected.status, expected.file);
    assert.deepEqual(found.assumptions, expected.assumptions, expected.file);
    const plain = ({ code, message, line, column, joint, expected, found, help, count, severity }) =>
      ({
        code, message, line: line ?? null, column: column ?? null, joint, found, help, count, severity,
        // The limits of the package are lower.
        expected: code === "limit-exceeded" ? "" : expected,
      });
    assert.deepEqual(found.diagnostics.map(plain), expected.diagnostics.map(plain), expected.file);
  }
});

check("same", "steps are those of `mocap edit`", () => {
  const path = real("cmu_12_01_walk.bvh");
  const walk = kept(kept(mocap.read(filesOf(path))).convert({ firstFrame: "auto" }));
  const steps = ["fill", { step: "smooth", "cut-off": 8 }, { step: "loop", frames: [20, 200], "in-place": true }];
  const changed = kept(walk.edit(steps));
  const args = ["fill", "smooth:cut-off=8", "loop:frames=20..200,in-place=true"].flatMap((step) => ["--step", step]);
  const output = join(folder, "edited.glb");
  const { status, stdout, stderr } = spawnSync(process.env.MOCAP, ["edit", path, "-o", output, "--json", ...args], { encoding: "utf8" });
  assert.equal(status, 0, stderr);
  assertNear(changed.reports, JSON.parse(stdout), 1e-4);
  // Sine and arc tangent come from another library.
  assertNearGltf(changed.toGlb(), readFileSync(output));
  const both = kept(walk.edit(["concat"], { others: [walk] }));
  assert.equal(both.animations[0].frameCount, 2 * walk.animations[0].frameCount - 1);
  const refused = (code, help, steps, options) =>
    assert.throws(() => walk.edit(steps, options), (error) => error.code === code && (!help || error.help.startsWith(help)));
  refused("unknown-option", "did you mean cut-off?", [{ step: "smooth", cutoff: 8 }]);
  refused("invalid-value", undefined, ["concat"]);
  refused("invalid-value", undefined, ["mirror"], { bones: { hips: "Tail" } });
});

check("same", "every step works, and its job gives what the program writes", () => {
  const [path, second] = [real("cmu_short.bvh"), real("cmu_12_01_walk.bvh")];
  const prepared = (file) => kept(kept(mocap.read(filesOf(file))).convert({ firstFrame: "auto" }));
  const [walk, other] = [prepared(path), prepared(second)];
  const takesOther = Object.fromEntries(mocap.steps.map((step) => [step.name, step.takesOther]));
  const steps = JSON.parse(readFileSync(join(root, "tests/steps.json"), "utf8"));
  assert.deepEqual(new Set(steps.map((step) => step.split(":")[0])), new Set(Object.keys(takesOther)));
  for (const step of steps) {
    const two = takesOther[step.split(":")[0]];
    const changed = kept(walk.edit([step], { others: two ? [other] : [] }));
    const inputs = two ? [path, second] : [path];
    const output = join(folder, "step.glb");
    const ran = spawnSync(process.env.MOCAP, ["edit", ...inputs, "-o", output, "--force", "--json", "--step", step], { encoding: "utf8" });
    assert.equal(ran.status, 0, `${step}: ${ran.stderr}`);
    assertNear(changed.reports, JSON.parse(ran.stdout), 1e-3, step);
    assertNearGltf(changed.toGlb(), readFileSync(output));
    const files = inputs.map((file) => ({ name: basename(file), bytes: readFileSync(file) }));
    const [motion, ...others] = files.map(({ name }) => name);
    const source = { inputs: [motion], with: others, frames: { "drop-first-frame": "auto" } };
    const done = mocap.run({ source, steps: [step], write: { output: "step.glb" } }, files);
    assertNearGltf(done.files[0].bytes, readFileSync(output));
  }
});

check("same", "the face of a VRM animation goes onto a character", () => {
  const face = kept(mocap.read(filesOf(join(root, "fixtures/made/face.vrma"))));
  assert.ok(face.nodes.some((node) => node.face?.preset === "blink"));
  const hero = join(root, "fixtures/characters/human_vrm0.vrm");
  // Do not lock feet, because rounding changes the locks. This check compares the face.
  const moved = kept(face.retarget(kept(mocap.readCharacter(filesOf(hero))), { feet: "free" }));
  const { bytes, report } = moved.write("glb");
  assert.match(report.notes.join(), /expressions that the character does not have, left out: happy/);
  const output = join(folder, "face.vrm");
  const ran = spawnSync(process.env.MOCAP, ["retarget", join(root, "fixtures/made/face.vrma"), hero, "-o", output, "--feet", "free"], { encoding: "utf8" });
  assert.equal(ran.status, 0, ran.stderr);
  assertNearGltf(bytes, readFileSync(output));
});

check("same", "changes are those of `mocap convert`", () => {
  const path = real("cmu_12_01_walk.bvh");
  const read = kept(mocap.read(filesOf(path)));
  const cases = [
    [{ first: { seconds: 0.5 }, last: { seconds: 2.5 }, frameRate: 30 }, ["--trim", "0.5..2.5", "--fps", "30"]],
    [{ unit: "cm", up: "z", root: "inPlace" }, ["--unit", "cm", "--up", "z", "--in-place"]],
    [{ unit: 0.02, firstFrame: "drop", root: "extract" }, ["--unit", "0.02", "--drop-first-frame", "yes", "--root-motion"]],
  ];
  for (const [options, args] of cases) {
    const changed = kept(read.convert(options));
    const expected = written(".glb", "convert", "--quiet", ...args, path);
    assert.ok(expected, `the program does not take ${args}`);
    assertSame(changed.toGlb(), expected, JSON.stringify(options));
  }
  const [options, args] = [{ compress: "int16", maxError: 0.001 }, ["--compress", "int16", "--max-error", "1mm"]];
  assertSame(read.toGlb(options), written(".glb", "convert", "--quiet", ...args, path), JSON.stringify(options));
  // With a shell, the dropped keys depend on an arc tangent, whose last bit differs in WebAssembly. The bound still holds.
  const withShell = join(folder, "shell.glb");
  writeFileSync(withShell, read.toGlb({ ...options, shellDistance: 0.03 }));
  const ofProgram = written(".glb", "convert", "--quiet", ...args, "--shell-distance", "3cm", path).length;
  const difference = Math.abs(readFileSync(withShell).length / ofProgram - 1);
  assert.ok(difference < 0.03, `with a shell ${readFileSync(withShell).length} bytes, and ${ofProgram} by the program`);
  assert.ok(program("verify", path, withShell, "--max-error", "1mm"), "with a shell the bound is not kept");
  assertSame(read.toBvh({ order: "XYZ", digits: 3 }), written(".bvh", "convert", "--quiet", "--order", "xyz", "--digits", "3", path), "BVH");
  assertSame(read.toCsv(), written(".csv", "fk", path, "-o"), "CSV");
});

check("same", "poses and keys are those of the scene", () => {
  const path = real("lecture_Test.bvh");
  const scene = kept(mocap.read(filesOf(path)));
  const [animation] = scene.animations;
  assert.deepEqual([animation.frameCount, animation.channels[2].nodeName, animation.channels[2].positions.length], [10, "Wrist", 1]);
  const json = JSON.parse(scene.toJson());
  for (const [index, { positions, rotations }] of animation.channels.entries()) {
    const keys = (track, width) => Array.from(track.ticks, (tick, key) => [tick, [...track.values.slice(width * key, width * (key + 1))]]);
    const channel = json.animations[0].channels[index];
    const single = (pairs) => pairs.map(([tick, value]) => [tick, value.map(Math.fround)]);
    assert.deepEqual(keys(positions, 3), single(channel.position_keys));
    assert.deepEqual(keys(rotations, 4), single(channel.rotation_keys_xyzw));
  }
  for (const tick of [0, 4.5, 9]) {
    const expected = JSON.parse(program("pose", path, "--tick", String(tick), "--world", "--json"));
    const { nodeToWorld } = scene.pose(tick);
    expected.nodes.forEach(({ translation }, node) => {
      translation.forEach((value, axis) => assert.ok(Math.abs(nodeToWorld[16 * node + 12 + axis] - value) < 1e-5));
    });
  }
  assert.throws(() => scene.pose(0, 1), { code: "invalid-value" });
});

check("same", "a chain is that of `mocap chain`", () => {
  const path = real("lecture_Test.bvh");
  const scene = kept(mocap.read(filesOf(path)));
  const expected = JSON.parse(program("chain", path, "Wrist", "--tick", "4.5", "--point", "0.5,0,1", "--json"));
  const { chain, pointInWorld } = scene.chain("Wrist", 4.5, [0.5, 0, 1]);
  // The last digits depend on the instructions of the machine.
  const rounded = (value) => JSON.stringify(value, (_, part) => (typeof part === "number" ? Number(part.toFixed(4)) + 0 : part));
  assert.equal(rounded(chain), rounded(expected.chain));
  assert.equal(rounded(pointInWorld), rounded(expected.point_in_world));
  assert.equal(scene.chain("Elbow").pointInWorld, null);
  assert.throws(() => scene.chain("Wirst"), { code: "invalid-value", help: 'did you mean "Wrist"?' });
});

for (const target of ["human_default.gltf", "human_vrm1.gltf", "human_cmu.gltf"]) {
  check("retarget", `a walk on ${target} is that of \`mocap retarget\``, () => {
    const character = join(fixtures, "skeletons", target);
    const path = real("cmu_12_01_walk.bvh");
    const motion = kept(mocap.read(filesOf(path)));
    const onto = kept(mocap.readCharacter(filesOf(character)));
    const moved = kept(motion.retarget(onto));
    assertNearGltf(moved.toGlb(), written(".gltf", "retarget", path, character, "-o"));
    assertNearGltf(moved.toVrma(), written(".vrma", "retarget", path, character, "-o"));
    const reports = JSON.parse(program("retarget", "--json", path, character, "--force", "-o", join(folder, "again.gltf")));
    for (const [index, { clip, frames, verdict, mean_degrees }] of reports.entries()) {
      const ours = moved.reports[index];
      assert.deepEqual([ours.clip, ours.frames, ours.verdict], [clip, frames, verdict]);
      assert.ok(Math.abs(ours.mean_degrees - mean_degrees) < 0.1, `${ours.mean_degrees} degrees, not ${mean_degrees}`);
    }
  });
}

check("jobs", "a job on files in memory writes what the program writes", () => {
  const path = real("cmu_short.bvh");
  const source = { inputs: ["cmu_short.bvh"], frames: { "drop-first-frame": "auto" } };
  const job = { source, steps: ["mirror"], write: { output: "mirrored.bvh" } };
  const { files, steps } = mocap.run(job, [{ name: "cmu_short.bvh", bytes: readFileSync(path) }]);
  assert.deepEqual([files.map(({ name }) => name), steps.length], [["mirrored.bvh"], 1]);
  const output = join(folder, "mirrored.bvh");
  program("edit", path, "-o", output, "--step", "mirror");
  // Another arc tangent changes the last of twelve decimals.
  assertNearText(new TextDecoder().decode(files[0].bytes), readFileSync(output), 1e-9);
  const surveyed = mocap.run({ source: { inputs: source.inputs }, survey: { html: "card.html" } }, [{ name: "cmu_short.bvh", bytes: readFileSync(path) }]);
  assert.deepEqual([surveyed.survey.length, surveyed.survey[0].joints, surveyed.files[0].name], [1, 31, "card.html"]);
  assert.throws(() => mocap.run({ wirte: {} }, []), /there are 0 names|has no wirte/);
});

/**
 * Compares two motions: joints are within a distance, in the unit of the file. A different last digit turns a straight leg by
 * hundredths of a degree.
 */
function assertNearPoses(found, expected, most) {
  const [ours, theirs] = [found, expected].map((bytes) => kept(mocap.read(bytes, "walk.bvh")));
  assert.equal(ours.animations[0].frameCount, theirs.animations[0].frameCount);
  for (let tick = 0; tick < ours.animations[0].frameCount; tick++) {
    const [a, b] = [ours, theirs].map((scene) => scene.pose(tick).nodeToWorld);
    for (let node = 0; node < ours.nodes.length; node++) {
      const [from, to] = [16 * node + 12, 16 * node + 15];
      const apart = Math.hypot(...Array.from(a.slice(from, to), (value, axis) => value - b[from + axis]));
      assert.ok(apart < most, `${ours.nodes[node].name} is ${apart} apart at tick ${tick}`);
    }
  }
}

check("jobs", "a motion graph and walks over it are those of the program", () => {
  const clip = { name: "cmu_12_01_walk.bvh", bytes: readFileSync(real("cmu_12_01_walk.bvh")) };
  const source = { inputs: [clip.name] };
  const graph = { threshold: 0.05 };
  const compared = mocap.run({ source, graph, write: { output: "graph.json" } }, [clip]);
  const text = new TextDecoder().decode(compared.files[0].bytes);
  const options = ["--threshold", "5cm", "--force"];
  program("graph", real(clip.name), ...options, "-o", join(folder, "graph.json"));
  const [own, expected] = [JSON.parse(text), JSON.parse(readFileSync(join(folder, "graph.json"), "utf8"))];
  const moments = ({ transitions }) => transitions.map(({ from, to }) => [from, to]);
  assert.deepEqual(moments(own), moments(expected));
  own.transitions.forEach(({ distance }, index) => assert.ok(Math.abs(distance - expected.transitions[index].distance) < 1e-6));
  assert.deepEqual([compared.graph.clips, compared.graph.transitions], [1, expected.transitions.length]);
  const ofGraph = { source: { inputs: ["graph.json"] }, files: [{ name: "graph.json", bytes: compared.files[0].bytes }, clip] };
  for (const [walk, words] of [[{ seconds: 7, seed: 2 }, ["--seconds", "7", "--seed", "2"]], [{ path: [[0, 0], [3, 0]] }, ["--path", "0/0+3/0"]]]) {
    program("graph", "walk", join(folder, "graph.json"), ...words, "--force", "-o", join(folder, "walked.bvh"));
    for (const { job, files } of [{ job: { source, graph }, files: [clip] }, { job: { source: ofGraph.source }, files: ofGraph.files }]) {
      const walked = mocap.run({ ...job, walk, write: { output: "walked.bvh" } }, files);
      assertNearPoses(walked.files[0].bytes, readFileSync(join(folder, "walked.bvh")), 0.02);
      assert.ok(walked.walk.seconds > 2);
    }
  }
  const broken = { name: "graph.json", bytes: new TextEncoder().encode(text.slice(0, text.length / 2)) };
  assert.throws(() => mocap.run({ source: ofGraph.source, walk: { seconds: 5 }, write: { output: "a.bvh" } }, [broken, clip]), { code: "invalid-graph" });
  assert.throws(() => mocap.run({ source: ofGraph.source, walk: { seconds: 5 }, write: { output: "a.bvh" } }, [ofGraph.files[0]]), { code: "missing-file" });
});

check("hostile", "broken files give errors with their places, and the module goes on", () => {
  const before = mocap.read("HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 2 Frame Time: 0.1\n10\n20\n", "a.bvh");
  assert.throws(() => mocap.read("HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n", "a.bvh"), (error) => {
    const { code, file, line, column, length, joint, found, expected } = error;
    assert.deepEqual({ code, file, line, column, length, joint, found, expected }, {
      code: "invalid-number", file: "a.bvh", line: 3, column: 12, length: 4, joint: "a",
      found: "\"zero\"", expected: "the Y value of OFFSET",
    });
    return true;
  });
  assert.throws(() => mocap.read("", "a.txt", { colour: 1 }), { code: "unknown-option" });
  assert.equal(before.animations[0].channels[0].rotations.values.length, 8);
  before.free();
  assert.throws(() => before.toGlb(), { code: "freed" });
});

/** A generator of random numbers below `n`. A seed gives the same numbers in every run. */
function randomFrom(seed) {
  let state = BigInt(seed) + 0x9e3779b97f4a7c15n;
  return (n) => {
    state = (state * 6364136223846793005n + 1442695040888963407n) & 0xffffffffffffffffn;
    return Number((state >> 33n) % BigInt(n));
  };
}

check("hostile", "cut and damaged files give a scene or an error, never the end of the module", () => {
  const random = randomFrom(sample.seed);
  const sources = ["real/lecture_Test.bvh", "real/cmu_02_01.amc", "real/hand_take.c3d", "skeletons/human_vrm1.gltf", "characters/human_vrm0.vrm", "made/tiny.fbx", "real/run.fbx"];
  for (const source of sources) {
    const [first, ...others] = filesOf(join(fixtures, source));
    for (let round = 0; round < (values.all ? 400 : 40); round++) {
      const bytes = Uint8Array.from(first.bytes.subarray(0, round % 2 ? random(first.bytes.length) : first.bytes.length));
      for (let flips = random(8); flips > 0 && bytes.length > 0; flips--) {
        // Most faults that a reader can notice are at the beginning of a binary file.
        bytes[random(round % 3 ? bytes.length : Math.min(bytes.length, 4096))] = random(256);
      }
      made(() => {
        const scene = kept(mocap.read([{ name: first.name, bytes }, ...others], { gltfMeshes: true }));
        if (scene.animations.length > 0) scene.pose(0);
        scene.toGlb();
      });
      for (const scene of scenes.splice(0)) scene.free();
    }
  }
});

check("hostile", "nested and large claims are refused", () => {
  const deep = `HIERARCHY ROOT a { ${"JOINT a { ".repeat(100_000)}`;
  assert.throws(() => mocap.read(deep, "deep.bvh"), { code: "limit-exceeded" });
  const nested = `{"asset":{"version":"2.0"},"extras":${"[".repeat(200_000)}${"]".repeat(200_000)}}`;
  made(() => mocap.read(nested, "deep.gltf").free());
  const many = "HIERARCHY ROOT a { CHANNELS 3 Xrotation Yrotation Zrotation } MOTION Frames: 4000000000 Frame Time: 0.1\n1 2 3\n";
  made(() => mocap.read(many, "many.bvh").free());
});

check("hostile", "where memory ends there is an error, and then a fresh module", () => {
  if (!values.all) return;
  const bytes = readFileSync(real("cmu_01_01.bvh"));
  const old = mocap.read(bytes, "old.bvh");
  const held = [];
  assert.throws(() => {
    for (;;) held.push(old.convert({ frameRate: 20_000 }));
  }, { code: "out-of-memory" });
  assert.ok(held.length > 1);
  assert.throws(() => old.toGlb(), { code: "freed" });
  const again = kept(mocap.read(bytes, "again.bvh"));
  assert.equal(again.nodes.length, 38);
});

smallChecks(check, { all, sample, made, written, assertSame, partsOf });
clipChecks(check, { mocap, made, kept, real, filesOf, written, assertSame, random: randomFrom(sample.seed), load });
controllerChecks(check, { mocap, made, kept, real, filesOf, written, random: randomFrom(sample.seed), load });

demoChecks(check);

check("memory", "a scene that is freed, disposed of or forgotten gives its memory back", async () => {
  const bytes = readFileSync(real("cmu_01_01.bvh"));
  const once = () => mocap.read(bytes, "a.bvh", { hash: false });
  const posed = (rounds) => {
    for (let round = 0; round < rounds; round++) {
      const scene = once();
      scene.pose(1);
      scene[round % 2 ? Symbol.dispose : "free"]();
    }
    return mocap.memory;
  };
  const settled = posed(4);
  assert.equal(posed(20), settled);
  for (let round = 0; round < 20; round++) {
    once();
    globalThis.gc();
    await new Promise((done) => setTimeout(done, 5));
  }
  // Without the registry, twenty scenes of 3 MB would remain.
  assert.ok(mocap.memory < settled + (16 << 20), `${mocap.memory} bytes after ${settled}`);
});

check("three", "MocapLoader gives the skeleton and the poses of BVHLoader", async () => {
  const loader = await new MocapLoader(undefined, mocap).init();
  for (const name of ["lecture_Test.bvh", "cmu_12_01_walk.bvh", "cmu_short.bvh"]) {
    const bytes = readFileSync(real(name));
    const [ours, theirs] = [loader.parse(bytes, name), new BVHLoader().parse(bytes.toString("latin1"))];
    assert.deepEqual(Object.keys(theirs).every((key) => key in ours), true);
    assert.equal(ours.skeleton.bones.length, theirs.skeleton.bones.length);
    assert.ok(Math.abs(ours.clip.duration - theirs.clip.duration) < 1e-4 * (1 + theirs.clip.duration));
    const places = ({ skeleton, clip }, seconds) => {
      const [root] = skeleton.bones;
      const mixer = new THREE.AnimationMixer(root);
      mixer.clipAction(clip).play();
      mixer.setTime(seconds);
      root.updateMatrixWorld(true);
      return skeleton.bones.map((bone) => bone.getWorldPosition(new THREE.Vector3()));
    };
    for (const share of [0, 0.3, 0.77]) {
      const seconds = share * ours.clip.duration;
      const [found, expected] = [places(ours, seconds), places(theirs, seconds)];
      const size = Math.max(...expected.map((place) => place.distanceTo(expected[0])));
      const offset = Math.max(...found.map((place, bone) => place.distanceTo(expected[bone])));
      assert.ok(offset < 1e-4 * size, `${name}: ${offset} of ${size} at ${seconds} s`);
    }
  }
});

check("speed", "measures reading beside BVHLoader in Node", () => {
  const bytes = readFileSync(real("cmu_01_01.bvh"));
  const runs = [
    () => mocap.read(bytes, "a.bvh", { hash: false, skeletonMesh: "none" }).free(),
    () => new BVHLoader().parse(bytes.toString("latin1")),
  ];
  const [ours, theirs] = quickest(runs, 40);
  console.log(`cmu_01_01.bvh in Node: ${ours.toFixed(1)} ms, BVHLoader ${theirs.toFixed(1)} ms, ${(theirs / ours).toFixed(1)} times`);
});

browserChecks(check, { fixtures, all, sample, filesOf, mocap, made });
check("bundlers", "a walk plays in fresh projects of every host", async () => {
  // This check takes some minutes, and downloads hundreds of packages.
  if (!values.all && !positionals.includes("bundlers")) return;
  assert.deepEqual(await tryHosts(), []);
});
pageChecks(check, { fixtures, folder, program, sample });

let failed = 0;
let passed = 0;
for (const { part, name, run } of checks) {
  // Speed is only printed and never fails, so it is measured only on request.
  if (!name.includes(values.only)) continue;
  if (positionals.length > 0 ? !positionals.includes(part) : part === "speed") continue;
  try {
    await run();
    passed++;
  } catch (error) {
    failed++;
    console.log(`FAILED ${part}: ${name}\n  ${String(error.message).split("\n").slice(0, 12).join("\n  ")}`);
  }
  for (const scene of scenes.splice(0)) scene.free();
}
rmSync(folder, { recursive: true, force: true });
console.log(`${passed} passed, ${failed} failed`);
process.exitCode = failed > 0 ? 1 : 0;
