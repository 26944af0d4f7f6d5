// Groups dropped or selected files into items of files that belong together.

import { MOTION } from "./formats.js";

/** Files that others refer to. */
const BESIDE = /\.(asf|bin|png|jpe?g|webp|ktx2|stl|obj|dae)$/i;
const ROBOT = /\.(urdf|xml|mjcf)$/i;
const MESH = /\.(stl|obj|dae)$/i;

const folderOf = (path) => path.slice(0, path.lastIndexOf("/") + 1);

/** The files of a dropped folder with their paths, without hidden files. */
async function filesBelow(handle, path, found) {
  if (handle.name.startsWith(".")) return;
  if (handle.kind === "file") {
    found.push({ file: await handle.getFile(), path });
    return;
  }
  for await (const [name, child] of handle.entries()) await filesBelow(child, `${path}/${name}`, found);
}

async function entriesBelow(entry, path, found) {
  if (entry.name.startsWith(".")) return;
  if (entry.isFile) {
    found.push({ file: await new Promise((done, failed) => entry.file(done, failed)), path });
    return;
  }
  const reader = entry.createReader();
  // A directory reader returns 100 entries at a time.
  for (;;) {
    const entries = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (!entries.length) return;
    for (const child of entries) await entriesBelow(child, `${path}/${child.name}`, found);
  }
}

/** The files of a drop, each with its path. */
export async function droppedFiles(transfer) {
  // Request all entries before the first `await`, because the browser clears the drop's data afterwards.
  const parts = Array.from(transfer.items, (item) => {
    if (item.kind !== "file") return null;
    const entry = item.webkitGetAsEntry?.();
    if (!entry?.isDirectory) return { file: item.getAsFile() };
    return { entry, handle: item.getAsFileSystemHandle?.().catch(() => null) };
  });
  const found = [];
  for (const part of parts) {
    if (part?.file) found.push({ file: part.file, path: part.file.name });
    if (!part?.entry) continue;
    const handle = await part.handle;
    if (handle) await filesBelow(handle, handle.name, found);
    else await entriesBelow(part.entry, part.entry.name, found);
  }
  return found;
}

/** The files of an input element, each with its path. */
export const chosenFiles = (input) => Array.from(input.files, (file) => ({ file, path: file.webkitRelativePath || file.name }));

/** The path of a file from a folder, such as "../meshes/a.stl". */
function pathFrom(folder, path) {
  const [from, to] = [folder.split("/").slice(0, -1), path.split("/")];
  let same = 0;
  while (same < from.length && same < to.length - 1 && from[same] === to[same]) same++;
  return [...from.slice(same).map(() => ".."), ...to.slice(same)].join("/");
}

/**
 * The items in the order of their paths. A motion has the files to which it may refer. An .amc has the .asf of its folder, or
 * any .asf if its folder has none. A .gltf has the files below its folder. A single file is always an item, because its
 * contents determine the format. Among several files, unknown names are skipped.
 */
export function itemsOf(all) {
  const sorted = [...all].sort((a, b) => a.path.localeCompare(b.path, undefined, { numeric: true }));
  const motions = sorted.filter(({ path }) => MOTION.test(path));
  const hasMotion = (folder) => motions.some((motion) => /\.amc$/i.test(motion.path) && folderOf(motion.path).startsWith(folder));
  const skeletons = sorted.filter(({ path }) => /\.asf$/i.test(path));
  // A skeleton without a motion is an item.
  const lone = skeletons.filter(({ path }) => !hasMotion(folderOf(path)) && !motions.some((motion) => /\.amc$/i.test(motion.path)));
  const single = sorted.length === 1 && !motions.length && !lone.length ? sorted : [];
  const items = [...motions, ...lone, ...single].map((motion) => {
    const folder = folderOf(motion.path);
    const isBelow = ({ path }) => path.startsWith(folder);
    let beside = [];
    if (/\.amc$/i.test(motion.path)) {
      const near = skeletons.filter(({ path }) => folderOf(path) === folder);
      beside = near.length ? near : skeletons;
    }
    if (/\.gltf$/i.test(motion.path)) beside = sorted.filter((file) => file !== motion && BESIDE.test(file.path) && isBelow(file));
    // The meshes of a robot may be in a folder next to the folder of its file.
    if (ROBOT.test(motion.path)) beside = sorted.filter(({ path }) => MESH.test(path));
    const together = [motion, ...beside];
    const nameOf = (file) => {
      if (isBelow(file)) return file.path.slice(folder.length);
      return MESH.test(file.path) ? pathFrom(folder, file.path) : file.path.split("/").pop();
    };
    return {
      path: motion.path,
      name: motion.path.split("/").pop(),
      files: together.map(({ file }) => file),
      names: together.map(nameOf),
    };
  });
  return { items, passedOver: sorted.filter((file) => !BESIDE.test(file.path) && !items.some((item) => item.files.includes(file.file))) };
}
