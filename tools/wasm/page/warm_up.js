// Reads invisible figures to warm up the module. A browser compiles a WebAssembly function at its first call, and optimizes it
// only after many calls. Without a warm-up, the first file would take several times as long as the second.

/** A joint: its name, its OFFSET, and its children. */
const LEG = (side, x) => [`${side}UpLeg`, [x, -5, 0], [`${side}Leg`, [0, -42, 0], [`${side}Foot`, [0, -40, 0], [`${side}ToeBase`, [0, -6, 14]]]]];
const ARM = (side, x) => [`${side}Shoulder`, [x, 28, 0], [`${side}Arm`, [2 * x, 0, 0], [`${side}ForeArm`, [4 * x, 0, 0], [`${side}Hand`, [4 * x, 0, 0]]]]];
const FIGURE = [
  "Hips", [0, 93, 0], LEG("Left", 9), LEG("Right", -9),
  ["Spine", [0, 12, 0], ["Spine1", [0, 14, 0], ["Neck", [0, 30, 0], ["Head", [0, 10, 0]]], ARM("Left", 7), ARM("Right", -7)]],
];

function joint([name, offset, ...children], isRoot) {
  const channels = isRoot ? "6 Xposition Yposition Zposition Zrotation Yrotation Xrotation" : "3 Zrotation Yrotation Xrotation";
  const below = children.length ? children.map((child) => joint(child, false)).join("") : "End Site\n{\nOFFSET 0 5 0\n}\n";
  return `${isRoot ? "ROOT" : "JOINT"} ${name}\n{\nOFFSET ${offset.join(" ")}\nCHANNELS ${channels}\n${below}}\n`;
}

/** A BVH file of a walking figure. */
function motionText(frames) {
  const hierarchy = joint(FIGURE, true);
  const columns = (hierarchy.match(/rotation/g) ?? []).length;
  const row = (_, frame) => {
    const angles = Array.from({ length: columns }, (_, column) => (20 * Math.sin(frame / 30 + column)).toFixed(4));
    return `${[Math.sin(frame / 60) * 40, 93, frame / 4].map((value) => value.toFixed(4)).join(" ")} ${angles.join(" ")}`;
  };
  return `HIERARCHY\n${hierarchy}MOTION\nFrames: ${frames}\nFrame Time: 0.0083333\n${Array.from({ length: frames }, row).join("\n")}\n`;
}

/** Reads such files while the worker is idle. The files are short, so that requests need not wait. */
export async function warmUp(mocap, isNeeded) {
  const text = motionText(300);
  for (let round = 0; round < 24; round++) {
    await new Promise((done) => setTimeout(done));
    if (!isNeeded()) return;
    const scene = mocap.read(text, "warm-up.bvh");
    scene.toPlayer("warm-up");
    scene.free();
  }
}
