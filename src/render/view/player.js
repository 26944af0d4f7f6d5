// The player: controls the clips by buttons and keys.

import { clamp, normalize } from "./math.js";
import { byId, clock, make, save } from "./dom.js";
import { Clip } from "./clip.js";
import { listenToPointers } from "./camera.js";
import { PALETTE } from "./colors.js";
import { showSteps } from "./drag.js";
import { Film } from "./film.js";
import { showLegend } from "./marks.js";
import { MorphSliders } from "./morphs.js";
import { Panel } from "./panel.js";
import { Stage } from "./stage.js";
import { TimeLine } from "./time_line.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2, 4];

// A tick between two frames has two decimals, and is never rounded up to the next frame.
const tickText = (tick) => (Number.isInteger(tick) ? String(tick) : (Math.floor(100 * tick) / 100).toFixed(2));

export class Player {
  // Uses the elements of page.html.
  constructor() {
    this.state = {
      clips: [], active: 0, joint: -1, hovered: [-1, -1], trails: new Set(), arrangement: "side",
      grown: 0, time: 0, speed: 1, playing: false, loop: true, follow: true, bones: true, skin: true, skeleton: false, errors: false, contacts: true, theme: "light",
    };
    this.longest = 0;
    // The enclosing page may set two callbacks: `keep(clip, steps)` applies dragged limbs, and `shown()` is called
    // after each picture.
    this.keep = this.shown = null;
    this.counted = { since: 0, frames: 0 };
    this.canvas = byId("stage");
    this.stage = new Stage(this.canvas, this.state, () => this.changed());
    this.morphs = new MorphSliders(() => this.changed());
    this.panel = new Panel(this.state, {
      choose: (clip, joint) => this.choose(clip, joint),
      activate: (clip) => this.activate(clip),
      hover: (clip, joint) => this.hover(clip, joint),
      seek: (share) => this.seekTime(this.line.range[0] + share * this.line.length),
      changed: () => this.changed(),
      // A manual pose belongs to one tick, so stop playing.
      posed: () => this.play(false),
    });
    this.line = new TimeLine(this, () => this.panel.showPart(this.line.range));
    this.film = new Film(this);
    byId("renderer").textContent = this.stage.renderer.name;
    this.listen();
    this.setSpeed(1);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    this.setTheme(dark.matches ? "dark" : "light");
    dark.addEventListener("change", (event) => this.setTheme(event.matches ? "dark" : "light"));
  }

  get clip() { return this.state.clips[this.state.active]; }

  // Replaces the shown clips; clip.js describes their properties.
  show(clips) {
    const { state } = this;
    state.clips = clips.map((data, index) => new Clip(data, index));
    state.clips.forEach((clip) => { clip.color = PALETTE[clip.index % PALETTE.length]; });
    // All clips share one time, with the duration of the longest clip.
    this.longest = Math.max(0, ...state.clips.map((clip) => clip.seconds));
    // With several clips, each clip has its own colour.
    Object.assign(state, { active: 0, joint: -1, hovered: [-1, -1], time: this.start, bones: clips.length === 1, errors: clips.some((clip) => clip.limbs) && clips.some((clip) => !clip.limbs) });
    state.trails.clear();
    this.play(false);
    this.line.showAll();
    this.arrange("side");
    this.activate(0);
    byId("arrange").hidden = state.clips.length < 2;
    const hasSkin = this.stage.renderer.skins && state.clips.some((clip) => clip.skin);
    byId("skin").hidden = byId("skeleton").hidden = !hasSkin;
    for (const clip of state.clips) this.listenToImages(clip);
    byId("bones").hidden = !state.clips.some((clip) => clip.humanoid);
    byId("errors").hidden = !state.clips.some((clip) => clip.limbs);
    byId("contacts").hidden = !state.clips.some((clip) => clip.contacts.length);
    for (const name of ["loop", "follow", "bones", "skin", "skeleton", "errors", "contacts"]) this.toggle(name, state[name]);
  }

  // Adds a warning if the browser cannot decode an image.
  listenToImages(clip) {
    clip.skin?.textures.forEach((texture) => {
      texture.failed = () => {
        clip.warnings.push("a texture cannot be decoded and is not shown");
        this.panel.showFiles();
      };
    });
  }

  // Requests one redraw, even after several changes.
  changed() {
    if (this.waiting || !this.clip) return;
    this.waiting = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.waiting = false;
    if (this.state.playing) {
      // The first picture shows the start time, even if it took long to draw.
      this.advance(Math.max(0, now - (this.lastFrame ?? now)) / 1000);
      this.countFrame(now);
    }
    this.lastFrame = now;
    this.stage.draw();
    this.morphs.follow();
    showSteps(this.state.clips, this.keep);
    this.showTime();
    this.panel.showTick();
    this.shown?.();
    if (this.state.playing) this.changed();
  }

  // The time at which all clips have begun, after initial rest poses.
  get start() { return Math.min(this.longest, ...this.state.clips.map((clip) => clip.firstTick / clip.ticksPerSecond)); }

  advance(seconds) {
    const { state, start } = this;
    state.time += seconds * state.speed;
    if (state.time <= this.longest) return;
    if (state.loop && this.longest > start) state.time = start + ((state.time - start) % (this.longest - start));
    else {
      state.time = this.longest;
      this.play(false);
    }
  }

  countFrame(now) {
    const { counted } = this;
    counted.frames++;
    if (now - counted.since < 500) return;
    if (counted.since && now - counted.since < 2000) byId("fps").textContent = `${Math.round((1000 * counted.frames) / (now - counted.since))} fps`;
    Object.assign(counted, { since: now, frames: 0 });
  }

  // The time line covers all clips. Its steps are ticks of the active clip, even after the clip's end.
  get ticks() { return Math.round(this.longest * this.clip.ticksPerSecond); }
  get tick() { return this.state.time * this.clip.ticksPerSecond; }

  showTime() {
    const { clip } = this;
    const scrub = byId("scrub");
    this.line.reveal(this.state.time);
    const over = this.state.time > clip.seconds + 1e-6;
    const tick = `tick ${tickText(clip.tick)} / ${clip.duration}${over ? ", over" : ""}`;
    scrub.value = this.tick;
    scrub.setAttribute("aria-valuetext", `${tick}, ${clock(this.state.time, this.longest)} of ${clock(this.longest, this.longest)}`);
    byId("time").textContent = `${clock(this.state.time, this.longest)} / ${clock(this.longest, this.longest)}${this.longest < 60 ? " s" : ""}`;
    byId("tick").textContent = tick;
  }

  // Drags the end of a limb or a chain, until the time changes. On a touch screen, the joint must be selected first.
  grab(event) {
    const { clip: index, joint } = this.stage.jointAt(event);
    const clip = this.state.clips[index];
    if (!clip?.posing.chains.has(joint) || (event.pointerType === "touch" && joint !== this.state.joint)) return null;
    return (moved) => {
      this.play(false);
      this.hover(-1, -1);
      clip.posing.drag(joint, clip.toFile(this.stage.beside(clip.drawn[joint], moved)));
      byId("said").textContent = `${clip.nodes[joint].name} is dragged; Z puts it back`;
    };
  }

  play(wanted) {
    const { state } = this;
    state.playing = wanted && this.longest > 0;
    if (state.playing && state.time >= this.longest) state.time = this.start;
    this.lastFrame = null;
    this.counted.since = 0;
    byId("play").textContent = state.playing ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", state.playing ? "Pause" : "Play");
    this.changed();
  }

  // Seeks to a tick of the active clip.
  seek(tick) { this.seekTime(tick / this.clip.ticksPerSecond); }

  seekTime(seconds) {
    this.state.time = clamp(seconds, 0, this.longest);
    this.changed();
  }

  step(ticks) {
    this.play(false);
    this.seek(Math.round(this.tick) + ticks);
  }

  setSpeed(speed) {
    this.state.speed = speed;
    byId("speed").value = String(speed);
  }

  turnSpeed(by) {
    this.setSpeed(SPEEDS[clamp(SPEEDS.indexOf(this.state.speed) + by, 0, SPEEDS.length - 1)]);
  }

  toggle(name, wanted = !this.state[name]) {
    this.state[name] = wanted;
    byId(name).setAttribute("aria-pressed", wanted);
    showLegend(this.state, this.stage.showsSkeleton(this.clip));
    this.line.showContacts();
    byId("skeleton").disabled = !this.state.skin;
    byId("bones").disabled = !this.stage.showsSkeleton(this.clip);
    this.changed();
  }

  hover(clip, joint) {
    const { hovered } = this.state;
    if (clip === hovered[0] && joint === hovered[1]) return;
    this.state.hovered = [clip, joint];
    this.changed();
  }

  choose(index, joint) {
    const { state } = this;
    if (index >= 0 && index !== state.active) this.activate(index);
    state.joint = joint;
    this.panel.showJoint();
    byId("trail").disabled = joint < 0;
    byId("trail").setAttribute("aria-pressed", state.trails.has(`${state.active}:${joint}`));
    byId("said").textContent = joint < 0 ? "No joint chosen" : `${this.clip.nodes[joint].name} chosen`;
    // On a narrow screen, open the hidden panel with the curves.
    if (joint >= 0) this.showPanel(true);
    this.changed();
  }

  activate(index) {
    const { state } = this;
    Object.assign(state, { active: index, joint: -1 });
    this.stage.before = null;
    this.line.show();
    const { glb } = this.clip;
    byId("download").disabled = !glb;
    byId("download").title = glb ? "Save as animated glTF (G)" : "The motion is too long for a page; mocap convert writes the glTF file";
    byId("download-source").hidden = !this.clip.source;
    this.panel.showClips();
    this.morphs.show(this.stage.renderer.skins ? this.clip : null);
    this.changed();
  }

  nextJoint(by) {
    const { state } = this;
    const { length } = this.clip.nodes;
    this.choose(state.active, state.joint < 0 ? (by > 0 ? 0 : length - 1) : (state.joint + by + length) % length);
  }

  toggleTrail() {
    const { state } = this;
    if (state.joint < 0) return;
    const trail = `${state.active}:${state.joint}`;
    if (!state.trails.delete(trail)) state.trails.add(trail);
    byId("trail").setAttribute("aria-pressed", state.trails.has(trail));
    this.changed();
  }

  arrange(arrangement) {
    this.state.arrangement = arrangement;
    byId("arrange").textContent = arrangement === "side" ? "Overlay" : "Side by side";
    this.stage.arrange({ seconds: this.start });
  }

  turnArrangement() {
    if (this.state.clips.length > 1) this.arrange(this.state.arrangement === "side" ? "over" : "side");
  }

  moveCamera(move) {
    move(this.stage.camera);
    this.changed();
  }

  setTheme(theme) {
    this.state.theme = theme;
    document.documentElement.dataset.theme = theme;
    if (this.clip) this.panel.redraw();
    this.changed();
  }

  turnTheme() { this.setTheme(this.state.theme === "light" ? "dark" : "light"); }

  async download() {
    const { glb, name } = this.clip;
    if (glb) save(await glb(), `${name.replace(/\.\w+$/, "")}.glb`, "model/gltf-binary");
  }

  downloadSource() {
    const { source } = this.clip;
    if (source) save(source.bytes(), source.name, "application/octet-stream");
  }

  showPanel(wanted) {
    byId("panel").classList.toggle("open", wanted);
    byId("panel-button").setAttribute("aria-expanded", wanted);
  }

  showHelp() { byId("help").showModal(); }

  get keys() {
    const look = (yaw, pitch) => () => this.moveCamera((camera) => Object.assign(camera, { yaw, pitch }));
    const orbit = (right, up) => () => this.moveCamera((camera) => camera.orbit(right, up));
    const zoom = (factor) => () => this.moveCamera((camera) => camera.zoom(factor));
    return {
      " ": () => this.play(!this.state.playing),
      ArrowLeft: (event) => this.step(event.shiftKey ? -10 : -1),
      ArrowRight: (event) => this.step(event.shiftKey ? 10 : 1),
      Home: () => this.seekTime(0),
      End: () => this.seekTime(this.longest),
      "[": () => this.turnSpeed(-1),
      "]": () => this.turnSpeed(1),
      l: () => this.toggle("loop"),
      f: () => this.toggle("follow"),
      b: () => byId("bones").hidden || this.toggle("bones"),
      m: () => byId("skin").hidden || this.toggle("skin"),
      o: () => byId("skin").hidden || this.toggle("skeleton"),
      e: () => byId("errors").hidden || this.toggle("errors"),
      x: () => byId("contacts").hidden || this.toggle("contacts"),
      z: () => this.panel.sliders.reset(),
      v: () => this.panel.chain.grow(1),
      V: () => this.panel.chain.grow(-1),
      t: () => this.toggleTrail(),
      j: () => this.nextJoint(1),
      k: () => this.nextJoint(-1),
      c: () => this.turnArrangement(),
      r: () => this.stage.frameAll(),
      n: () => this.turnTheme(),
      g: () => this.download(),
      h: () => this.downloadSource(),
      p: () => this.film.open(),
      ".": () => this.line.zoom(0.5),
      ",": () => this.line.zoom(2),
      "/": () => { this.showPanel(true); byId("search").focus(); },
      "?": () => this.showHelp(),
      Escape: () => this.choose(this.state.active, -1),
      "+": zoom(0.85), "=": zoom(0.85), "-": zoom(1 / 0.85),
      w: orbit(0, 0.1), s: orbit(0, -0.1), a: orbit(0.1, 0), d: orbit(-0.1, 0),
      1: look(0, 0.05), 2: look(Math.PI / 2, 0.05), 3: look(0, 1.55),
    };
  }

  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]") || !this.clip) return;
    const { tagName, type } = event.target;
    // Home and End seek in the motion, unless the focus is in a text field.
    const isWhole = event.key === "Home" || event.key === "End";
    if (tagName === "INPUT" && type !== "range") {
      if (event.key === "Escape") this.canvas.focus();
      return;
    }
    if (tagName === "SELECT" && !isWhole) return;
    // Sliders handle arrow keys, and buttons handle the space bar.
    if (type === "range" && /^(Arrow|Page)/.test(event.key)) return;
    if (/^(BUTTON|SUMMARY)$/.test(tagName) && (event.key === " " || event.key === "Enter")) return;
    const action = this.keys[event.key] || this.keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action(event);
  }

  listen() {
    const { canvas, keys } = this;
    const clicks = {
      play: keys[" "], back: () => this.step(-1), forward: () => this.step(1), loop: keys.l, follow: keys.f, bones: keys.b,
      skin: keys.m, skeleton: keys.o, errors: keys.e, contacts: keys.x,
      trail: keys.t, arrange: keys.c, frame: keys.r, theme: keys.n, download: keys.g, "download-source": keys.h, "film-button": keys.p, "help-button": keys["?"],
      "panel-button": () => this.showPanel(!byId("panel").classList.contains("open")),
      "all-joints": () => this.choose(this.state.active, -1),
    };
    for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
    byId("speed").append(...SPEEDS.map((speed) => make("option", { value: speed }, `${speed}×`)));
    byId("speed").addEventListener("change", (event) => this.setSpeed(Number(event.target.value)));
    document.addEventListener("keydown", (event) => this.onKey(event));
    new ResizeObserver(() => this.changed()).observe(canvas);
    listenToPointers(canvas, this.stage.camera, {
      changed: () => this.changed(),
      grab: (event) => this.grab(event),
      hover: (event) => {
        const { clip, joint } = event ? this.stage.jointAt(event) : { clip: -1, joint: -1 };
        canvas.style.cursor = this.state.clips[clip]?.posing.chains.has(joint) ? "move" : "";
        this.hover(clip, joint);
      },
      choose: (event) => {
        const { clip, joint } = this.stage.jointAt(event);
        this.choose(clip < 0 ? this.state.active : clip, joint);
      },
    });
  }

  // For tests and the console: the drawn scene, in the file's coordinates.
  get handle() {
    const { clips } = this.state;
    const { skins } = this.stage.renderer;
    return {
      state: this.state,
      renderer: this.stage.renderer.name,
      seek: (tick) => this.seek(tick),
      // Places the current figures side by side, and views them from the given angles. The light comes from behind the
      // camera.
      frame: ({ apart, yaw, pitch, closer }) => {
        this.stage.arrange({ seconds: this.state.time, apart });
        Object.assign(this.stage.camera, { yaw, pitch });
        this.stage.camera.zoom(closer);
        this.stage.view.sun = normalize([Math.sin(yaw + 0.7), 1.5, Math.cos(yaw + 0.7)]);
      },
      // Resolves when every texture is shown.
      get ready() { return Promise.resolve(skins?.ready); },
      skins,
      drawn: (index = 0) => clips[index].drawn.map((place) => clips[index].toFile(place)),
      // The position of a joint on the page, in pixels.
      onPage: (joint, index = 0) => {
        const box = this.canvas.getBoundingClientRect();
        const [x, y] = this.stage.onCanvas(clips[index].drawn[joint]);
        return [box.left + x, box.top + y];
      },
      // The position on the page of a point in the file's coordinates.
      placeOnPage: (place, index = 0) => {
        const box = this.canvas.getBoundingClientRect();
        const [x, y] = this.stage.onCanvas(clips[index].toPage(place));
        return [box.left + x, box.top + y];
      },
    };
  }
}
