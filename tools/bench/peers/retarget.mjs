// Prints how many poses three.js retargets in a second of processor time, the best of five runs, as JSON. Arguments: a
// BVH file, a .gltf file whose nodes are the target's bones, and the source bone for each target bone, by name.
import { readFileSync } from "node:fs";
import { Bone, BufferGeometry, Skeleton, SkinnedMesh } from "three";
import { BVHLoader } from "three/examples/jsm/loaders/BVHLoader.js";
import { retargetClip } from "three/examples/jsm/utils/SkeletonUtils.js";

const [motion, character, names] = process.argv.slice(2);
const { skeleton, clip } = new BVHLoader().parse(readFileSync(motion, "utf8"));
const { nodes } = JSON.parse(readFileSync(character, "utf8"));
const bones = nodes.map(({ name, translation, rotation, scale }) => {
    const bone = new Bone();
    bone.name = name;
    if (translation) bone.position.fromArray(translation);
    if (rotation) bone.quaternion.fromArray(rotation);
    if (scale) bone.scale.fromArray(scale);
    return bone;
});
nodes.forEach(({ children = [] }, index) => children.forEach((child) => bones[index].add(bones[child])));
const target = new SkinnedMesh(new BufferGeometry());
bones.filter((bone) => !bone.parent).forEach((bone) => target.add(bone));
target.updateMatrixWorld(true);
target.bind(new Skeleton(bones));
const source = new SkinnedMesh(new BufferGeometry());
source.add(skeleton.bones[0]);
source.bind(skeleton);

const options = { names: JSON.parse(names), hip: skeleton.bones[0].name };
let [best, poses] = [Infinity, 0];
for (let run = 0; run < 5; run += 1) {
    const start = process.cpuUsage();
    const moved = retargetClip(target, source, clip, { ...options });
    best = Math.min(best, process.cpuUsage(start).user);
    poses = Math.max(...moved.tracks.map((track) => track.times.length));
}
console.log(JSON.stringify({ poses_per_second: poses / (best / 1e6) }));
