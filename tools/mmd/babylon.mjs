// Poses a model with babylon-mmd's bones, IK and inheritance. Reads {bones, frames} as JSON, and writes the 16 numbers
// of a matrix for each frame and bone. MODULES is the folder with node_modules.
import { readFileSync, writeFileSync } from "node:fs";
import { register } from "node:module";
import { pathToFileURL } from "node:url";

// The package's imports omit `.js`, as bundlers allow.
const hook = `export const resolve = (name, context, next) => next(name, context).catch((error) => {
  if (name.endsWith(".js")) throw error;
  return next(name + ".js", context);
});`;
register(`data:text/javascript,${encodeURIComponent(hook)}`);

const [modules, input, output] = process.argv.slice(2);
const load = (path) => import(pathToFileURL(`${modules}/node_modules/${path}`));
const { Matrix, Quaternion, Vector3 } = await load("@babylonjs/core/Maths/math.vector.js");
const { MmdModel } = await load("babylon-mmd/esm/Runtime/mmdModel.js");

const { bones, frames } = JSON.parse(readFileSync(input, "utf8"));
const place = new Map(bones.map((bone, index) => [bone.name, index]));
const linked = bones.map((bone) => {
  const parent = bone.parent === null ? [0, 0, 0] : bones[place.get(bone.parent)].at;
  const rest = Matrix.Translation(...bone.at.map((value, axis) => value - parent[axis]));
  return {
    position: new Vector3(),
    rotationQuaternion: new Quaternion(),
    scaling: Vector3.One(),
    getRestMatrix: () => rest,
    getAbsoluteInverseBindMatrix: () => Matrix.Translation(...bone.at.map((value) => -value)),
  };
});
const metadata = bones.map((bone) => {
  const inherits = bone.turns ?? bone.moves;
  return {
    name: bone.name,
    parentBoneIndex: bone.parent === null ? -1 : place.get(bone.parent),
    transformOrder: bone.layer ?? 0,
    flag: (bone.flags ?? 0) | (bone.turns ? 0x0100 : 0) | (bone.moves ? 0x0200 : 0),
    appendTransform: inherits && { parentIndex: place.get(inherits[0]), ratio: inherits[1] },
    axisLimit: (bone.flags ?? 0) & 0x0400 ? bone.axis : undefined,
    ik: bone.ik && {
      target: place.get(bone.ik[0]),
      iteration: bone.ik[1],
      rotationConstraint: bone.ik[2],
      links: bone.ik[3].map(([link, limits]) => ({
        target: place.get(link),
        limitation: limits === null ? undefined : { minimumAngle: limits[0], maximumAngle: limits[1] },
      })),
    },
  };
});
const matrices = new Float32Array(16 * bones.length);
const runtime = MmdModel.prototype._buildRuntimeSkeleton.call({ _logger: console }, linked, metadata, [], matrices, false);
const solvers = runtime.map((bone) => bone.ikSolver);
const isLate = (bone) => bone.transformAfterPhysics;
const order = [...runtime].sort((a, b) => isLate(a) - isLate(b) || a.transformOrder - b.transformOrder);
const results = frames.map(({ own, off }) => {
  runtime.forEach((bone, index) => {
    const [position, rotation] = own[index];
    linked[index].getRestMatrix().getTranslationToRef(linked[index].position);
    linked[index].position.addInPlaceFromFloats(...position);
    linked[index].rotationQuaternion.copyFromFloats(...rotation);
    bone.ikSolver = off.includes(bone.name) ? null : solvers[index];
    bone.resetTransformState();
  });
  order.forEach((bone) => bone.updateWorldMatrix(false, true));
  // An IK bone rotates links that precede it in `order`. So compute all matrices again, without IK.
  order.forEach((bone) => {
    const solver = bone.ikSolver;
    bone.ikSolver = null;
    bone.updateWorldMatrix(false, false);
    bone.ikSolver = solver;
  });
  return Array.from(matrices);
});
writeFileSync(output, JSON.stringify(results));
