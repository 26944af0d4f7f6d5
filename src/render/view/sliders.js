// Sliders of the Euler angles of the selected joint, over 360 degrees each.

import { byId, make, short } from "./dom.js";

const AXIS_NAMES = ["X", "Y", "Z"];
const HALF_TURN = 180;
// The step of a slider, in degrees.
const STEP = 0.5;

// The equivalent angle between minus and plus half a turn.
const withinTurn = (angle) => angle - 2 * HALF_TURN * Math.round(angle / (2 * HALF_TURN));

export class JointSliders {
  // `posed` is called when a joint is turned or reset.
  constructor(state, posed) {
    Object.assign(this, { state, posed });
    byId("pose-reset").addEventListener("click", () => this.reset());
  }

  get clip() { return this.state.clips[this.state.active]; }

  // Called when the selected joint changes.
  show() {
    const { clip, state } = this;
    const node = clip.nodes[state.joint];
    const isTurned = Boolean(node) && node.kind !== "end_site";
    byId("sliders").hidden = !isTurned;
    this.inputs = null;
    if (!isTurned) return;
    const axes = node.order.map((axis) => AXIS_NAMES[axis]);
    this.inputs = axes.map((axis, i) => make("input", {
      type: "range", min: -HALF_TURN, max: HALF_TURN, step: STEP, "aria-label": `${axis} rotation in degrees`, oninput: () => this.turn(i),
    }));
    this.outputs = axes.map(() => make("output", {}));
    byId("slider-list").replaceChildren(...axes.map((axis, i) => make("label", {}, make("span", {}, axis), this.inputs[i], this.outputs[i])));
    byId("euler-order").textContent = `${node.turns ? "Order of the file" : "Order"}: R = ${axes.map((axis) => `R${axis.toLowerCase()}`).join(" ")} on column vectors. A positive angle turns counter-clockwise for a viewer towards whom the axis points.`;
    this.showTick();
  }

  turn(axis) {
    const { joint } = this.state;
    this.clip.posing.turn(joint, this.clip.angles(joint).map((angle, i) => (i === axis ? Number(this.inputs[i].value) : angle)));
    byId("said").textContent = `${this.clip.nodes[this.state.joint].name} is turned; Z puts it back`;
    this.posed();
  }

  // Resets the joint to the motion.
  reset() {
    const posed = this.state.clips.filter(({ posing }) => posing.isPosed);
    for (const { posing } of posed) posing.reset();
    if (posed.length) this.posed();
  }

  showTick() {
    byId("pose-reset").disabled = !this.state.clips.some(({ posing }) => posing.isPosed);
    if (!this.inputs) return;
    this.clip.angles(this.state.joint).forEach((angle, i) => {
      this.inputs[i].value = withinTurn(angle);
      this.outputs[i].textContent = `${short(angle)}°`;
    });
  }
}
