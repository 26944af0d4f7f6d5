// What a drag of the ends of limbs and chains shows, as steps of `mocap edit`: to copy as a command, and as JSON for the libraries.

import { dot, scale } from "./math.js";
import { byId, make } from "./dom.js";

const LIMBS = { leftHand: "left-hand", rightHand: "right-hand", leftFoot: "left-foot", rightFoot: "right-foot" };
// The rows that bring a direction of the file to +Y up, as `mocap edit` does where it writes anything but BVH.
const Y_UP = {
  "+y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "+z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  "-z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
};

const metres = (value) => Number(value.toFixed(4));
// A place in the file's axes, +Y up.
export const turnedUp = (place, up) => (Y_UP[up] ?? Y_UP["+y"]).map((row) => metres(dot(row, place)));
// A word of a command line.
export const quoted = (name) => (/^[\w.][\w.-]*$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);

// The command and the JSON that bring the dragged limbs of a clip to where they are, in this frame.
export function stepsOf(clip) {
  const frame = `${Math.round(clip.tick)}f`;
  const { goals, limbs, chains } = clip.posing;
  const moved = (end) => (limbs.has(end)
    ? { limb: LIMBS[clip.nodes[end].bone.name] }
    : { start: clip.nodes[chains.get(end)[0]].name, tip: clip.nodes[end].name });
  const steps = [...goals].map(([end, goal]) => ({
    step: "reach", ...moved(end), to: scale(goal, clip.metresPerUnit).map(metres), range: `${frame}..${frame}`,
  }));
  // BVH keeps the axes of its source; the library has those of the file too.
  const file = clip.file ?? "FILE";
  const isBvh = /\.bvh$/i.test(file);
  const turned = (to) => (isBvh ? to : turnedUp(to, clip.up));
  const texts = steps.map(({ limb, start, tip, to, range }) => {
    const what = limb ? `limb=${limb}` : `start=${start},tip=${tip}`;
    const text = `reach:${what},to=${turned(to).join("/")},range=${range}`;
    return /^[\w.:=,/-]+$/.test(text) ? text : quoted(text);
  });
  const stem = file.replace(/\.\w+$/, "");
  const output = `${stem}_edited.${isBvh ? "bvh" : "glb"}`;
  return { command: ["mocap edit", quoted(file), "-o", quoted(output), ...texts.map((text) => `--step ${text}`)].join(" "), json: JSON.stringify(steps), steps };
}

export async function copy(text, shown) {
  try {
    await navigator.clipboard.writeText(text);
    byId("said").textContent = "Copied";
  } catch {
    // A page without the right to copy marks the text.
    shown.textContent = text;
    getSelection().selectAllChildren(shown);
  }
}

// Shows the steps beside the picture while a limb is dragged, and nothing otherwise. A page that can apply steps keeps them by
// `keep(clip, steps)`.
export function showSteps(clips, keep) {
  const clip = clips.find(({ posing }) => posing.goals.size);
  const before = document.getElementById("drag");
  const steps = clip && stepsOf(clip);
  if (!steps || before?.title !== steps.json) before?.remove();
  if (!steps || before?.title === steps.json) return;
  const text = make("code", {}, steps.command);
  byId("view").append(make("div", { id: "drag", title: steps.json }, text,
    ...(keep ? [make("button", { class: "main", onclick: () => keep(clip, steps.steps) }, "Keep as a step"), " "] : []),
    make("button", { onclick: () => copy(steps.command, text) }, "Copy command"),
    make("button", { onclick: () => copy(steps.json, text) }, "Copy JSON")));
}
