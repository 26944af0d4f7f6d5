// The reader, in a worker so that the page stays responsive. It executes requests one by one. Each request has its files, so
// that a restarted reader needs no earlier state.
//
// A request is { id, call, item, ... }. An item has
//   id          a number, never used again
//   files       the Files that belong together, the motion first
//   names       their names, as the motion refers to them
//   read        options of Mocap.read()
//   change      options of Scene.convert(), without those that change the unit of the output
//   steps       steps of Scene.edit(), as text
//   onto        null, or { id, files, names }: the character to which the motion is retargeted
//   retarget    options of Scene.retarget()

import { load } from "../package/index.js";
import { fromLzma } from "./lzma.js";
import { warmUp } from "./warm_up.js";

let mocap;
let isAsked = false;

/** The number of cached scenes, so that changes of the last files do not read them again. */
const KEPT = 6;
const scenes = new Map();

/** The cached scene of a key, or a new scene. */
async function kept(key, make) {
  const scene = scenes.get(key) ?? (await make());
  // The least recently used scene is freed first.
  scenes.delete(key);
  scenes.set(key, scene);
  for (const [oldest, old] of scenes) {
    if (scenes.size <= KEPT) break;
    scenes.delete(oldest);
    old.free();
  }
  return scene;
}

/** Reads the files of an item. Long files are read in pieces. */
async function inputs({ files, names }, report) {
  const total = files.reduce((sum, file) => sum + file.size, 0);
  let done = 0;
  const read = async (file) => {
    const bytes = new Uint8Array(file.size);
    let at = 0;
    for (const reader = file.stream().getReader(); ; ) {
      const { done: isOver, value } = await reader.read();
      if (isOver) return bytes;
      bytes.set(value, at);
      at += value.length;
      done += value.length;
      report(done / total);
    }
  };
  const all = [];
  for (const [index, file] of files.entries()) {
    all.push({ name: names[index], bytes: total < 4 << 20 ? await file.arrayBuffer() : await read(file) });
  }
  return all;
}

async function sceneOf(item, report) {
  const { id, read, change, steps, onto, retarget } = item;
  const base = await kept(JSON.stringify([id, read]), async () => {
    const files = await inputs(item, (share) => report("reading", share));
    report("parsing");
    if (isRobot(item)) return mocap.readCharacter(files, { gltfMeshes: true, morphTargets: true });
    return mocap.read(files, { skeletonMesh: "skinned", gltfMeshes: true, morphTargets: true, ...read });
  });
  // Steps need the motion without a rest pose before it, as in `mocap edit`.
  const wanted = steps.length && !change.firstFrame ? { ...change, firstFrame: "auto" } : change;
  const converted = Object.keys(wanted).length
    ? await kept(JSON.stringify([id, read, wanted]), () => base.convert({ ...wanted, keepUnits: true }))
    : base;
  if (steps.length) report("editing");
  const changed = steps.length ? await kept(JSON.stringify([id, read, change, steps]), () => converted.edit(steps)) : converted;
  if (!onto) return changed;
  const character = await kept(JSON.stringify([onto.id, "character"]), async () => {
    const files = await inputs(onto, (share) => report("reading", share));
    return mocap.readCharacter(files, { gltfMeshes: true, morphTargets: true });
  });
  report("retargeting");
  return kept(JSON.stringify([id, read, change, steps, onto.id, retarget]), () => changed.retarget(character, { ...retarget, limbAngles: true }));
}

/** A robot is read as a character, and is never a motion. */
const isRobot = ({ names }) => /\.(urdf|xml|mjcf)$/i.test(names[0]);

/** The facts of a scene for the list. */
function facts(scene) {
  const [animation] = scene.animations;
  return {
    warnings: scene.warnings,
    joints: scene.nodes.filter((node) => node.kind === "joint").length,
    frames: animation?.frameCount ?? 0,
    ticksPerSecond: animation?.ticksPerSecond ?? 0,
    format: scene.metadata.format,
    hasSkin: scene.meshCount > 0 && scene.metadata.format !== "bvh",
    clips: scene.animations.map(({ name, duration, ticksPerSecond }) => ({ name, seconds: duration / ticksPerSecond })),
  };
}

const calls = {
  /** Reads a file only for the list. */
  async inspect({ item }, report) {
    const files = await inputs(item, (share) => report("reading", share));
    report("parsing");
    const scene = isRobot(item) ? mocap.readCharacter(files) : mocap.read(files, { ...item.read, skeletonMesh: "none", hash: false });
    const found = facts(scene);
    scene.free();
    return [found];
  },

  /** The clip for the player. */
  async show({ item, name }, report) {
    const scene = await sceneOf(item, report);
    report("packing");
    const shown = scene.toPlayer(name);
    // The reports of a retargeted motion describe retargeting; other reports describe steps.
    const [retargeted] = item.onto ? scene.reports : [];
    const edits = item.onto ? [] : scene.reports;
    // The joints of a robot over time, with their limits.
    const robot = item.onto && isRobot(item.onto) ? scene.robotMotion() : null;
    return [{ ...facts(scene), ...shown, retargeted, edits, robot }, shown.blocks.map(([, bytes]) => bytes.buffer)];
  },

  /** The available steps. */
  async steps() {
    return [mocap.steps];
  },

  /** The joints of a robot, for an archive of arrays. */
  async robotMotion({ item }, report) {
    return [(await sceneOf(item, report)).robotMotion()];
  },

  /** The bytes of a file to save. */
  async save({ item, name, format, options }, report) {
    const scene = await sceneOf(item, report);
    report("writing");
    // Only a picture shows the name of the clip.
    const written = scene.write(format, format === "png" ? { name } : options);
    return [{ bytes: written.bytes, warnings: written.warnings }, [written.bytes.buffer]];
  },
};

onmessage = async ({ data }) => {
  if (data.wasm) {
    mocap = await load(fromLzma(data.wasm));
    postMessage({ ready: true });
    await warmUp(mocap, () => !isAsked);
    postMessage({ warm: true });
    return;
  }
  if (data.forget !== undefined) {
    for (const [key, scene] of scenes) {
      if (JSON.parse(key)[0] !== data.forget) continue;
      scenes.delete(key);
      scene.free();
    }
    return;
  }
  isAsked = true;
  const { id } = data;
  const report = (stage, share) => postMessage({ id, stage, share });
  try {
    const [answer, transfer] = await calls[data.call](data, report);
    postMessage({ id, answer }, transfer ?? []);
  } catch (error) {
    const { name, code, message, reason, file, line, column, length, text, joint, pointer, expected, found, help, warnings } = error;
    postMessage({ id, error: { name, code, message, reason, file, line, column, length, text, joint, pointer, expected, found, help, warnings } });
  }
};
