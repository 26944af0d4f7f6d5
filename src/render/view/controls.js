// What can be done with the page, by buttons and by keys alike, and where it begins.

function play(wanted) {
  state.playing = wanted && longest > 0;
  if (state.playing && state.time >= longest) state.time = 0;
  lastFrame = performance.now();
  counted.since = 0;
  byId("play").textContent = state.playing ? "❚❚" : "▶";
  byId("play").setAttribute("aria-label", state.playing ? "Pause" : "Play");
  changed();
}

function seek(tick) {
  state.time = clamp(tick, 0, clipNow().duration) / clipNow().ticksPerSecond;
  changed();
}

function step(ticks) {
  play(false);
  seek(Math.round(tickOf(clipNow())) + ticks);
}

function setSpeed(speed) {
  state.speed = speed;
  byId("speed").value = String(speed);
}

function turnSpeed(by) {
  setSpeed(SPEEDS[clamp(SPEEDS.indexOf(state.speed) + by, 0, SPEEDS.length - 1)]);
}

function toggle(name, wanted = !state[name]) {
  state[name] = wanted;
  byId(name).setAttribute("aria-pressed", wanted);
  changed();
}

function choose(index, joint) {
  if (index >= 0 && index !== state.active) activate(index);
  state.joint = joint;
  panel.showJoint();
  byId("trail").disabled = joint < 0;
  byId("trail").setAttribute("aria-pressed", state.trails.has(`${state.active}:${joint}`));
  byId("said").textContent = joint < 0 ? "No joint chosen" : `${clipNow().nodes[joint].name} chosen`;
  changed();
}

function activate(index) {
  state.active = index;
  state.joint = -1;
  followRoot.before = null;
  byId("scrub").max = clipNow().duration;
  panel.showFiles();
  panel.showTree();
  panel.showJoint();
  changed();
}

function nextJoint(by) {
  const { nodes } = clipNow();
  choose(state.active, state.joint < 0 ? (by > 0 ? 0 : nodes.length - 1) : (state.joint + by + nodes.length) % nodes.length);
}

function toggleTrail() {
  if (state.joint < 0) return;
  const trail = `${state.active}:${state.joint}`;
  if (!state.trails.delete(trail)) state.trails.add(trail);
  byId("trail").setAttribute("aria-pressed", state.trails.has(trail));
  changed();
}

// Side by side the figures start next to one another; overlaid they stand where their files put them.
function arrange(arrangement) {
  state.arrangement = arrangement;
  const wide = 1.5 * Math.max(...clips.map((clip) => clip.reach));
  for (const clip of clips) {
    clip.shift = [0, 0, 0];
    if (clips.length < 2) continue;
    const start = clip.pagePositionAt(clip.root, 0);
    const low = Math.min(...clips.map((other) => other.floor));
    if (arrangement === "side") clip.shift = [(clip.index - (clips.length - 1) / 2) * wide - start[0], low - clip.floor, -start[2]];
  }
  byId("arrange").textContent = arrangement === "side" ? "Overlay" : "Side by side";
  frameAll();
}

function frameAll() {
  const starts = clips.map((clip) => clip.pagePositionAt(clip.root, tickOf(clip)));
  const middle = scale(starts.reduce(add), 1 / clips.length);
  view.reach = Math.max(...clips.map((clip) => clip.reach));
  view.ground = Math.min(...clips.map((clip) => clip.floor + clip.shift[1]));
  const spread = Math.max(...starts.map((start) => length(sub(start, middle))));
  camera.target = [middle[0], view.ground + Math.max(0.2 * view.reach, Math.min(0.95 * view.reach, middle[1] - view.ground)), middle[2]];
  camera.home.distance = 3.7 * view.reach + 2.2 * spread;
  camera.reset();
  followRoot.before = null;
  view.gridStep = 10 ** Math.round(Math.log10(view.reach)) / 5;
  const unit = clips.length === 1 ? `, 1 unit = ${short(clipNow().metresPerUnit)} m` : "";
  byId("grid-scale").textContent = `bold lines ${short(5 * view.gridStep)} m apart${unit}`;
  changed();
}

function look(yaw, pitch) {
  Object.assign(camera, { yaw, pitch });
  changed();
}

function setTheme(theme) {
  state.theme = theme;
  document.documentElement.dataset.theme = theme;
  panel.redraw();
  changed();
}

function download() {
  const clip = clipNow();
  clip.glbBytes ??= takeBytes(clip.glb);
  const address = URL.createObjectURL(new Blob([clip.glbBytes], { type: "model/gltf-binary" }));
  make("a", { href: address, download: `${clip.name.replace(/\.\w+$/, "")}.glb` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

const showHelp = () => byId("help").showModal();

const KEYS = {
  " ": () => play(!state.playing),
  ArrowLeft: (event) => step(event.shiftKey ? -10 : -1),
  ArrowRight: (event) => step(event.shiftKey ? 10 : 1),
  Home: () => seek(0),
  End: () => seek(clipNow().duration),
  "[": () => turnSpeed(-1),
  "]": () => turnSpeed(1),
  l: () => toggle("loop"),
  f: () => toggle("follow"),
  t: toggleTrail,
  j: () => nextJoint(1),
  k: () => nextJoint(-1),
  c: () => clips.length > 1 && arrange(state.arrangement === "side" ? "over" : "side"),
  r: frameAll,
  n: () => setTheme(state.theme === "light" ? "dark" : "light"),
  g: download,
  "/": () => { showPanel(true); byId("search").focus(); },
  "?": showHelp,
  Escape: () => choose(state.active, -1),
  "+": () => { camera.zoom(0.85); changed(); },
  "=": () => { camera.zoom(0.85); changed(); },
  "-": () => { camera.zoom(1 / 0.85); changed(); },
  w: () => { camera.orbit(0, 0.1); changed(); },
  s: () => { camera.orbit(0, -0.1); changed(); },
  a: () => { camera.orbit(0.1, 0); changed(); },
  d: () => { camera.orbit(-0.1, 0); changed(); },
  1: () => look(0, 0.05),
  2: () => look(Math.PI / 2, 0.05),
  3: () => look(0, 1.55),
};

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help").open) return;
  const { tagName, type } = event.target;
  if (tagName === "INPUT" && type !== "range") {
    if (event.key === "Escape") canvas.focus();
    return;
  }
  if (tagName === "SELECT") return;
  // A slider has its own arrow keys, a button its own space.
  if (type === "range" && /^(Arrow|Home|End|Page)/.test(event.key)) return;
  if (/^(BUTTON|SUMMARY)$/.test(tagName) && (event.key === " " || event.key === "Enter")) return;
  const action = KEYS[event.key] || KEYS[event.key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  action(event);
}

function showPanel(wanted) {
  byId("panel").classList.toggle("open", wanted);
  byId("panel-button").setAttribute("aria-expanded", wanted);
}

const panel = new Panel(state, { choose, activate, seek: (share) => seek(share * clipNow().duration) });

byId("play").addEventListener("click", () => play(!state.playing));
byId("back").addEventListener("click", () => step(-1));
byId("forward").addEventListener("click", () => step(1));
byId("scrub").addEventListener("input", (event) => { play(false); seek(Number(event.target.value)); });
byId("speed").append(...SPEEDS.map((speed) => make("option", { value: speed }, `${speed}×`)));
byId("speed").addEventListener("change", (event) => setSpeed(Number(event.target.value)));
byId("loop").addEventListener("click", () => toggle("loop"));
byId("follow").addEventListener("click", () => toggle("follow"));
byId("trail").addEventListener("click", toggleTrail);
byId("arrange").addEventListener("click", KEYS.c);
byId("frame").addEventListener("click", frameAll);
byId("theme").addEventListener("click", KEYS.n);
byId("download").addEventListener("click", download);
byId("help-button").addEventListener("click", showHelp);
byId("panel-button").addEventListener("click", () => showPanel(!byId("panel").classList.contains("open")));
document.addEventListener("keydown", onKey);
new ResizeObserver(changed).observe(canvas);
listenToPointers(canvas, camera, {
  changed,
  hover: (event) => {
    const { clip, joint } = event ? jointAt(event) : { clip: -1, joint: -1 };
    if (clip !== state.hovered[0] || joint !== state.hovered[1]) state.hover(clip, joint);
  },
  choose: (event) => {
    const { clip, joint } = jointAt(event);
    choose(clip < 0 ? state.active : clip, joint);
  },
});

byId("arrange").hidden = clips.length < 2;
byId("renderer").textContent = renderer.name;
byId("scrub").max = clipNow().duration;
setSpeed(1);
toggle("loop", true);
toggle("follow", true);
panel.showJoint();
arrange("side");
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => setTheme(event.matches ? "dark" : "light"));

// For tests, and for a console: what is drawn, in the file's own coordinates.
window.mocap = {
  state,
  renderer: renderer.name,
  seek,
  drawn: (index = 0) => clips[index].drawn.map((place) => clips[index].toFile(place)),
  // Where a joint is on the page, in its pixels.
  onPage: (joint, index = 0) => {
    const box = canvas.getBoundingClientRect();
    const [x, y] = project(camera.see(box.width / box.height).worldToClip, clips[index].drawn[joint]);
    return [box.left + (0.5 + 0.5 * x) * box.width, box.top + (0.5 - 0.5 * y) * box.height];
  },
};
