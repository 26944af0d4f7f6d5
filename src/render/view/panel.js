// The side panel: the files, the tree of joints, and the values of the selected joint.

import { clamp, scale } from "./math.js";
import { byId, css, lengthUnit, make, short } from "./dom.js";
import { BONE_SIDES } from "./colors.js";
import { ChainPanel } from "./chain_panel.js";
import { Chart } from "./chart.js";
import { limbAngles, limbError, limbOf } from "./marks.js";
import { JointSliders } from "./sliders.js";

const AXES = ["X", "Y", "Z"];
const CURVE_COLORS = { X: "--x", Y: "--y", Z: "--z", W: "--w" };
const color = (letter) => getComputedStyle(document.documentElement).getPropertyValue(CURVE_COLORS[letter]);

// The largest error of joint positions that packing caused, as text.
function precision({ packingError }) {
  return packingError ? `; keys packed, joints within ${short(1000 * packingError)} mm of the file` : "";
}

// The humanoid bone of a joint, after the joint's name.
function boneTag({ name, side, confidence, reason }) {
  const tag = make("small", { class: "bone", title: `${confidence}: ${reason}` }, confidence === "sure" ? name : `${name} (${confidence})`);
  tag.style.setProperty("--bone", css(BONE_SIDES[side]));
  return tag;
}

export class Panel {
  constructor(state, { choose, activate, hover, seek, changed, posed }) {
    Object.assign(this, { state, choose, activate, hover });
    this.chain = new ChainPanel(state, { choose, changed });
    this.sliders = new JointSliders(state, posed);
    this.charts = ["position", "euler", "quaternion"].map((name) => new Chart(byId(`${name}-curves`), seek));
    this.limbChart = new Chart(byId("limb-curves"), seek);
    byId("search").addEventListener("input", () => this.filter());
    byId("search").addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.visible()[0]?.click();
      if (event.key === "ArrowDown") { this.visible()[0]?.focus(); event.preventDefault(); }
    });
    byId("position-space").addEventListener("change", () => this.showCurves());
    byId("tree").addEventListener("keydown", (event) => this.moveInTree(event));
    new ResizeObserver(() => this.redraw()).observe(byId("position-curves"));
  }

  // A page with a selection of bones sets `boneChoice(clip, node)`, which returns the elements to show after a joint's
  // bone.

  // Called when the clips or the active clip change.
  showClips() {
    this.showFiles();
    this.showTree();
    this.showJoint();
  }

  get clip() { return this.state.clips[this.state.active]; }

  showFiles() {
    const { clips } = this.state;
    byId("files").replaceChildren(...clips.map((clip) => {
      const swatch = make("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.background = clips.length > 1 ? css(clip.color) : "transparent";
      const row = make("div", { class: "file" },
        make("button", { class: "file-name", "aria-pressed": clip.index === this.state.active, onclick: () => this.activate(clip.index) },
          ...(clips.length > 1 ? [swatch] : []), clip.name),
        make("p", { class: "facts" }, clip.facts + precision(clip)));
      const notes = [...clip.assumptions.map((note) => ["assumed", note]), ...clip.warnings.map((note) => ["warning", note])];
      if (notes.length) {
        const count = clip.warnings.length;
        const summary = count ? `${count} warning${count > 1 ? "s" : ""}` : "assumptions";
        row.append(make("details", {}, make("summary", count ? { class: "warned" } : {}, summary),
          make("ul", {}, ...notes.map(([kind, note]) => make("li", {}, make("b", {}, `${kind}: `), note)))));
      }
      return row;
    }));
  }

  showTree() {
    const { clip } = this;
    const depths = [];
    this.items = clip.nodes.map((node, id) => {
      depths[id] = node.parent < 0 ? 0 : depths[node.parent] + 1;
      const item = make("div", {
        role: "treeitem", "aria-level": depths[id] + 1, "aria-selected": "false", tabindex: id === 0 ? 0 : -1,
        class: node.kind, title: node.name, onclick: () => this.choose(this.state.active, id),
        onpointerenter: () => this.hover(this.state.active, id), onpointerleave: () => this.hover(-1, -1),
      }, node.name, ...(node.bone ? [boneTag(node.bone)] : []));
      item.style.paddingLeft = `${8 + 12 * Math.min(depths[id], 14)}px`;
      return item;
    });
    byId("tree").replaceChildren(...this.items);
    this.filter();
  }

  visible() { return this.items.filter((item) => !item.hidden); }

  filter() {
    const words = byId("search").value.toLowerCase().trim();
    this.items.forEach((item, id) => {
      const { name, bone } = this.clip.nodes[id];
      item.hidden = ![name, bone?.name ?? ""].some((text) => text.toLowerCase().includes(words));
    });
    byId("no-match").hidden = this.visible().length > 0;
  }

  moveInTree(event) {
    const items = this.visible();
    const at = items.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1 }[event.key];
    if (to === undefined && event.key !== "Enter") return;
    event.preventDefault();
    event.stopPropagation();
    if (to === undefined) document.activeElement.click();
    else items[clamp(to, 0, items.length - 1)]?.focus();
  }

  // Called when the selected joint changes.
  showJoint() {
    const { joint } = this.state;
    this.items.forEach((item, id) => {
      item.setAttribute("aria-selected", id === joint);
      item.tabIndex = id === Math.max(0, joint) ? 0 : -1;
    });
    byId("panel").classList.toggle("has-joint", joint >= 0);
    byId("joint").hidden = joint < 0;
    byId("nothing-chosen").hidden = joint >= 0;
    this.curves = null;
    this.sliders.show();
    if (joint < 0) return;
    const item = this.items[joint];
    const { offsetTop, offsetHeight, parentElement: tree } = item;
    if (offsetTop < tree.scrollTop || offsetTop + offsetHeight > tree.scrollTop + tree.clientHeight) tree.scrollTop = offsetTop - tree.clientHeight / 2;
    const node = this.clip.nodes[joint];
    byId("joint-name").textContent = node.name;
    byId("bone").replaceChildren(...(node.bone ? [make("b", {}, node.bone.name), ` ${node.bone.confidence}: ${node.bone.reason}`] : []));
    if (this.boneChoice) byId("bone").append(...this.boneChoice(this.clip, node));
    byId("position-space").value = node.moves ? "local" : "world";
    byId("euler-title").textContent = node.turns ? "Euler angles, in the file’s order [°]" : "Euler angles [°]";
    this.chain.show();
    this.showLimb();
    this.showCurves();
  }

  // Shows the angle between the joint's limb and the same limb of the source, if the limb is compared.
  showLimb() {
    const { clip, state } = this;
    const limb = clip.limbs ? limbOf(clip, state.joint) : -1;
    byId("limb").hidden = limb < 0;
    this.limb = limb < 0 ? null : limbAngles(clip, limb);
    if (!this.limb) return;
    const sum = this.limb.reduce((sum, angle) => sum + angle, 0);
    byId("limb-title").textContent = `${clip.limbs.bones[limb]} against the source [°]`;
    const value = make("output", {});
    byId("limb-legend").replaceChildren(make("span", {}, "now ", value), make("span", {}, `mean ${short(sum / this.limb.length)}`), make("span", {}, `at most ${short(this.limb.reduce((a, b) => Math.max(a, b), 0))}`));
    for (const entry of byId("limb-legend").children) entry.style.setProperty("--curve", "var(--accent)");
    this.limbNow = value;
  }

  showCurves() {
    const { clip, state } = this;
    this.curves = clip.curves(state.joint);
    this.drawnFrames = 0;
    const node = clip.nodes[state.joint];
    const order = node.order.map((axis) => AXES[axis]);
    const letters = [AXES, order, [...AXES, "W"]];
    this.legends = ["position", "euler", "quaternion"].map((name, chart) => {
      const values = letters[chart].map(() => make("output", {}));
      byId(`${name}-legend`).replaceChildren(...letters[chart].map((letter, i) => {
        const entry = make("span", {}, chart === 1 ? `${letter}rotation ` : `${letter} `, values[i]);
        entry.style.setProperty("--curve", `var(${CURVE_COLORS[letter]})`);
        return entry;
      }));
      return values;
    });
    this.letters = letters;
    this.fillCurves(this.curves);
  }

  // Shows the curves of the visible part of the time line, in seconds.
  showPart(range) {
    this.range = range;
    if (this.curves) this.redraw();
  }

  // The first and the last visible frame.
  get part() {
    const { duration, ticksPerSecond } = this.clip;
    const [from, to] = this.range.map((seconds) => clamp(seconds * ticksPerSecond, 0, duration));
    return [Math.floor(from + 1e-6), Math.ceil(to - 1e-6)];
  }

  redraw() {
    if (this.state.joint < 0 || !this.curves) return;
    const { rows, filled } = this.curves;
    const shown = [rows[byId("position-space").value], rows.euler, rows.quaternion];
    const units = [lengthUnit(this.clip.metresPerUnit), "°", ""];
    const [from, to] = this.part;
    this.charts.forEach((chart, i) => chart.show(shown[i], { filled, colors: this.letters[i].map(color), unit: units[i], from, to }));
    if (this.limb) this.limbChart.show([this.limb], { filled: this.limb.length, colors: [getComputedStyle(document.documentElement).getPropertyValue("--accent")], unit: "°", from, to: Math.min(to, this.limb.length - 1) });
    this.drawnFrames = filled;
    this.showTick();
  }

  // Samples the curves in pieces, so that the page stays responsive. Draws them each time their length has doubled, and
  // at the end.
  fillCurves(curves) {
    if (this.curves !== curves) return;
    curves.fill(16);
    if (curves.complete || curves.filled > 2 * this.drawnFrames) this.redraw();
    if (!curves.complete) setTimeout(() => this.fillCurves(curves), 4);
  }

  // Updates the values to the current tick.
  showTick() {
    const { clip, state } = this;
    if (state.joint < 0) return;
    const id = state.joint;
    const [from, to] = this.part;
    const share = to > from ? (clip.tick - from) / (to - from) : 0;
    this.charts.forEach((chart) => chart.point(share));
    if (this.limb) {
      this.limbChart.point(share);
      this.limbNow.textContent = short(limbError(clip, id));
    }
    const local = Array.from(clip.translation(id, clip.tick));
    const world = clip.filePosition(id);
    const metres = scale(world, clip.metresPerUnit);
    byId("local-position").textContent = local.map(short).join("  ");
    byId("world-position").textContent = world.map(short).join("  ");
    byId("metre-position").textContent = metres.map((value) => value.toFixed(3).replace("-", "−")).join("  ");
    const position = byId("position-space").value === "world" ? world : local;
    const values = [position, clip.angles(id), clip.rotationNow(id)];
    values.forEach((row, chart) => row.forEach((value, i) => { this.legends[chart][i].textContent = short(value); }));
    this.chain.showTick();
    this.sliders.showTick();
  }
}
