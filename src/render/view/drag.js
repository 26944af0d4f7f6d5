// Converts dragged ends of limbs and chains to steps of `mocap edit`: a command to copy, and JSON for the libraries.

import { dot, scale } from "./math.js";
import { byId, make } from "./dom.js";

const LIMBS = { leftHand: "left-hand", rightHand: "right-hand", leftFoot: "left-foot", rightFoot: "right-foot" };
// Rows of the matrices that rotate the file's up axis to +Y. `mocap edit` does this for every output format except BVH.
const Y_UP = {
  "+y": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  "-y": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
  "+z": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  "-z": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
};

const metres = (value) => Number(value.toFixed(4));
// Rotates a position from the file's axes to +Y up.
export const turnedUp = (place, up) => (Y_UP[up] ?? Y_UP["+y"]).map((row) => metres(dot(row, place)));
// Quotes a word for a shell.
export const quoted = (name) => (/^[\w.][\w.-]*$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);

// The command and the JSON that move the dragged limbs of a clip to their current positions, in the current frame.
export function stepsOf(clip) {
  const frame = `${Math.round(clip.tick)}f`;
  const { goals, limbs, chains } = clip.posing;
  const moved = (end) => (limbs.has(end)
    ? { limb: LIMBS[clip.nodes[end].bone.name] }
    : { start: clip.nodes[chains.get(end)[0]].name, tip: clip.nodes[end].name });
  const steps = [...goals].map(([end, goal]) => ({
    step: "reach", ...moved(end), to: scale(goal, clip.metresPerUnit).map(metres), range: `${frame}..${frame}`,
  }));
  // Positions for BVH output and for the libraries are in the axes of the source file.
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
    // Without permission to copy, the page selects the text.
    shown.textContent = text;
    getSelection().selectAllChildren(shown);
  }
}

// Shows the steps while a limb is dragged. A page that can apply steps passes `keep(clip, steps)`.
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
