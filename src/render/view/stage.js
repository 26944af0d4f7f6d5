// What the page shows: its state, its clock, and what is drawn of it.

const PALETTE = [[0.18, 0.42, 0.85], [0.88, 0.42, 0.14], [0.2, 0.62, 0.35], [0.62, 0.36, 0.78], [0.82, 0.27, 0.37], [0.25, 0.6, 0.66]];
const SIDES = { left: PALETTE[0], right: PALETTE[1], middle: [0.56, 0.61, 0.7] };
const CHOSEN = [1, 0.78, 0.16];
const AXIS_COLORS = [[0.85, 0.2, 0.24], [0.2, 0.62, 0.27], [0.2, 0.42, 0.9]];
const THEMES = {
  light: { background: [0.965, 0.972, 0.984], grid: [0.72, 0.76, 0.82], shadow: 0.5 },
  dark: { background: [0.085, 0.098, 0.13], grid: [0.25, 0.29, 0.36], shadow: 0.75 },
};
const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2, 4];

const page = JSON.parse(byId("page-data").textContent);
const clips = page.clips.map((description, index) => new Clip(description, index));
clips.forEach((clip) => { clip.color = PALETTE[clip.index % PALETTE.length]; });

const state = {
  clips, active: 0, joint: -1, hovered: [-1, -1], trails: new Set(), arrangement: "side",
  time: 0, speed: 1, playing: false, loop: true, follow: false, theme: "light",
  hover: (clip, joint) => { state.hovered = [clip, joint]; changed(); },
};
const longest = Math.max(0, ...clips.map((clip) => clip.seconds));
const clipNow = () => clips[state.active];

const canvas = byId("stage");
const camera = new OrbitCamera();
const view = { bones: new Batch(), rods: new Batch(), balls: new Batch() };
let renderer = makeRenderer();
let waiting = false;
let lastFrame = 0;

function makeRenderer() {
  // A page whose address ends in #canvas2d shows what a browser without WebGL shows.
  if (location.hash !== "#canvas2d") {
    try {
      const made = new GlRenderer(canvas);
      made.onRestored = () => changed();
      return made;
    } catch { /* There is no WebGL 2 here; the other renderer needs none. */ }
  }
  return new FlatRenderer(canvas);
}

// Draws soon, once, however much has changed until then.
function changed() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(frame);
}

function frame(now) {
  waiting = false;
  if (state.playing) {
    advance(Math.max(0, now - lastFrame) / 1000);
    countFrame(now);
  }
  lastFrame = now;
  draw();
  if (state.playing) changed();
}

function advance(seconds) {
  state.time += seconds * state.speed;
  if (state.time <= longest) return;
  if (state.loop && longest > 0) state.time %= longest;
  else { state.time = longest; play(false); }
}

const counted = { since: 0, frames: 0 };
function countFrame(now) {
  counted.frames++;
  if (now - counted.since < 500) return;
  if (counted.since && now - counted.since < 2000) byId("fps").textContent = `${Math.round((1000 * counted.frames) / (now - counted.since))} fps`;
  Object.assign(counted, { since: now, frames: 0 });
}

const tickOf = (clip) => {
  const tick = Math.min(state.time * clip.ticksPerSecond, clip.duration);
  // Seconds times a rate misses whole ticks by a rounding error.
  return Math.abs(tick - Math.round(tick)) < 1e-6 ? Math.round(tick) : tick;
};

function draw() {
  for (const clip of clips) clip.pose(tickOf(clip));
  fitCanvas();
  followRoot();
  fillBatches();
  const [width, height] = [canvas.width, canvas.height];
  view.camera = camera.see(width / Math.max(1, height));
  view.theme = THEMES[state.theme];
  view.target = camera.target;
  view.groundExtent = Math.max(view.reach * 14, camera.distance * 3);
  view.shadowReach = Math.max(3 * view.reach, 0.8 * camera.distance);
  renderer.draw(view);
  showTime();
  panel.showTick();
  placeTip();
}

function fitCanvas() {
  const ratio = Math.min(2, devicePixelRatio || 1);
  const size = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
}

// The camera goes where the root of the active clip goes, at the same distance.
function followRoot() {
  const clip = clipNow();
  const root = clip.smoothRoot(clip.tick);
  if (state.follow && followRoot.before) {
    const step = sub(root, followRoot.before);
    camera.target = add(camera.target, [step[0], 0, step[2]]);
  }
  followRoot.before = root;
}

function fillBatches() {
  for (const batch of [view.bones, view.rods, view.balls]) batch.clear();
  for (const clip of clips) {
    const positions = clip.nodes.map((_, id) => clip.pagePosition(id));
    clip.drawn = positions;
    clip.nodes.forEach((node, id) => {
      const isChosen = clip.index === state.active && id === state.joint;
      const isHovered = clip.index === state.hovered[0] && id === state.hovered[1];
      const tint = colorOf(clip, node);
      if (node.parent >= 0 && clip.nodes[node.parent].kind !== "group") {
        const [from, to] = [positions[node.parent], positions[id]];
        view.bones.add(from, to, Math.min(0.1 * length(sub(to, from)), 0.036 * clip.reach), isChosen ? mix(tint, CHOSEN, 0.8) : tint);
      }
      const large = isChosen || isHovered;
      const radius = (large ? 0.03 : node.kind === "end_site" ? 0.008 : 0.014) * clip.reach;
      if (node.kind !== "group") view.balls.add(positions[id], positions[id], radius, large ? CHOSEN : mix(tint, [0, 0, 0], 0.3));
    });
  }
  for (const trail of state.trails) addTrail(...trail.split(":").map(Number));
  if (state.joint >= 0) addAxes();
}

const mix = (a, b, share) => [0, 1, 2].map((i) => a[i] + (b[i] - a[i]) * share);

function colorOf(clip, node) {
  if (clips.length === 1) return SIDES[node.side];
  return node.side === "left" ? mix(clip.color, [1, 1, 1], 0.22) : node.side === "right" ? mix(clip.color, [0, 0, 0], 0.22) : clip.color;
}

// Where a joint was in the last seconds, fading.
function addTrail(index, id) {
  const clip = clips[index];
  const [samples, seconds] = [90, 3];
  const { background } = THEMES[state.theme];
  let before = null;
  for (let i = 0; i <= samples; i++) {
    const tick = clip.tick - (1 - i / samples) * seconds * clip.ticksPerSecond;
    if (tick < 0) continue;
    const place = clip.pagePositionAt(id, tick);
    if (before) view.rods.add(before, place, 0.005 * clip.reach, mix(background, CHOSEN, 0.15 + (0.85 * i) / samples));
    before = place;
  }
}

// The axes of the chosen joint: x red, y green, z blue.
function addAxes() {
  const clip = clipNow();
  const m = clip.world[state.joint];
  const origin = clip.filePosition(state.joint);
  const size = (0.16 * clip.reach) / clip.metresPerUnit;
  AXIS_COLORS.forEach((tint, axis) => {
    const end = add(origin, scale(normalize(m.slice(4 * axis, 4 * axis + 3)), size));
    view.rods.add(clip.toPage(origin), clip.toPage(end), 0.006 * clip.reach, tint);
  });
}

// The joint below a pointer: the nearest one within reach of a mouse or a finger.
function jointAt(event) {
  const box = canvas.getBoundingClientRect();
  const { worldToClip } = camera.see(box.width / Math.max(1, box.height));
  let nearest = { distance: event.pointerType === "touch" ? 28 : 14, clip: -1, joint: -1 };
  for (const clip of clips) {
    clip.nodes.forEach((node, joint) => {
      const [x, y, depth] = project(worldToClip, clip.pagePosition(joint));
      const distance = Math.hypot((0.5 + 0.5 * x) * box.width - (event.clientX - box.left), (0.5 - 0.5 * y) * box.height - (event.clientY - box.top));
      if (depth > 0 && node.kind !== "group" && distance < nearest.distance) nearest = { distance, clip: clip.index, joint };
    });
  }
  return nearest;
}

function placeTip() {
  const [index, joint] = state.hovered;
  const tip = byId("tip");
  tip.hidden = index < 0;
  if (index < 0) return;
  const clip = clips[index];
  const [x, y] = project(camera.see(canvas.clientWidth / Math.max(1, canvas.clientHeight)).worldToClip, clip.pagePosition(joint));
  const [local, world] = [clip.translation(joint, clip.tick), clip.filePosition(joint)].map((place) => Array.from(place, short).join("  "));
  tip.textContent = `${clips.length > 1 ? `${clip.name}: ` : ""}${clip.nodes[joint].name}\nlocal  ${local}\nworld  ${world}`;
  tip.style.transform = `translate(${(0.5 + 0.5 * x) * canvas.clientWidth + 14}px, ${(0.5 - 0.5 * y) * canvas.clientHeight - 12}px)`;
}

function showTime() {
  const clip = clipNow();
  byId("scrub").value = clip.tick;
  byId("scrub").setAttribute("aria-valuetext", `tick ${Math.round(clip.tick)} of ${clip.duration}`);
  byId("time").textContent = `${state.time.toFixed(2)} / ${longest.toFixed(2)} s`;
  byId("tick").textContent = `tick ${Math.floor(clip.tick)} / ${clip.duration}`;
}
