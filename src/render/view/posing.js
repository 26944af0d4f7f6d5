// A manual pose: turned joints and dragged ends of limbs and chains, until the time changes.

import { compose, rotationOf } from "./math.js";
import { bendChain, chainsOf } from "./fabrik.js";
import { limbsOf, reach } from "./reach.js";

export class Posing {
  constructor(clip) {
    this.clip = clip;
    // Hands and feet of a humanoid are ends of limbs. Other ends are ends of chains.
    this.limbs = limbsOf(clip.nodes);
    this.chains = new Map([...chainsOf(clip.nodes, clip.children), ...this.limbs]);
    // The set angles of each joint in degrees, and the goal of each chain's last node in the file's coordinates.
    this.angles = new Map();
    this.goals = new Map();
  }

  get isPosed() { return this.angles.size + this.goals.size > 0; }

  // Resets the pose to the motion.
  reset() {
    this.angles.clear();
    this.goals.clear();
  }

  // Sets the Euler angles of a joint. Dragged limbs keep their pose, but no longer follow their goals.
  turn(id, angles) {
    for (const end of this.goals.keys()) {
      for (const joint of this.chains.get(end)) this.angles.set(joint, this.clip.angles(joint));
    }
    this.goals.clear();
    this.angles.set(id, angles);
  }

  drag(end, goal) { this.goals.set(end, goal); }

  // The matrix of a manually turned joint relative to its parent, or null.
  local(id, tick) {
    const { clip } = this;
    const angles = this.angles.get(id);
    return angles ? compose(clip.translation(id, tick), rotationOf(angles, clip.nodes[id].order), clip.scaling(id, tick)) : null;
  }

  // Applies the goals after forward kinematics.
  applyGoals() {
    for (const [end, goal] of this.goals) (this.limbs.has(end) ? reach : bendChain)(this.clip, this.chains.get(end), goal);
  }
}
