// Checks figures steered by motion matching: their paths, memory, and damaged databases.

import assert from "node:assert/strict";

/** The distance along +Z in three seconds at 1.2 m/s, in metres. */
function walked(figure) {
  const begin = figure.root[1];
  for (let frame = 0; frame < 180; frame += 1) figure.steer(0, 1.2);
  return figure.root[1] - begin;
}

export function controllerChecks(check, { mocap, made, kept, real, filesOf, written, random, load }) {
  const read = (name) => kept(mocap.read(filesOf(real(name))));
  const packed = () => written(".mdb", "index", "--quiet", "--pack", "--mirror", real("cmu_12_01_walk.bvh"), "-o");

  check("controller", "a figure goes where the stick points, by scenes and by a database", () => {
    const hero = read("biovision_example1.bvh");
    const gone = [];
    for (const figure of [hero.controller([read("cmu_12_01_walk.bvh")], { mirror: true }), hero.controller(packed())]) {
      assert.equal(figure.nodeCount, hero.nodes.length);
      gone.push(walked(figure));
      assert.ok(gone.at(-1) > 2.5 && gone.at(-1) < 4.5, `${gone}`);
      assert.ok(Math.abs(Math.hypot(figure.root[2], figure.root[3]) - 1) < 1e-4);
      // The hips are above the root. World matrices are the products of the matrices relative to the parents.
      const hips = figure.nodeToWorld.subarray(12, 15);
      assert.ok(Math.hypot(hips[0] - figure.root[0], hips[2] - figure.root[1]) < 0.3 && hips[1] > 0.4, `${hips}`);
      assert.ok(figure.nodeToParent.every(Number.isFinite));
      // Left of a figure that faces +Z is +X.
      for (let frame = 0; frame < 240; frame += 1) figure.steer(1, 0);
      assert.ok(figure.root[0] > 0.5, `${figure.root}`);
      const [x, z] = figure.root;
      figure.follow([x, z, x, z, x, z, 0, 1, 0, 1, 0, 1]);
      figure.free();
    }
    assert.ok(Math.abs(gone[0] - gone[1]) < 0.05, `${gone}`);
  });

  check("controller", "a motion of a robot is scored against its reference", () => {
    const walk = read("cmu_short.bvh");
    const robot = kept(mocap.readCharacter(filesOf(real("../robots/h1.urdf"))));
    const moved = kept(walk.retarget(robot, { passes: 1 }));
    const [own, found] = [moved.reports[0], walk.score(moved, robot)];
    assert.ok(Math.abs(found.scores.mpbpe_local - own.scores.mpbpe_local) < 1e-6, JSON.stringify(found.scores));
    assert.throws(() => walk.score(walk, robot), /no arrays of a robot's joints/);
    assert.throws(() => walk.score(moved, walk), /readCharacter/);
    const slow = kept(walk.retarget(robot, { passes: 1, timeScale: 0.5 }));
    assert.equal(slow.robotMotion().frames, 2 * moved.robotMotion().frames - 1);
    assert.throws(() => walk.robotStream(robot, { timeScale: "auto" }), /leave out timeScale/);
  });

  check("controller", "a robot follows poses that come, and has a report", () => {
    const walk = read("cmu_short.bvh");
    const robot = kept(mocap.readCharacter(filesOf(real("../robots/h1.urdf"))));
    const stream = walk.robotStream(robot, { fps: 30, passes: 1 });
    assert.equal(stream.jointNames.length, 19);
    assert.ok(Math.abs(stream.delay - 0.1) < 1e-9);
    assert.equal(stream.report(), null);
    const frames = [];
    for (let tick = 0; tick < 12; tick += 1) frames.push(stream.push(walk.pose(tick).nodeToParent));
    assert.deepEqual(frames.map((frame) => frame !== null), [...Array(12).keys()].map((tick) => tick >= 3));
    assert.ok(frames.at(-1).rootPositions[2] > 0.5 && frames.at(-1).positions.length === 19);
    const left = stream.finish();
    assert.deepEqual([left.frames, left.positions.length, left.contacts.length], [3, 57, 3]);
    const report = stream.report();
    assert.deepEqual([report.frames, report.limit_violations], [12, 0]);
    assert.throws(() => stream.push([1]), /the pose has 1 numbers/);
    assert.throws(() => stream.push(new Float32Array(16 * walk.nodes.length).fill(NaN)), /not finite/);
    assert.throws(() => walk.robotStream(robot, { fps: 0 }), /from 1 to 1000/);
    assert.throws(() => walk.robotStream(robot, { passes: 3 }), /passes must be 1 or 2, got 3/);
    assert.throws(() => walk.robotStream(robot, { feet: "off" }), /feet/);
    assert.throws(() => walk.robotStream(robot, { characterBones: { leftFoot: "none" } }), /none/);
    assert.throws(() => walk.robotStream(walk), /readCharacter/);
    stream.free();
    assert.throws(() => stream.finish(), { code: "freed" });
  });

  check("controller", "a frame allocates nothing, and a figure stays while memory grows", async () => {
    const fresh = await load();
    const hero = fresh.read(filesOf(real("biovision_example1.bvh")));
    const figure = hero.controller([fresh.read(filesOf(real("cmu_12_01_walk.bvh")))]);
    // Use small integers. In a call that is not inlined, other numbers are objects of 16 bytes, which the figure does not cause.
    const many = (count) => {
      for (let index = 0; index < count; index += 1) figure.steer(((index >> 7) % 3) - 1, (index >> 9) & 1);
    };
    // Run the function first, because the JavaScript compiler takes memory for its machine code.
    many(30_000);
    const memory = fresh.memory;
    globalThis.gc();
    const before = process.memoryUsage().heapUsed;
    many(30_000);
    const taken = process.memoryUsage().heapUsed - before;
    assert.ok(taken < 300_000, `${taken} bytes of JavaScript`);
    assert.equal(fresh.memory, memory);
    const scenes = [];
    while (fresh.memory === memory) scenes.push(fresh.read(filesOf(real("rokoko_dance.bvh"))));
    const root = [...figure.root];
    figure.steer(0, 1);
    assert.ok(Math.hypot(figure.root[0] - root[0], figure.root[1] - root[1]) < 0.2);
    figure.free();
    assert.throws(() => figure.steer(0, 1), { code: "freed" });
    assert.throws(() => figure.root, { code: "freed" });
  });

  check("controller", "wrong motions and damaged databases give an error, never the end of the module", () => {
    const hero = read("biovision_example1.bvh");
    assert.throws(() => hero.controller([]), { code: "invalid-value" });
    assert.throws(() => hero.controller([{}]), TypeError);
    assert.throws(() => hero.controller([read("leap_hand_end_site_lowercase.bvh")]), /two feet/);
    assert.throws(() => read("leap_hand_end_site_lowercase.bvh").controller(packed()), { code: "not-humanoid" });
    const byReference = written(".mdb", "index", "--quiet", real("cmu_12_01_walk.bvh"), "-o");
    assert.throws(() => hero.controller(byReference), /--pack/);
    const whole = packed();
    for (let round = 0; round < 40; round += 1) {
      assert.throws(() => hero.controller(whole.slice(0, random(whole.length))));
      // Copy the bytes, because a slice of a Node buffer shares its memory.
      const bytes = Uint8Array.from(whole);
      bytes[random(bytes.length)] ^= 1 + random(255);
      assert.throws(() => hero.controller(bytes));
    }
    const figure = hero.controller(whole);
    assert.throws(() => figure.follow([0, 1]), RangeError);
    for (const number of [NaN, Infinity, 1e30]) {
      figure.steer(number, number, number, number);
      figure.follow(new Array(12).fill(number));
    }
    made(() => figure.free());
  });
}
