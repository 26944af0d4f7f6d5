// Checks packed clips: bytes equal to the program's, poses, memory, and damaged files.

import assert from "node:assert/strict";

import { MocapError } from "./package/index.js";

/** Interpolates two rotations component by component, along the shorter arc. */
function nlerp(a, b, share) {
  const sign = a.reduce((sum, value, index) => sum + value * b[index], 0) < 0 ? -1 : 1;
  const mixed = a.map((value, index) => (1 - share) * value + sign * share * b[index]);
  const length = Math.hypot(...mixed);
  return mixed.map((value) => value / length);
}

const lerp = (a, b, share) => a.map((value, index) => value + share * (b[index] - value));

/** The value of a track between its keys. */
function valueAt({ ticks, values }, width, tick, mix) {
  const key = (index) => [...values.subarray(width * index, width * (index + 1))];
  const after = ticks.findIndex((other) => other > tick);
  if (after <= 0) return key(after === 0 || ticks.length === 1 ? 0 : ticks.length - 1);
  return mix(key(after - 1), key(after), (tick - ticks[after - 1]) / (ticks[after] - ticks[after - 1]));
}

export function clipChecks(check, { mocap, made, kept, real, filesOf, written, assertSame, random, load }) {
  check("clip", "packed clips are those of `mocap convert`", () => {
    for (const [name, maxError] of [["cmu_short.bvh", 0.001], ["lecture_Test.bvh", 0.0001], ["kinect_openni.bvh", 0.02]]) {
      const bytes = kept(mocap.read(filesOf(real(name)))).toMclip({ maxError });
      assertSame(bytes, written(".mclip", "convert", "--quiet", "--max-error", `${maxError * 1000}mm`, real(name)), name);
    }
    const usual = kept(mocap.read(filesOf(real("cmu_short.bvh")))).toMclip();
    assertSame(usual, written(".mclip", "convert", "--quiet", real("cmu_short.bvh")), "the usual error");
  });

  check("clip", "poses are those of the keys, and a clip is read as a scene", () => {
    for (const [name, maxError] of [["cmu_short.bvh", 0.0001], ["kinect_openni.bvh", 0.01]]) {
      const source = kept(kept(mocap.read(filesOf(real(name)))).convert());
      const bytes = source.toMclip({ maxError });
      const clip = mocap.openClip(bytes);
      const scene = kept(mocap.read(bytes, "clip", { skeletonMesh: "none", collapseKeys: false }));
      const [animation] = scene.animations;
      assert.deepEqual(clip.nodes.map(({ name, parent }) => [name, parent]), source.nodes.map(({ name, parent }) => [name, parent]));
      assert.deepEqual(clip.nodes.map(({ isEndSite }) => isEndSite), source.nodes.map(({ kind }) => kind === "end_site"));
      const ofClip = ({ ticksPerSecond, duration, frameCount }) => [ticksPerSecond, duration, frameCount];
      assert.deepEqual(ofClip(clip), ofClip(source.animations[0]));
      assert.deepEqual(ofClip(clip), ofClip(animation));
      assert.equal(clip.bytes, bytes.length);
      assert.ok(clip.maxError > 0 && clip.maxError <= maxError);
      const pose = new Float32Array(clip.poseLength);
      const tracks = animation.channels.map(({ node, positions, rotations, scales }) => {
        const copy = ({ ticks, values }) => ({ ticks: ticks.slice(), values: values.slice() });
        return { node, positions: copy(positions), rotations: copy(rotations), scales: copy(scales) };
      });
      for (const tick of [-1, 0, 0.25, 7, 30.75, clip.duration - 0.5, clip.duration, clip.duration + 9]) {
        assert.equal(clip.sample(tick, pose), pose);
        for (const { node, positions, rotations, scales } of tracks) {
          const expected = [...valueAt(positions, 3, tick, lerp), ...valueAt(rotations, 4, tick, nlerp), ...valueAt(scales, 3, tick, lerp)];
          expected.forEach((value, index) => {
            const found = pose[10 * node + index];
            assert.ok(Math.abs(found - value) < 1e-5, `${name}, tick ${tick}, node ${node}, number ${index}: ${found}, not ${value}`);
          });
        }
      }
      clip.free();
    }
  });

  check("clip", "a clip stays where it is while memory grows, and a pose needs its room", async () => {
    const fresh = await load();
    const clip = fresh.openClip(made(() => kept(mocap.read(filesOf(real("cmu_short.bvh")))).toMclip()));
    const [before, after] = [new Float32Array(clip.poseLength), new Float32Array(clip.poseLength + 5)];
    clip.sample(33.3, before);
    const memory = fresh.memory;
    const scenes = [];
    while (fresh.memory === memory) scenes.push(fresh.read(filesOf(real("rokoko_dance.bvh"))));
    clip.sample(33.3, after);
    assert.deepEqual(after.subarray(0, clip.poseLength), before);
    assert.throws(() => clip.sample(0, new Float32Array(clip.poseLength - 1)), RangeError);
    clip[Symbol.dispose ?? Symbol.for("Symbol.dispose")]?.();
    clip.free();
    assert.throws(() => clip.sample(0, before), { code: "freed" });
  });

  check("clip", "sampling allocates nothing", () => {
    const clip = mocap.openClip(kept(mocap.read(filesOf(real("cmu_12_01_walk.bvh")))).toMclip());
    const pose = new Float32Array(clip.poseLength);
    const many = (count) => {
      for (let index = 0; index < count; index += 1) clip.sample((index * 37) % 523, pose);
    };
    // Run the function first, because the JavaScript compiler takes memory for its machine code.
    many(30_000);
    const memory = mocap.memory;
    globalThis.gc();
    const before = process.memoryUsage().heapUsed;
    many(100_000);
    const taken = process.memoryUsage().heapUsed - before;
    // A call that allocates takes at least 12 bytes.
    assert.ok(taken < 600_000, `${taken} bytes of JavaScript`);
    assert.equal(mocap.memory, memory);
    clip.free();
  });

  check("clip", "cut and damaged clips give an error or a pose, never the end of the module", () => {
    const whole = kept(mocap.read(filesOf(real("cmu_short.bvh")))).toMclip({ maxError: 0.02 });
    const pose = new Float32Array(10 * 38);
    const opened = (bytes) => made(() => mocap.openClip(bytes));
    for (let round = 0; round < 300; round += 1) {
      assert.equal(opened(whole.slice(0, random(whole.length))), null);
      const bytes = whole.slice();
      for (let flips = 1 + random(4); flips > 0; flips -= 1) bytes[random(round % 2 ? bytes.length : 400)] = random(256);
      const clip = opened(bytes);
      if (clip === null) continue;
      for (const tick of [0, 7.7, 1e300, NaN]) if (clip.poseLength <= pose.length) clip.sample(tick, pose);
      clip.free();
      made(() => mocap.read(bytes, "damaged.mclip").free());
    }
    assert.throws(() => mocap.openClip(filesOf(real("cmu_short.bvh"))[0].bytes), MocapError);
  });
}
