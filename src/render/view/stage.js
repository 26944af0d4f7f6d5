// The stage: draws the clips and places the camera.

import { add, boxAround, clamp, length, normalize, project, scale, sub } from "./math.js";
import { byId, make, short } from "./dom.js";
import { Batch } from "./batch.js";
import { GlRenderer } from "./renderer_gl.js";
import { FlatRenderer } from "./renderer_2d.js";
import { OrbitCamera } from "./camera.js";
import { AT_REST, AXIS_COLORS, CHOSEN, NO_BONE, THEMES, boneColor, errorColor, mix, sideColor } from "./colors.js";
import { isAtRest, limbError } from "./marks.js";
import { chainMatrices } from "./product.js";
import { playMorphs, verticesOnPage } from "./skin.js";

// Bones with a label in the picture: all except fingers, face and collar bones.
const HAS_LABEL = /^(hips|spine|chest|upperChest|neck|head|(left|right)(UpperArm|LowerArm|Hand|UpperLeg|LowerLeg|Foot|Toes))$/;

// Extents of a figure from its centre, relative to its height: half the height, and a larger half width for narrow
// pictures.
const [HALF_HEIGHT, HALF_WIDTH] = [0.5, 0.62];

export class Stage {
  constructor(canvas, state, changed) {
    Object.assign(this, { canvas, state, changed });
    this.camera = new OrbitCamera();
    this.view = { bones: new Batch(), rods: new Batch(), balls: new Batch(), skins: [], reach: 1, ground: 0, gridStep: 1, sun: normalize([0.35, 1, 0.45]) };
    this.renderer = this.makeRenderer();
    this.labels = [];
  }

  makeRenderer() {
    // An address that ends in #canvas2d disables WebGL, for tests.
    if (location.hash !== "#canvas2d") {
      try {
        return new GlRenderer(this.canvas, this.changed);
      } catch { /* There is no WebGL 2 here; the other renderer needs none. */ }
    }
    return new FlatRenderer(this.canvas);
  }

  get clip() { return this.state.clips[this.state.active]; }

  // Whether the skin of a clip is drawn, and whether its skeleton is drawn.
  showsSkin(clip) { return Boolean(clip.skin && this.state.skin && this.renderer.skins); }
  showsSkeleton(clip) { return this.state.skeleton || !this.showsSkin(clip) || (this.state.errors && Boolean(clip.limbs)); }

  draw() {
    const { state, view, camera, canvas } = this;
    for (const clip of state.clips) clip.pose(clip.tickAt(state.time));
    playMorphs(state.clips.filter((clip) => this.showsSkin(clip)));
    this.fitCanvas();
    this.follow();
    this.fillBatches();
    view.camera = camera.see(canvas.width / Math.max(1, canvas.height));
    view.theme = THEMES[state.theme];
    view.target = camera.target;
    view.groundExtent = Math.max(view.reach * 14, camera.distance * 3);
    view.shadowReach = Math.max(3 * view.reach, 0.8 * camera.distance);
    this.renderer.draw(view);
    this.placeTip();
    this.placeLabels();
  }

  fitCanvas() {
    const { canvas } = this;
    const ratio = Math.min(2, devicePixelRatio || 1);
    // A film sets its own size.
    const size = this.size ?? [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  }

  // Moves the camera with the active clip, at a constant distance.
  follow() {
    const anchor = this.clip.smoothAnchor(this.clip.tick);
    if (this.state.follow && this.before) {
      const step = sub(anchor, this.before);
      this.camera.target = add(this.camera.target, [step[0], 0, step[2]]);
    }
    this.before = anchor;
  }

  // Places the figures side by side at a time, or overlaid at their positions in the files. The distance of neighbours
  // is `apart` times their mean reach.
  arrange({ seconds = 0, apart = 1.5 } = {}) {
    const { clips, arrangement } = this.state;
    let [at, places] = [0, []];
    clips.forEach(({ size }, i) => {
      at += i ? 0.5 * apart * (clips[i - 1].size.reach + size.reach) : 0;
      places.push(at);
    });
    const low = Math.min(...clips.map((clip) => clip.size.floor));
    for (const clip of clips) {
      clip.shift = [0, 0, 0];
      if (clips.length < 2 || arrangement !== "side") continue;
      clip.pose(clip.tickAt(seconds));
      const start = clip.middle();
      clip.shift = [places[clip.index] - at / 2 - start[0], low - clip.size.floor, -start[2]];
    }
    this.frameAll();
  }

  // Fits all current figures in the picture.
  frameAll() {
    const { camera, view } = this;
    const { clips } = this.state;
    for (const clip of clips) clip.pose(clip.tickAt(this.state.time));
    const boxes = clips.map((clip) => this.boxOf(clip));
    const middles = boxes.map(([low, high]) => scale(add(low, high), 0.5));
    const middle = scale(middles.reduce(add), 1 / clips.length);
    view.reach = Math.max(...clips.map((clip) => clip.size.reach));
    const reach = Math.max(view.reach, ...boxes.map(([low, high]) => HALF_HEIGHT * (high[1] - low[1])), ...boxes.map(([low, high]) => HALF_WIDTH * (high[0] - low[0])));
    view.ground = Math.min(...clips.map((clip) => clip.size.floor + clip.shift[1]));
    const spread = Math.max(...middles.map((place) => length(sub(place, middle))));
    camera.target = middle;
    camera.home.distance = 3.7 * reach + 2.2 * spread;
    camera.reset();
    this.before = this.clip.smoothAnchor(this.clip.tick);
    view.gridStep = 10 ** Math.round(Math.log10(view.reach)) / 5;
    const unit = clips.length === 1 ? `, 1 unit = ${short(this.clip.metresPerUnit)} m` : "";
    byId("grid-scale").textContent = `bold lines ${short(5 * view.gridStep)} m apart${unit}`;
    this.changed();
  }

  // The bounding box of a drawn figure, including its skin.
  boxOf(clip) {
    const joints = clip.drawn.filter((_, id) => clip.nodes[id].inBody);
    return boxAround(this.showsSkin(clip) ? [...joints, ...verticesOnPage(clip.skin, clip)] : joints);
  }

  fillBatches() {
    const { state, view } = this;
    for (const batch of [view.bones, view.rods, view.balls]) batch.clear();
    view.skins = state.clips.filter((clip) => this.showsSkin(clip));
    view.clips = state.clips;
    view.bonesShade = view.skins.length < state.clips.length;
    for (const clip of state.clips) {
      const { reach } = clip.size;
      const isDrawn = this.showsSkeleton(clip);
      clip.nodes.forEach((node, id) => {
        const isChosen = clip.index === state.active && id === state.joint;
        const isHovered = clip.index === state.hovered[0] && id === state.hovered[1];
        const [linkTint, jointTint] = this.tints(clip, node);
        if (isDrawn && node.isLinked) {
          const [from, to] = [clip.drawn[node.parent], clip.drawn[id]];
          view.bones.add(from, to, Math.min(0.1 * length(sub(to, from)), 0.036 * reach), isChosen ? mix(linkTint, CHOSEN, 0.8) : linkTint);
        }
        const large = isChosen || isHovered;
        const radius = (large ? 0.03 : node.kind === "end_site" ? 0.008 : 0.014) * reach;
        if (node.isShown && (isDrawn || large)) view.balls.add(clip.drawn[id], clip.drawn[id], radius, large ? CHOSEN : mix(jointTint, [0, 0, 0], 0.3));
      });
      if (state.contacts) this.addContacts(clip);
    }
    for (const trail of state.trails) this.addTrail(...trail.split(":").map(Number));
    if (state.joint >= 0) this.addFrames();
  }

  // Marks the points of feet at rest.
  addContacts(clip) {
    for (const contact of clip.contacts) {
      const place = clip.drawn[contact.node];
      if (isAtRest(contact, Math.round(clip.tick))) this.view.balls.add(place, place, 0.026 * clip.size.reach, AT_REST);
    }
  }

  // The colours of the link that ends at a node, and of the node. A link has the colour of the bone at its start.
  tints(clip, node) {
    if (this.state.errors && clip.limbs) {
      const error = limbError(clip, node.parent);
      const tint = error === null ? NO_BONE : errorColor(error);
      return [tint, tint];
    }
    if (!this.state.bones || !clip.humanoid) {
      const tint = sideColor(clip, node.side, this.state.clips.length > 1);
      return [tint, tint];
    }
    let above = node.parent;
    while (above >= 0 && !clip.nodes[above].bone) above = clip.nodes[above].parent;
    return [above < 0 ? NO_BONE : boneColor(clip.nodes[above].bone), node.bone ? boneColor(node.bone) : NO_BONE];
  }

  // Draws the path of a joint over the last seconds, fading out.
  addTrail(index, id) {
    const clip = this.state.clips[index];
    const [samples, seconds] = [90, 3];
    const { background } = THEMES[this.state.theme];
    let before = null;
    for (let i = 0; i <= samples; i++) {
      const tick = clip.tick - (1 - i / samples) * seconds * clip.ticksPerSecond;
      if (tick < 0) continue;
      const place = clip.pagePositionAt(id, tick);
      if (before) this.view.rods.add(before, place, 0.005 * clip.size.reach, mix(background, CHOSEN, 0.15 + (0.85 * i) / samples));
      before = place;
    }
  }

  // Draws the axes of the selected joint, or the frames after J0, J0 L1, J0 L1 J1, ... up to the multiplied matrices,
  // with links between them.
  addFrames() {
    const { clip, state, view } = this;
    if (!state.grown) return this.addAxes(clip.world[state.joint], 1);
    const parts = chainMatrices(clip, state.joint).slice(0, state.grown);
    parts.forEach(({ letter, product }, i) => {
      const isLast = i === parts.length - 1;
      const [from, to] = [parts[i - 1]?.product ?? product, product].map((matrix) => clip.toPage(matrix.slice(12, 15)));
      if (letter === "L") view.rods.add(from, to, 0.012 * clip.size.reach, CHOSEN);
      this.addAxes(product, isLast ? 1.5 : 0.8);
    });
  }

  // Draws the axes of a coordinate frame: x red, y green, z blue.
  addAxes(m, scaling) {
    const { clip } = this;
    const origin = m.slice(12, 15);
    const size = (scaling * 0.16 * clip.size.reach) / clip.metresPerUnit;
    AXIS_COLORS.forEach((tint, axis) => {
      const end = add(origin, scale(normalize(m.slice(4 * axis, 4 * axis + 3)), size));
      this.view.rods.add(clip.toPage(origin), clip.toPage(end), 0.006 * scaling * clip.size.reach, tint);
    });
  }

  // The position of a point on the canvas, in pixels, and its distance from the camera.
  onCanvas(point) {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const [x, y, depth] = project(this.camera.see(width / Math.max(1, height)).worldToClip, point);
    return [(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height, depth];
  }

  // The point below a pointer, at the same distance from the camera as `place`.
  beside(place, event) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y, depth] = this.onCanvas(place);
    const { focal } = this.camera.see(box.width / Math.max(1, box.height));
    const size = (2 * depth) / focal / box.height;
    const axes = this.camera.axes();
    const [right, up] = [event.clientX - box.left - x, y - (event.clientY - box.top)];
    return add(place, add(scale(axes.x, right * size), scale(axes.y, up * size)));
  }

  // The joint below a pointer: the nearest joint within reach of a mouse or a finger.
  jointAt(event) {
    const box = this.canvas.getBoundingClientRect();
    let nearest = { distance: event.pointerType === "touch" ? 28 : 14, clip: -1, joint: -1 };
    for (const clip of this.state.clips) {
      clip.nodes.forEach((node, joint) => {
        const [x, y, depth] = this.onCanvas(clip.drawn[joint]);
        const distance = Math.hypot(x - (event.clientX - box.left), y - (event.clientY - box.top));
        if (depth > 0 && node.isShown && distance < nearest.distance) nearest = { distance, clip: clip.index, joint };
      });
    }
    return nearest;
  }

  placeTip() {
    const [index, joint] = this.state.hovered;
    const tip = byId("tip");
    const clip = this.state.clips[index];
    tip.hidden = !clip;
    if (!clip) return;
    const { name, bone } = clip.nodes[joint];
    const [x, y] = this.onCanvas(clip.drawn[joint]);
    const [local, world] = [clip.translation(joint, clip.tick), clip.filePosition(joint)].map((place) => Array.from(place, short).join("  "));
    const lines = [`${this.state.clips.length > 1 ? `${clip.name}: ` : ""}${name}`];
    if (bone) lines.push(`${bone.name}, ${bone.confidence}: ${bone.reason}`);
    else if (clip.humanoid) lines.push("not a humanoid bone");
    const error = this.state.errors ? limbError(clip, joint) : null;
    if (error !== null) lines.push(`limb error ${short(error)}°`);
    tip.textContent = [...lines, `local  ${local}`, `world  ${world}`].join("\n");
    // Place the tool tip beside the joint, within the picture.
    const left = clamp(x + 14, 4, Math.max(4, this.canvas.clientWidth - tip.offsetWidth - 4));
    const top = clamp(y - 12, 4, Math.max(4, this.canvas.clientHeight - tip.offsetHeight - 4));
    tip.style.transform = `translate(${left}px, ${top}px)`;
  }

  // Places the names of the active clip's bones beside their joints, on the side away from the centre of the figure.
  placeLabels() {
    const { clip, state } = this;
    const wanted = state.bones && this.showsSkeleton(clip) ? clip.nodes.flatMap(({ bone }, id) => (bone && HAS_LABEL.test(bone.name) ? [[id, bone.name]] : [])) : [];
    while (this.labels.length < wanted.length) {
      this.labels.push(make("span"));
      byId("labels").append(this.labels.at(-1));
    }
    const [middle] = this.onCanvas(clip.middle());
    const placed = [];
    this.labels.forEach((label, i) => {
      const [id, name] = wanted[i] ?? [];
      const [x, y, depth] = id === undefined ? [0, 0, 0] : this.onCanvas(clip.drawn[id]);
      if (label.textContent !== (name ?? "")) label.textContent = name ?? "";
      // The approximate width of the label. A label that would cover another label is not shown.
      const width = 6.5 * label.textContent.length;
      const left = x < middle - 1 ? x - 9 - width : x + 9;
      const covers = placed.some((other) => Math.abs(other.y - y) < 12 && left < other.left + other.width && other.left < left + width);
      label.hidden = !(depth > 0) || covers;
      if (label.hidden) return;
      placed.push({ left, y, width });
      label.style.transform = `translate(${x}px, ${y}px) translate(${x < middle - 1 ? "calc(-100% - 9px)" : "9px"}, -50%)`;
    });
  }
}
