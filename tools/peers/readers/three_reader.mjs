// three.js: BVHLoader, then an AnimationMixer on the root bone, as the loader's own example plays a clip.
//
//     node three_reader.mjs FOLDER_OF_THREE FILE last|FRAME replace|add OUT
//
// The bytes become text as in a browser: UTF-8, without a byte order mark. `said` keeps the loader's warnings on the
// console.

import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [three, file, frame, , out] = process.argv.slice(2);
const { AnimationMixer, LoopOnce, Vector3 } = await import(pathToFileURL(`${three}/build/three.module.js`));
const { BVHLoader } = await import(pathToFileURL(`${three}/examples/jsm/loaders/BVHLoader.js`));

const said = [];
console.error = console.warn = (...words) => said.push(words.join(' '));

const text = new TextDecoder().decode(readFileSync(file));
const { skeleton, clip } = new BVHLoader().parse(text);
const root = skeleton.bones[0];

const times = clip.tracks[0]?.times ?? [];
const frames = times.length;
if (frames > 0) {
  const mixer = new AnimationMixer(root);
  const action = mixer.clipAction(clip);
  // Without these settings, the clip restarts at its last key.
  action.setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  action.play();
  mixer.setTime(frame === 'last' ? times[frames - 1] : times[Math.min(Number(frame), frames - 1)]);
}
root.updateMatrixWorld(true);

const nodes = skeleton.bones.map((bone) => ({
  name: bone.name,
  parent: bone.parent ? skeleton.bones.indexOf(bone.parent) : null,
  position: new Vector3().setFromMatrixPosition(bone.matrixWorld).toArray(),
  end: bone.name === 'ENDSITE',
  optional: false,
}));
const rate = frames > 1 ? 1 / (times[1] - times[0]) : null;
writeFileSync(out, JSON.stringify({ frames, rate, nodes, said }));
