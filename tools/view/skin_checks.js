// Checks drawings with a skin: vertices, textures, and files with faults.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { settled } from "./browser.js";

const CHARACTERS = ["human_default.glb", "human_game_engine.glb", "human_vrm0.vrm", "arnaud.fbx"];

/** The JSON and the bytes of a .glb, .vrm or .gltf file with an embedded buffer. */
function gltf(path) {
  const bytes = readFileSync(path);
  if (bytes.toString("latin1", 0, 4) !== "glTF") {
    const json = JSON.parse(bytes);
    return { json, bin: Buffer.from(json.buffers[0].uri.split(",")[1], "base64") };
  }
  const length = bytes.readUInt32LE(12);
  return { json: JSON.parse(bytes.toString("utf8", 20, 20 + length)), bin: bytes.subarray(28 + length) };
}

/** The rows of an accessor, by the specification; a sparse accessor has zeros except in some rows. */
function rows(file, index) {
  const { sparse, ...accessor } = file.json.accessors[index];
  const all = accessor.bufferView === undefined
    ? Array.from({ length: accessor.count }, () => [0, 0, 0]) : plainRows(file, accessor);
  if (!sparse) return all;
  const { count, indices, values } = sparse;
  const places = plainRows(file, { ...indices, count, type: "SCALAR" });
  plainRows(file, { ...values, count, type: accessor.type, componentType: accessor.componentType }).forEach((row, i) => { all[places[i][0]] = row; });
  return all;
}

function plainRows({ json, bin }, accessor) {
  const view = json.bufferViews[accessor.bufferView];
  const columns = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 }[accessor.type];
  const [size, read, most] = {
    5121: [1, "readUInt8", 255], 5123: [2, "readUInt16LE", 65535], 5125: [4, "readUInt32LE", 1], 5126: [4, "readFloatLE", 1],
  }[accessor.componentType];
  const start = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const stride = view.byteStride ?? columns * size;
  return Array.from({ length: accessor.count }, (_, row) => Array.from({ length: columns }, (_, column) =>
    bin[read](start + row * stride + column * size) / (accessor.normalized ? most : 1)));
}

/** The file with an added animation of the morph target weights of its first mesh with morph targets. */
function withWeights({ json, bin }, times, weights) {
  const node = json.nodes.findIndex(({ mesh }) => json.meshes[mesh]?.primitives.some(({ targets }) => targets));
  const numbers = Buffer.from(new Float32Array([...times, ...weights.flat()]).buffer);
  const start = 4 * Math.ceil(bin.length / 4);
  const views = [[start, 4 * times.length], [start + 4 * times.length, numbers.length - 4 * times.length]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength }));
  const accessors = views.map(({ byteLength }, index) => ({
    bufferView: json.bufferViews.length + index, componentType: 5126, count: byteLength / 4, type: "SCALAR",
    ...(index ? {} : { min: [Math.min(...times)], max: [Math.max(...times)] }),
  }));
  const [input, output] = accessors.map((_, index) => json.accessors.length + index);
  const animations = [{ channels: [{ sampler: 0, target: { node, path: "weights" } }], samplers: [{ input, output }] }];
  const changed = { ...json, animations, bufferViews: [...json.bufferViews, ...views], accessors: [...json.accessors, ...accessors], buffers: [{ byteLength: start + numbers.length }] };
  const text = Buffer.from(JSON.stringify(changed));
  const chunks = [[0x4e4f534a, text, 0x20], [0x004e4942, Buffer.concat([bin, Buffer.alloc(start - bin.length), numbers]), 0]].map(([kind, bytes, filler]) => {
    const padded = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, filler)]);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(padded.length, 0);
    head.writeUInt32LE(kind, 4);
    return Buffer.concat([head, padded]);
  });
  const head = Buffer.from("glTF\x02\0\0\0\0\0\0\0", "latin1");
  const whole = Buffer.concat([head, ...chunks]);
  whole.writeUInt32LE(whole.length, 8);
  return whole;
}

/** Where a file's vertices are in the world, from its own numbers and the world matrices of its nodes, by their names;
    `morphs` are the weights of its morph targets. */
function skinned(file, worlds, morphs = []) {
  const places = [];
  // `mocap pose` prints a matrix row by row, a file has it column by column.
  const byRows = (m, p) => [0, 1, 2].map((row) => m[4 * row] * p[0] + m[4 * row + 1] * p[1] + m[4 * row + 2] * p[2] + m[4 * row + 3]);
  const byColumns = (m, p) => [0, 1, 2].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
  for (const node of file.json.nodes.filter(({ mesh, skin }) => mesh !== undefined && skin !== undefined)) {
    const skin = file.json.skins[node.skin];
    const inverses = rows(file, skin.inverseBindMatrices);
    for (const { attributes, targets = [] } of file.json.meshes[node.mesh].primitives) {
      const [positions, joints, weights] = ["POSITION", "JOINTS_0", "WEIGHTS_0"].map((name) => rows(file, attributes[name]));
      morphs.forEach((weight, index) => targets[index] && rows(file, targets[index].POSITION).forEach((offset, vertex) =>
        offset.forEach((value, axis) => { positions[vertex][axis] += weight * value; })));
      positions.forEach((position, vertex) => {
        let [place, sum] = [[0, 0, 0], 0];
        for (let k = 0; k < 4; k++) {
          const [joint, weight] = [joints[vertex][k], weights[vertex][k]];
          if (!weight) continue;
          const moved = byRows(worlds.get(file.json.nodes[skin.joints[joint]].name), byColumns(inverses[joint], position));
          place = place.map((value, axis) => value + weight * moved[axis]);
          sum += weight;
        }
        places.push(place.map((value) => value / sum));
      });
    }
  }
  return places;
}

/** The result of the page's vertex shader for every vertex, in the file's coordinates. */
function onGpu(page) {
  return page.evaluate(() => {
    const { skins, state } = window.mocap;
    const { gl } = skins;
    const [posed] = skins.posed;
    const program = gl.createProgram();
    const shaders = gl.getAttachedShaders(skins.colors.program).map((shader) => gl.getShaderSource(shader));
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, shaders.find((source) => source.includes("gl_Position") === (kind === gl.VERTEX_SHADER)));
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    ["position", "normal", "coords", "weights", "joints"].forEach((name, index) => gl.bindAttribLocation(program, index, name));
    gl.transformFeedbackVaryings(program, ["place"], gl.SEPARATE_ATTRIBS);
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.uniform1i(gl.getUniformLocation(program, "bones"), 1);
    skins.bindBones(posed);
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer);
    gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, 12 * posed.skin.vertices, gl.STATIC_READ);
    gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    gl.enable(gl.RASTERIZER_DISCARD);
    gl.beginTransformFeedback(gl.POINTS);
    gl.drawArrays(gl.POINTS, 0, posed.skin.vertices);
    gl.endTransformFeedback();
    gl.disable(gl.RASTERIZER_DISCARD);
    const found = new Float32Array(3 * posed.skin.vertices);
    gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, found);
    const places = Array.from({ length: posed.skin.vertices }, (_, i) => state.clips[0].toFile(Array.from(found.subarray(3 * i, 3 * i + 3))));
    return places;
  });
}

/** The colours of a picture of the page at some positions. */
async function colorsAt(page, places) {
  const picture = (await page.screenshot()).toString("base64");
  return page.evaluate(async ([picture, places]) => {
    const bytes = Uint8Array.from(atob(picture), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const canvas = Object.assign(document.createElement("canvas"), { width: bitmap.width, height: bitmap.height });
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    pen.drawImage(bitmap, 0, 0);
    return places.map(([x, y]) => Array.from(pen.getImageData(Math.round(x), Math.round(y), 1, 1).data));
  }, [picture, places]);
}

/** The distance from each position of a list to the nearest position of another list; the order does not matter. */
function farthestFromNearest(places, others, cell) {
  const key = (place) => place.map((value) => Math.round(value / cell));
  const cells = new Map();
  for (const place of others) {
    const at = key(place).join();
    if (!cells.has(at)) cells.set(at, []);
    cells.get(at).push(place);
  }
  let farthest = 0;
  for (const place of places) {
    const [x, y, z] = key(place);
    let nearest = Infinity;
    for (let i = 0; i < 27; i++) {
      for (const other of cells.get([x - 1 + (i % 3), y - 1 + (Math.floor(i / 3) % 3), z - 1 + Math.floor(i / 9)].join()) ?? []) {
        nearest = Math.min(nearest, Math.hypot(...place.map((value, axis) => value - other[axis])));
      }
    }
    farthest = Math.max(farthest, nearest);
  }
  return farthest;
}

export function skinChecks({ check, sample, open, mocap, pageOfFiles, pageOfText, fixture }) {
  const bar = fixture("../made/two_bones_textured.gltf");
  const worldsOf = (file, tick) => {
    const { nodes } = JSON.parse(mocap("pose", file, "--tick", String(tick), "--world", "--json"));
    return new Map(nodes.map(({ name, matrix }) => [name, matrix]));
  };

  check("the GPU moves the vertices of a skin as the file says", async (browser) => {
    const walk = fixture("cmu_12_01_walk");
    for (const name of sample.some(["bar", "human_default.glb", "human_game_engine.glb", "human_vrm0.vrm"], 2)) {
      // A character gets a motion first; its vertices do not change.
      let file = bar;
      if (name !== "bar") {
        file = pageOfText.path(`moved_${name}`);
        mocap("retarget", walk, fixture(`../characters/${name}`), "-o", file);
      }
      const { page, trouble, close } = await open(browser, pageOfFiles(file));
      const source = gltf(file);
      for (const tick of [0, 20]) {
        await page.evaluate((tick) => window.mocap.seek(tick), tick);
        await settled(page);
        const expected = skinned(source, worldsOf(file, tick));
        const found = await onGpu(page);
        // Each vertex has a counterpart in the other file. Weights have 16 bits, and `mocap pose` prints six digits.
        const error = Math.max(farthestFromNearest(found, expected, 0.01), farthestFromNearest(expected, found, 0.01));
        assert.ok(error < 1e-5, `${name} at tick ${tick}: ${error} m`);
        assert.ok(found.length >= 10);
      }
      assert.deepEqual(trouble, [], name);
      await close();
    }
  });

  check("sliders move the vertices by the morph targets of the file", async (browser) => {
    const file = fixture("../characters/human_vrm0.vrm");
    const source = gltf(file);
    const names = source.json.meshes.flatMap(({ extras }) => extras?.targetNames ?? []);
    const worlds = worldsOf(file, 0);
    const { page, trouble, close } = await open(browser, pageOfFiles(file));
    await page.click("#morphs summary");
    const labels = await page.locator("#morph-list label span").allTextContents();
    assert.deepEqual(labels, names);
    for (const weights of [[1, 0], [0.5, 1], null, [0, 0]]) {
      if (weights) for (const [index, weight] of weights.entries()) await page.locator("#morph-list input").nth(index).fill(String(weight));
      else await page.click("#morph-reset");
      await settled(page);
      const [expected, found] = [skinned(source, worlds, weights ?? []), await onGpu(page)];
      const error = Math.max(farthestFromNearest(found, expected, 0.01), farthestFromNearest(expected, found, 0.01));
      assert.ok(error < 1e-5, `weights ${weights}: ${error} m`);
    }
    // At weight 1, the mouth must differ from its rest position; otherwise a slider without effect would pass.
    assert.ok(farthestFromNearest(skinned(source, worlds, [1, 0]), skinned(source, worlds), 0.01) > 1e-3);
    assert.deepEqual(trouble, []);
    await close();
    const bare = await open(browser, pageOfFiles(bar));
    assert.equal(await bare.page.isVisible("#morphs"), false);
    await bare.close();
  });

  check("the file's own motion of morph targets plays until a slider is moved", async (browser) => {
    const file = fixture("../characters/human_vrm0.vrm");
    const source = gltf(file);
    const moving = pageOfText.path("moving.glb");
    writeFileSync(moving, withWeights(source, [0, 1], [[0, 1], [1, 0]]));
    const worlds = worldsOf(moving, 0);
    const { page, trouble, close } = await open(browser, pageOfFiles(moving));
    const rate = await page.evaluate(() => window.mocap.state.clips[0].ticksPerSecond);
    await page.click("#morphs summary");
    const hasWeights = async (seconds, weights, what) => {
      await page.evaluate((tick) => window.mocap.seek(tick), Math.round(seconds * rate));
      await settled(page);
      const [expected, found] = [skinned(source, worlds, weights), await onGpu(page)];
      const error = Math.max(farthestFromNearest(found, expected, 0.01), farthestFromNearest(expected, found, 0.01));
      assert.ok(error < 1e-5, `${what}, second ${seconds}: ${error} m`);
      const shown = await page.locator("#morph-list input").evaluateAll((inputs) => inputs.map(({ value }) => Number(value)));
      shown.forEach((value, index) => assert.ok(Math.abs(value - weights[index]) < 0.006, `${what}: ${shown}`));
    };
    for (const share of [0, 0.5, 1]) await hasWeights(share, [share, 1 - share], "in motion");
    await page.locator("#morph-list input").nth(0).fill("0.25");
    for (const share of [0, 0.5]) await hasWeights(share, [0.25, 0], "held");
    await page.click("#morph-reset");
    for (const share of [0.5, 0]) await hasWeights(share, [share, 1 - share], "in motion again");
    assert.deepEqual(trouble, []);
    await close();
  });

  check("a texture is shown, with its holes, and bends with the bones", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(bar));
    await page.evaluate(() => window.mocap.ready);
    const at = (places) => page.evaluate((places) => places.map((place) => window.mocap.placeOnPage(place)), places);
    await page.keyboard.press("1");
    for (let step = 0; step < 8; step++) await page.keyboard.press("-");
    // Half way the upper half is turned by 45 degrees about (0, 1).
    for (const [tick, [left, right]] of [[0, [[-0.15, 1.75, 0], [0.15, 1.75, 0]]], [15, [[-0.636, 1.424, 0], [-0.424, 1.636, 0]]]]) {
      await page.evaluate((tick) => window.mocap.seek(tick), tick);
      await settled(page);
      const [red, blue, hole, beside] = await colorsAt(page, await at([left, right, [0.15, 0.2, 0], [0.5, 0.2, 0]]));
      assert.ok(red[0] > 120 && red[0] > 3 * red[2], `tick ${tick}: not red: ${red}`);
      assert.ok(blue[2] > 120 && blue[2] > 3 * blue[0], `tick ${tick}: not blue: ${blue}`);
      for (const color of [hole, beside]) assert.ok(Math.min(...color.slice(0, 3)) > 110, `tick ${tick}: no hole: ${color}`);
    }
    assert.deepEqual(trouble, []);
    await close();
  });

  check("keys show the skin, the skeleton over it, or the skeleton alone", async (browser) => {
    const { page, trouble, close } = await open(browser, pageOfFiles(fixture(`../characters/${sample.some(CHARACTERS, 4)[0]}`)));
    await page.evaluate(() => window.mocap.ready);
    await settled(page);
    const pictures = [await page.locator("#view").screenshot()];
    for (const key of ["o", "m"]) {
      await page.keyboard.press(key);
      await settled(page);
      pictures.push(await page.locator("#view").screenshot());
    }
    assert.ok(new Set(pictures.map((picture) => picture.toString("base64"))).size === 3);
    assert.equal(await page.getAttribute("#skin", "aria-pressed"), "false");
    await page.keyboard.press("m");
    await page.keyboard.press("o");
    await settled(page);
    assert.ok(pictures[0].equals(await page.locator("#view").screenshot()), "the first picture does not come back");
    await page.click("#skin");
    assert.equal(await page.getAttribute("#skin", "aria-pressed"), "false");
    assert.deepEqual(trouble, []);
    await close();
  });

  check("a file with a fault in its mesh or its texture is shown without it, and says so", async (browser) => {
    const text = readFileSync(bar, "utf8");
    const edited = (edit) => {
      const file = JSON.parse(text);
      edit(file);
      return JSON.stringify(file);
    };
    const image = (bytes) => (file) => { file.images[0] = { uri: `data:image/png;base64,${bytes.toString("base64")}` }; };
    const header = (width) => {
      const bytes = Buffer.from("89504e470d0a1a0a0000000d4948445200000000000000080806000000", "hex");
      bytes.writeUInt32BE(width, 16);
      return bytes;
    };
    const faults = [
      ["vertices", (file) => { file.accessors[0].count = 1e6; }, /reach beyond their view/, false],
      ["joints", (file) => { file.skins[0].joints = [0]; }, /not.*as the skin|skin lacks/, false],
      ["large", image(header(8192)), /8192 x 8 pixels/, true],
      ["no image", image(Buffer.from("not an image")), /is not PNG, JPEG or WebP/, true],
      ["cut off", image(header(8)), /cannot be decoded/, true],
    ];
    for (const [name, edit, expected, isDrawn] of faults) {
      const { address } = pageOfText(`${name}.gltf`, edited(edit));
      const { page, trouble, close } = await open(browser, address);
      await page.evaluate(() => window.mocap.ready);
      await settled(page);
      assert.match(await page.locator("#files").textContent(), expected, name);
      assert.equal(await page.isVisible("#skin"), isDrawn, name);
      assert.equal((await page.evaluate(() => window.mocap.drawn())).length, 2, name);
      assert.deepEqual(trouble, [], name);
      await close();
    }
  });

  check("without WebGL a figure with a skin is a skeleton", async (browser) => {
    const { page, trouble, close } = await open(browser, `${pageOfFiles(bar)}#canvas2d`);
    assert.ok(!(await page.isVisible("#skin")));
    assert.deepEqual(trouble, []);
    await close();
  });
}
