// Shows a robot's motion: each joint over time between its limits, and the quality report.

import { Chart } from "../../../src/render/view/chart.js";
import { byId, make } from "../../../src/render/view/dom.js";
import { limbAngles } from "../../../src/render/view/marks.js";

const PERCENT = 100;
/** The criterion of the verdict for single limbs. */
const LIMB_CRITERION = "worst_limb_degrees";
const percent = (fraction) => `${(PERCENT * fraction).toFixed(fraction < 0.01 ? 2 : 1)} %`;
/** The largest number of named joints at a limit. */
const NAMED = 4;
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

/** The lines of a report. */
function linesOf({ verdict, mean_degrees, limbs, clamped, fraction_below_floor, fraction_in_self_collision, fraction_of_jumps, skate }) {
  const atLimit = [...clamped].sort((a, b) => b.fraction - a.fraction).slice(0, NAMED).map(({ joint, fraction }) => `${joint} ${percent(fraction)}`);
  const worst = [...limbs].sort((a, b) => (b.max_degrees ?? 0) - (a.max_degrees ?? 0))[0];
  return [
    `verdict: ${verdict}`,
    `mean limb error ${mean_degrees.toFixed(1)}°${worst?.max_degrees === undefined ? "" : `, at most ${worst.max_degrees.toFixed(1)}° (${worst.bone})`}`,
    `at a limit: ${atLimit.join(", ") || "no joint"}`,
    `soles below the floor in ${percent(fraction_below_floor)} of the frames, links within one another in ${percent(fraction_in_self_collision)}, jumps ${percent(fraction_of_jumps)}`,
    ...(skate === undefined || skate === null ? [] : [`standing soles slide ${(100 * skate).toFixed(2)} cm/s`]),
  ];
}

export class RobotView {
  // `player` shows the motion.
  constructor(player) {
    this.player = player;
    this.chart = new Chart(byId("robot-curve"), (share) => this.robot && player.seekTime((share * (this.robot.frames - 1)) / this.robot.fps));
    byId("robot-joint").addEventListener("change", () => this.showJoint());
    byId("robot").addEventListener("toggle", () => this.showJoint());
    new ResizeObserver(() => this.showJoint()).observe(byId("robot-curve"));
  }

  show({ answer, clip }) {
    this.robot = answer?.robot ?? null;
    byId("robot").hidden = !this.robot;
    if (!this.robot) return;
    this.limbs = clip?.data.limbs ?? null;
    this.bounds = answer.retargeted.criteria.find(({ name }) => name === LIMB_CRITERION);
    const select = byId("robot-joint");
    const before = select.value;
    const joints = this.robot.joints.map(({ name }, index) => make("option", { value: index }, name));
    const limbs = (this.limbs?.bones ?? []).map((bone, index) => make("option", { value: `limb ${index}` }, bone));
    select.replaceChildren(make("optgroup", { label: "Joints" }, ...joints), ...(limbs.length ? [make("optgroup", { label: "Limbs against the motion" }, ...limbs)] : []));
    if ([...joints, ...limbs].some(({ value }) => value === before)) select.value = before;
    byId("robot-report").replaceChildren(...linesOf(answer.retargeted).map((line) => make("li", {}, line)));
    this.showJoint();
  }

  // Draws a joint over time, in degrees for rotating joints, with its limits as lines.
  showJoint() {
    if (!this.robot || !byId("robot").open) return;
    const { frames, joints, positions } = this.robot;
    const limb = /^limb (\d+)$/.exec(byId("robot-joint").value);
    if (limb) return this.showLimb(Number(limb[1]));
    const index = Number(byId("robot-joint").value);
    const { lower, upper, velocity } = joints[index];
    const degrees = 180 / Math.PI;
    const row = Float64Array.from({ length: frames }, (_, frame) => degrees * positions[frame * joints.length + index]);
    const line = (limit) => new Float64Array(frames).fill(degrees * limit);
    const limits = [lower, upper].filter((limit) => limit !== null);
    this.chart.show([row, ...limits.map(line)], { filled: frames, colors: [style("--accent"), style("--warn"), style("--warn")], unit: "°" });
    this.fastest(row, velocity);
    this.point();
  }

  // Draws the angle between a limb and the motion's limb, with the verdict's thresholds of the mean as lines.
  showLimb(limb) {
    const angles = limbAngles({ limbs: this.limbs }, limb);
    const bounds = this.bounds ? [this.bounds.good, this.bounds.fair].filter(Number.isFinite) : [];
    const line = (bound) => new Float64Array(angles.length).fill(bound);
    this.chart.show([angles, ...bounds.map(line)], { filled: angles.length, colors: [style("--accent"), style("--warn"), style("--warn")], unit: "°" });
    const mean = angles.reduce((sum, angle) => sum + angle, 0) / angles.length;
    byId("robot-speed").textContent = `mean ${mean.toFixed(1)}°, at most ${angles.reduce((a, b) => Math.max(a, b), 0).toFixed(1)}°${bounds.length === 2 ? `; a mean up to ${bounds[0]}° is good, up to ${bounds[1]}° fair` : ""}`;
    this.point();
  }

  // Shows the largest speed and the velocity limit of the robot's file.
  fastest(row, velocity) {
    let most = 0;
    for (let frame = 1; frame < row.length; frame++) most = Math.max(most, Math.abs(row[frame] - row[frame - 1]));
    const allowed = velocity ? `, ${Math.round((180 / Math.PI) * velocity)}°/s allowed` : "";
    byId("robot-speed").textContent = `at most ${Math.round(most * this.robot.fps)}°/s${allowed}`;
  }

  point() {
    if (!this.robot || !byId("robot").open) return;
    const { time } = this.player.state;
    this.chart.point(Math.min(1, (time * this.robot.fps) / Math.max(1, this.robot.frames - 1)));
  }
}
