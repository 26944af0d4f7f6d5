// A pose by hand: joints that are turned, and ends of limbs and chains that are dragged, until the time changes.

import { compose, rotationOf } from "./math.js";
import { bendChain, chainsOf } from "./fabrik.js";
import { limbsOf, reach } from "./reach.js";

export class Posing {
  constructor(clip) {
    this.clip = clip;
    // Hands and feet of a humanoid bend as its limbs do, other ends as chains.
    this.limbs = limbsOf(clip.nodes);
    this.chains = new Map([...chainsOf(clip.nodes, clip.children), ...this.limbs]);
    // Angles in degrees by the joint, and in the file's coordinates where an end is to be by the chain's last node.
    this.angles = new Map();
    this.goals = new Map();
  }

  get isPosed() { return this.angles.size + this.goals.size > 0; }

  // Back to the motion.
  reset() {
    this.angles.clear();
    this.goals.clear();
  }

  // Turns a joint to angles about the axes of its order. What was dragged stays as it is and no longer follows its goal.
  turn(id, angles) {
    for (const end of this.goals.keys()) {
      for (const joint of this.chains.get(end)) this.angles.set(joint, this.clip.angles(joint));
    }
    this.goals.clear();
    this.angles.set(id, angles);
  }

  drag(end, goal) { this.goals.set(end, goal); }

  // The matrix to the parent of a joint that is turned by hand, or null.
  local(id, tick) {
    const { clip } = this;
    const angles = this.angles.get(id);
    return angles ? compose(clip.translation(id, tick), rotationOf(angles, clip.nodes[id].order), clip.scaling(id, tick)) : null;
  }

  // Once the joints are where they are.
  applyGoals() {
    for (const [end, goal] of this.goals) (this.limbs.has(end) ? reach : bendChain)(this.clip, this.chains.get(end), goal);
  }
}
