// The panel beside the player: open files, their problems and assumptions, and outputs.

import { byId, make } from "../../../src/render/view/dom.js";
import { Blocks, loadAll, unpacked } from "../../../src/render/view/unpack.js";
import { boneChoice, withBone } from "./bones.js";
import { listenToFiles } from "./dropping.js";
import { chosenFiles, itemsOf } from "./files.js";
import { findingElement } from "./finding.js";
import { Opened, isCharacter, isRobotFormat, pairOf, plural, summaryOf } from "./opened.js";
import { notShownOf } from "./not_shown.js";
import { Progress } from "./progress.js";
import { RobotView } from "./robot.js";
import { Saving, stem } from "./saving.js";
import { Steps } from "./steps.js";
import { Trim } from "./trim.js";

/** Whether the user prefers reduced motion. */
const wantsStillness = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Desk {
  // `ownPage` is the page that contains the player.
  constructor(player, reader, ownPage) {
    Object.assign(this, { player, reader, ownPage });
    this.opened = new Opened({ show: (item) => this.show([item]), turnBeside: (item) => this.turnBeside(item), remove: (item) => this.remove(item) });
    this.progress = new Progress();
    this.steps = new Steps({ known: () => this.reader.ask({ call: "steps" }), change: (steps) => this.change(this.chosen, "steps", steps), compare: () => this.compare(this.chosen) });
    this.saving = new Saving({
      chosen: () => this.chosen,
      all: () => this.items.filter((item) => item.state === "ok" && !isCharacter(item)),
      ask: (item, request) => this.reader.ask({ ...request, item: this.request(item) }),
      shown: () => this.shown,
      page: (items) => this.ownPage.with(items),
      film: () => this.player.film.open(),
    });
    this.robot = new RobotView(player);
    player.shown = () => this.robot.point();
    this.trim = new Trim({ tick: () => player.tick, change: (values) => this.change(this.chosen, "change", values), tell: (text) => this.tell(text) });
    player.keep = (clip, steps) => this.keep(clip, steps);
    player.panel.boneChoice = (clip, node) => this.boneChoice(clip, node);
    // The number of drops and file selections so far, and of those in progress.
    this.openings = this.opening = 0;
    // The items in the player, and the one whose details are shown.
    this.shown = [];
    this.chosen = null;
    this.listen();
  }

  get items() { return this.opened.items; }

  // Opens dropped or selected files, each with its path. Shows the first readable file, or a motion on a character if both are
  // among them. `onFigure` is the item on whose figure the files were dropped.
  async open(files, onFigure = null) {
    this.openings++;
    this.opening++;
    const { items, passedOver } = itemsOf(files);
    this.tell(this.passedOver(items, passedOver));
    const added = items.map((item) => this.opened.add(item));
    this.showList();
    let wanted;
    for (const item of added) {
      const isShown = await this.show([item]);
      wanted = this.wanted;
      if (isShown) break;
    }
    await Promise.all(added.filter(({ state }) => state === "waiting").map((item) => this.inspect(item)));
    const pair = pairOf(added, onFigure);
    // Skip this if the user has selected another item meanwhile.
    if (pair && wanted === this.wanted) await this.putOn(pair.motion, pair.character, { isTried: true });
    this.opening--;
  }

  // Restores the items that were saved in this page.
  async restore() {
    this.openings++;
    this.opening++;
    const { session } = this.ownPage;
    // A retargeted motion, or a motion before its steps, shares the files of the motion, but is a separate item.
    const mark = ({ onto, isBefore }, index) => (onto === undefined && !isBefore ? undefined : `another ${index}`);
    const items = (await this.ownPage.opened()).map((item, index) => [this.opened.add({ ...item, onto: null, mark: mark(item, index) }), item.onto, item.from]);
    for (const [item, onto, from] of items) Object.assign(item, { onto: items[onto]?.[0] ?? null, from: items[from]?.[0] });
    this.showList();
    await this.show(items.slice(0, session.shown).map(([item]) => item));
    await Promise.all(this.items.filter(({ state }) => state === "waiting").map((item) => this.inspect(item)));
    this.opening--;
  }

  /** The walk that an empty page offers. */
  openWalk() {
    const name = "walk.mclip";
    return this.open([{ file: new File([this.ownPage.walkBytes], name, { lastModified: 0 }), path: name }]);
  }

  // Keeps a dragged hand or foot in place, as a step.
  keep(clip, steps) {
    const item = this.shown[clip.index];
    // The first step drops a rest pose before the motion.
    const before = item.steps.length ? 0 : item.clip.data.firstTick;
    const frame = Math.max(0, Math.round(clip.tick) - before);
    const texts = steps.map(({ limb, to }) => `reach:limb=${limb},to=${to.join("/")},range=${frame}f..${frame}f`);
    return this.change(item, "steps", [...item.steps, ...texts]);
  }

  // Shows a motion with and without its steps, overlaid.
  async compare(item) {
    const { path, files, names, read, change } = item;
    // With steps, a rest pose before the motion is dropped.
    const before = { path, files, names, read, change: { firstFrame: "auto", ...change }, steps: [], name: `${item.name}, before`, mark: `before ${item.id}`, isBefore: true };
    const known = this.items.find(({ mark }) => mark === before.mark);
    this.tell("");
    this.showList();
    if (await this.show([item, Object.assign(known ?? this.opened.add(before), before)], { keepTime: true })) this.player.arrange("over");
  }

  // A selection of a joint's bone. The bones of a retargeted character belong to another file, so they cannot be selected.
  boneChoice(clip, node) {
    const item = this.shown[clip.index];
    if (!item || item.onto || isRobotFormat(item.format)) return [];
    return [boneChoice(node.bone, async (bone) => {
      await this.change(item, "change", { bones: withBone(item.change.bones, node, bone) });
      this.player.choose(clip.index, clip.nodes.indexOf(node));
    })];
  }

  passedOver(items, files) {
    if (!items.length && !files.length) return "You dropped no files.";
    if (!files.length) return items.length ? "" : "None of these files is a motion.";
    const names = files.slice(0, 3).map(({ path }) => path.split("/").pop());
    return `Skipped, because the names are not names of motions: ${names.join(", ")}${files.length > 3 ? ` and ${files.length - 3} more` : ""}.`;
  }

  /** The request to the reader for an item. */
  request({ id, files, names, read, change, steps, onto, retarget }) {
    return { id, files, names, read, change, steps, onto: onto && { id: onto.id, files: onto.files, names: onto.names }, retarget };
  }

  async inspect(item) {
    try {
      const facts = await this.reader.ask({ call: "inspect", item: this.request(item) }, { isUrgent: false });
      if (item.state === "waiting") this.succeed(item, facts);
    } catch (error) {
      if (item.state === "waiting") this.fail(item, error);
    }
    this.showRow(item);
    if (item === this.chosen) this.showDetails();
  }

  succeed(item, facts) {
    const { joints, format, hasSkin } = facts;
    // Keep the number of clips if the user has not selected one. A trim counts the frames of the file.
    if (!("clip" in item.read)) item.clips = facts.clips;
    if (!Object.keys(item.change).length && !item.steps.length) item.frames = facts.frames;
    Object.assign(item, { state: "ok", error: null, summary: summaryOf({ ...facts, clips: item.clips }), joints, format, hasSkin });
    // A character needs no motion.
    item.warnings = facts.warnings.filter(({ code }) => code !== "no-motion" || !(item.onto || isCharacter(item)));
    this.showCharacters();
  }

  fail(item, error) {
    if (error.code === "stopped") return Object.assign(item, { state: "stopped", error: null, warnings: [] });
    return Object.assign(item, { state: "error", error, warnings: error.warnings ?? [], summary: error.reason ?? error.message });
  }

  // Shows items in the player, and selects the first. Returns whether all items could be shown.
  async show(items, { keepTime = false } = {}) {
    const wanted = { items };
    this.wanted = wanted;
    const [first] = items;
    this.choose(first);
    const { time, playing } = this.player.state;
    const clips = [];
    for (const item of items) {
      try {
        clips.push(await this.clip(item));
      } catch (error) {
        if (this.wanted !== wanted) return false;
        this.fail(item, error);
        this.showRow(item);
        this.choose(item);
        return false;
      }
      if (this.wanted !== wanted) return true;
    }
    this.forget(this.shown.filter((item) => !items.includes(item)));
    this.shown = items;
    document.body.classList.add("showing");
    this.player.show(clips);
    if (keepTime) {
      this.player.seekTime(time);
      // The figure may have moved or changed its size.
      this.player.stage.frameAll();
    }
    this.player.play(keepTime ? playing : !wantsStillness());
    loadAll(clips);
    document.title = `${first.name} · mocap`;
    document.querySelector("h1").textContent = items.map(({ name }) => name).join(", ");
    this.showList();
    this.choose(first);
    return true;
  }

  // The clip of an item in the player's format. The clip is kept while it is shown.
  async clip(item) {
    const key = JSON.stringify([item.read, item.change, item.steps, item.retarget]);
    if (item.clip?.key !== key) {
      const answer = await this.reader.ask({ call: "show", item: this.request(item), name: item.name });
      const bytes = new Map(answer.blocks);
      const data = unpacked({ ...answer.description, assumptions: [], warnings: answer.leftOut }, new Blocks((id) => bytes.get(id)));
      const { onto, steps, change } = item;
      // Retargeted motions and motions with steps have dropped the rest pose.
      const hasRest = !onto && !steps.length && !change.first && (change.firstFrame ?? "keep") === "keep";
      const startsAtRest = hasRest && answer.assumptions.some(({ topic, choice }) => topic === "first-frame" && choice === "rest-pose");
      item.clip = { key, data: { ...data, firstTick: startsAtRest ? 1 : 0, glb: () => this.saving.bytes(item, "glb") } };
      item.answer = answer;
      item.notShown = await notShownOf((item.onto ?? item).files[0]);
      this.succeed(item, answer);
      this.showRow(item);
    }
    return item.clip.data;
  }

  forget(items) {
    for (const item of items) item.clip = null;
  }

  // Changes how an item is read or trimmed. If the change fails, the item stays as before.
  async change(item, part, values) {
    const before = { read: item.read, change: item.change, steps: item.steps };
    item[part] = Array.isArray(values) ? values : Object.fromEntries(Object.entries({ ...item[part], ...values }).filter(([, value]) => value !== undefined));
    this.tell("");
    const items = this.shown.includes(item) ? this.shown : [item];
    if (await this.show([item, ...items.filter((other) => other !== item)], { keepTime: true })) return;
    if (item.state !== "error" || !this.shown.includes(item)) return;
    // The item in the player is from before the change.
    const reason = item.error.reason ?? item.error.message;
    Object.assign(item, before);
    this.tell(`Not changed: ${reason}`);
    this.succeed(item, item.answer);
    this.showRow(item);
    this.showDetails();
  }

  // Makes a new item: a motion retargeted to a character. With `isTried`, a failed item is removed.
  async putOn(item, character, { isTried = false } = {}) {
    const { path, files, names, read, change, steps } = item;
    const name = `${stem(item.name)} on ${stem(character.name)}`;
    const asBefore = (other) => other.onto === character && other.from === item && JSON.stringify([other.read, other.change, other.steps]) === JSON.stringify([read, change, steps]);
    const moved = this.items.find(asBefore) ?? this.opened.add({ path, files, names, read, change, steps, name, onto: character, from: item });
    moved.retarget = { feet: byId("feet").value, bones: change.bones, characterBones: character.change.bones };
    this.showList();
    const isShown = await this.show([moved]);
    if (isTried && moved.state === "error") {
      const reason = moved.error.reason ?? moved.error.message;
      await this.remove(moved, item);
      this.tell(`${item.name} cannot be retargeted to ${character.name}: ${reason}.`);
    } else if (isShown && !isTried) {
      await this.show([moved, item]);
    }
  }

  // Removes an item from the list, and shows another item instead.
  async remove(item, next = this.items[this.items.indexOf(item) + 1] ?? this.items.at(-2)) {
    this.opened.remove(item);
    this.forget([item]);
    this.reader.forget(item.id);
    const left = this.shown.filter((other) => other !== item);
    if (item === this.chosen || left.length < this.shown.length) {
      this.shown = left;
      if (left.length || next) return this.show(left.length ? left : [next]);
      this.clear();
    }
    return this.showList();
  }

  // Removes all items.
  clear() {
    for (const item of this.items) this.reader.forget(item.id);
    this.opened.items = [];
    Object.assign(this, { shown: [], chosen: null, wanted: null });
    this.player.play(false);
    document.body.classList.remove("showing");
    document.title = document.querySelector("h1").textContent = "mocap";
    this.tell("");
    this.showList();
    this.showDetails();
  }

  tell(text) {
    byId("notice").hidden = !text;
    byId("notice").textContent = text;
  }

  tellRestart({ code, message }) {
    if (this.reader?.broken) return this.tell(`The reader did not start: ${message}.`);
    if (code === "stopped") return this.tell("Stopped. Press a file in the list to read it again.");
    this.tell(`The reader ended and was started again: ${message}. Other files can be read as before.`);
  }

  showProgress(request, stage, share) { this.progress.show(request, stage, share, this.items); }

  showList() {
    this.opened.show(this.chosen, this.shown);
    this.showCharacters();
  }

  showRow(item) { this.opened.showRow(item, this.chosen, this.shown); }

  turnBeside(item) {
    const others = this.shown.filter((other) => other !== item);
    return this.show(this.shown.includes(item) ? others : [...others, item]);
  }

  choose(item) {
    const before = this.chosen;
    this.chosen = item;
    for (const changed of [before, item]) if (changed) this.showRow(changed);
    this.showDetails();
  }

  next(by) {
    const at = this.items.indexOf(this.chosen) + by;
    if (this.items[at]) this.show([this.items[at]]);
  }

  showDetails() {
    const item = this.chosen;
    byId("details").hidden = !item || item.state === "waiting";
    byId("not-shown").hidden = true;
    if (byId("details").hidden) return;
    const { name, state, error, warnings, answer } = item;
    byId("chosen-name").textContent = name;
    byId("chosen-facts").textContent = { error: "The file could not be read.", stopped: "Reading was stopped." }[state] ?? this.facts(item);
    byId("stays-still").textContent = (state === "ok" && item.notShown) || "";
    byId("again").hidden = state !== "error" && state !== "stopped";
    // The picture shows another file.
    byId("not-shown").hidden = this.shown.includes(item) || !this.shown.length;
    byId("not-shown").textContent = `The picture shows ${this.shown.map((other) => other.name).join(", ")}.`;
    const findings = [...(error ? [[error, true]] : []), ...warnings.map((warning) => [warning, false])];
    byId("findings").hidden = !findings.length;
    byId("findings-title").textContent = [error && "1 error", warnings.length && plural(warnings.length, "warning")].filter(Boolean).join(", ");
    byId("finding-list").replaceChildren(...findings.map(([finding, isError]) => findingElement(finding, isError)));
    byId("tools").hidden = state !== "ok" || !answer;
    if (!byId("tools").hidden) this.showTools(item);
  }

  facts({ summary, answer }) {
    const report = answer?.retargeted;
    if (isCharacter(this.chosen)) return `${summary}. Drop a motion on the figure, and it moves.`;
    return report ? `${summary}; mean limb error ${report.mean_degrees.toFixed(1)}°` : summary;
  }

  showTools(item) {
    const { read, change, answer, onto } = item;
    const reason = (topic) => {
      const found = answer.assumptions.find((assumption) => assumption.topic === topic);
      return found ? `${found.choice}: ${found.reason}${found.confidence ? ` (${found.confidence})` : ""}` : "";
    };
    const clips = item.clips ?? [];
    byId("clip-choice").hidden = clips.length < 2;
    byId("clip").replaceChildren(make("option", { value: "" }, `all, ${clips[0]?.name ?? "the first"} is shown`),
      ...clips.map(({ name, seconds }, index) => make("option", { value: index }, `${name || `clip ${index + 1}`}, ${Number(seconds.toFixed(2))} s`)));
    byId("clip").value = read.clip ?? "";
    const isNumber = typeof change.unit === "number";
    byId("unit").value = isNumber ? "other" : change.unit ?? "";
    byId("other-unit").hidden = !isNumber;
    byId("metres").value = isNumber ? change.unit : "";
    byId("up").value = change.up ?? "";
    byId("first-frame").value = change.firstFrame ?? "keep";
    byId("root-offset").value = read.rootOffset ?? "auto";
    byId("offset-choice").hidden = !answer.rootOffset;
    for (const topic of ["unit", "up", "first-frame"]) byId(`${topic}-reason`).textContent = reason(topic);
    byId("root-offset-reason").textContent = answer.rootOffset ? `${answer.rootOffset.policy}: ${answer.rootOffset.reason}` : "";
    const own = new Set(["unit", "up", "first-frame"]);
    const others = answer.assumptions.filter(({ topic }) => !own.has(topic));
    byId("more-assumed").hidden = !others.length;
    byId("other-assumptions").replaceChildren(...others.map((other) => make("li", {}, `${other.topic}: ${other.choice}, ${other.reason}`)));
    // The options of reading and trimming belong to the source motion, not to the retargeted motion.
    byId("assumed").hidden = Boolean(onto);
    this.trim.show(item);
    byId("onto").hidden = Boolean(onto) || !answer.frames;
    byId("steps").hidden = Boolean(onto) || !answer.frames;
    this.steps.show(item);
    this.robot.show(item);
    this.saving.show(item);
    this.showCharacters();
  }

  showCharacters() {
    const select = byId("character");
    const before = select.value;
    const items = this.items.filter((item) => item !== this.chosen && item.state === "ok" && !item.onto && item.format !== "c3d");
    // List files without motion first, because they are probably characters.
    items.sort((a, b) => Number(Boolean(a.frames)) - Number(Boolean(b.frames)));
    select.replaceChildren(...items.map(({ id, name }) => make("option", { value: id }, name)), make("option", { value: "open" }, "open a file…"));
    if (items.some(({ id }) => String(id) === before)) select.value = before;
  }

  listen() {
    const onChange = (id, act) => byId(id).addEventListener("change", (event) => act(event.target.value));
    const onClick = (id, act) => byId(id).addEventListener("click", act);
    const change = (values) => this.change(this.chosen, "change", values);
    onChange("unit", (unit) => {
      byId("other-unit").hidden = unit !== "other";
      if (unit === "other") byId("metres").focus();
      else change({ unit: unit || undefined });
    });
    onChange("metres", (metres) => Number(metres) > 0 && change({ unit: Number(metres) }));
    onChange("up", (up) => change({ up: up || undefined }));
    onChange("first-frame", (policy) => change({ firstFrame: policy === "keep" ? undefined : policy }));
    onChange("clip", (clip) => this.change(this.chosen, "read", { clip: clip === "" ? undefined : Number(clip) }));
    onChange("root-offset", (policy) => this.change(this.chosen, "read", { rootOffset: policy === "auto" ? undefined : policy }));
    onClick("put-on", () => {
      const { value } = byId("character");
      const character = this.items.find(({ id }) => String(id) === value);
      if (character) this.putOn(this.chosen, character);
      else this.openCharacter();
    });
    onClick("stop", () => this.reader.stop());
    onClick("again", () => this.show([this.chosen]));
    onClick("remove-all", () => {
      this.clear();
      byId("start-open").focus();
    });
    onClick("desk-button", () => this.showDesk(!byId("desk").classList.contains("open")));
    listenToFiles(this);
    document.addEventListener("keydown", (event) => {
      const by = { PageUp: -1, PageDown: 1 }[event.key];
      if (!by || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
      event.preventDefault();
      this.next(by);
    });
    document.querySelector(".keys").prepend(make("dt", {}, make("kbd", {}, "Page↑"), " ", make("kbd", {}, "Page↓")), make("dd", {}, "previous, next file"));
    // On a phone, only one panel is open at a time.
    onClick("panel-button", () => byId("panel").classList.contains("open") && this.showDesk(false));
  }

  showDesk(wanted) {
    byId("desk").classList.toggle("open", wanted);
    byId("desk-button").setAttribute("aria-expanded", wanted);
    if (wanted) this.player.showPanel(false);
  }

  // Opens a file as a character, and keeps showing the motion.
  openCharacter() {
    const motion = this.chosen;
    const input = make("input", { type: "file" });
    input.addEventListener("change", () => {
      const [item] = itemsOf(chosenFiles(input)).items;
      if (item) this.putOn(motion, this.opened.add(item));
    });
    input.click();
  }
}
