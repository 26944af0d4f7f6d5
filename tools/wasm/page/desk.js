// The desk beside the player: what is opened, what is wrong with it, what was assumed, and what is made of it.

import { byId, make, save } from "../../../src/render/view/dom.js";
import { Blocks, loadAll, unpacked } from "../../../src/render/view/unpack.js";
import { chosenFiles, droppedFiles, itemsOf } from "./files.js";
import { findingElement } from "./finding.js";

const STAGES = {
  starting: "starting", reading: "reading", parsing: "understanding", retargeting: "putting on the character", packing: "preparing the picture", writing: "writing",
};
const TYPES = { glb: "model/gltf-binary", vrma: "model/gltf-binary", bvh: "text/plain", csv: "text/csv", png: "image/png" };

const stem = (name) => name.replace(/\.\w+$/, "");
const plural = (count, one) => `${count} ${one}${count === 1 ? "" : "s"}`;
const number = (value) => Number(value.toFixed(2));

/** A summary of a clip in a list. */
function summary({ frames, ticksPerSecond, joints }) {
  if (!frames) return `no motion, ${plural(joints, "joint")}`;
  return `${number((frames - 1) / ticksPerSecond)} s, ${plural(frames, "frame")}, ${plural(joints, "joint")}`;
}

export class Desk {
  constructor(player, reader) {
    Object.assign(this, { player, reader });
    this.items = [];
    this.last = 0;
    // The items in the player, and the one whose details are shown.
    this.shown = [];
    this.chosen = null;
    this.listen();
  }

  // What was dropped or chosen, each file with its path. The first that can be read is shown.
  async open(files) {
    const { items, passedOver } = itemsOf(files);
    this.tell(this.passedOver(items, passedOver));
    const added = items.map((item) => this.add(item));
    this.showList();
    for (const item of added) if (await this.show([item])) break;
    for (const item of added) if (item.state === "waiting") this.inspect(item);
  }

  passedOver(items, files) {
    if (!items.length && !files.length) return "There is no file in what was dropped.";
    if (!files.length) return items.length ? "" : "None of these files is a motion.";
    const names = files.slice(0, 3).map(({ path }) => path.split("/").pop());
    return `Passed over, not named as motion: ${names.join(", ")}${files.length > 3 ? ` and ${files.length - 3} more` : ""}.`;
  }

  add(item) {
    const added = { onto: null, read: {}, change: {}, retarget: { feet: "lock" }, state: "waiting", warnings: [], id: ++this.last, ...item };
    this.items.push(added);
    return added;
  }

  /** What the reader has to know of an item. */
  request({ id, files, names, read, change, onto, retarget }) {
    return { id, files, names, read, change, onto: onto && { id: onto.id, files: onto.files, names: onto.names }, retarget };
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
    // A character needs no motion of its own.
    const warnings = facts.warnings.filter(({ code }) => !item.onto || code !== "no-motion");
    Object.assign(item, { state: "ok", error: null, warnings, summary: summary(facts), format: facts.format });
    // The frames of the file, which a trim counts.
    if (!Object.keys(item.change).length) item.frames = facts.frames;
    this.showCharacters();
  }

  fail(item, error) {
    Object.assign(item, { state: "error", error, warnings: error.warnings ?? [], summary: error.reason ?? error.message });
  }

  // Shows items in the player; whether all could be. The first is chosen.
  async show(items, { keepTime = false } = {}) {
    const wanted = { items };
    this.wanted = wanted;
    const [first] = items;
    this.choose(first);
    const { time } = this.player.state;
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
    if (keepTime) this.player.seekTime(time);
    loadAll(clips);
    document.title = `${first.name} · mocap`;
    document.querySelector("h1").textContent = items.map(({ name }) => name).join(", ");
    this.showList();
    this.choose(first);
    return true;
  }

  // The clip of an item in the form that the player reads. It is kept while it is shown.
  async clip(item) {
    const key = JSON.stringify([item.read, item.change, item.retarget]);
    if (item.clip?.key !== key) {
      const answer = await this.reader.ask({ call: "show", item: this.request(item), name: item.name });
      const bytes = new Map(answer.blocks);
      const data = unpacked({ ...answer.description, assumptions: [], warnings: answer.leftOut }, new Blocks((id) => bytes.get(id)));
      item.clip = { key, data: { ...data, glb: () => this.bytes(item, "glb") } };
      item.answer = answer;
      this.succeed(item, answer);
      this.showRow(item);
    }
    return item.clip.data;
  }

  forget(items) {
    for (const item of items) item.clip = null;
  }

  // A change of how an item is read or cut; without effect where it cannot be.
  async change(item, part, values) {
    const before = { read: item.read, change: item.change };
    item[part] = Object.fromEntries(Object.entries({ ...item[part], ...values }).filter(([, value]) => value !== undefined));
    this.tell("");
    const items = this.shown.includes(item) ? this.shown : [item];
    if (await this.show([item, ...items.filter((other) => other !== item)], { keepTime: true })) return;
    if (item.state !== "error" || !this.shown.includes(item)) return;
    // What is still in the player was read before.
    const reason = item.error.reason ?? item.error.message;
    Object.assign(item, before);
    this.tell(`Not changed: ${reason}`);
    this.succeed(item, item.answer);
    this.showRow(item);
    this.showDetails();
  }

  // A new item: the motion of one on the skeleton of another.
  async putOn(item, character) {
    const { path, files, names, read, change } = item;
    const name = `${stem(item.name)} on ${stem(character.name)}`;
    const known = this.items.find((other) => other.name === name && JSON.stringify(other.change) === JSON.stringify(change));
    const moved = known ?? this.add({ path, files, names, read, change, name, onto: character });
    moved.retarget = { feet: byId("feet").value };
    this.showList();
    if (await this.show([moved])) await this.show([moved, item]);
  }

  async bytes(item, format) {
    const maxError = Number(byId("max-error").value);
    const options = maxError && (format === "glb" || format === "vrma") ? { maxError } : {};
    const request = { call: "save", item: this.request(item), name: stem(item.name), format, options };
    const { bytes, warnings } = await this.reader.ask(request);
    const notes = warnings.map(({ message }) => message).join("; ");
    byId("saved").textContent = `${format.toUpperCase()}: ${bytes.length.toLocaleString("en")} bytes${notes ? `; ${notes}` : ""}`;
    return bytes;
  }

  async save(format) {
    const item = this.chosen;
    try {
      save(await this.bytes(item, format), `${stem(item.name)}.${format}`, TYPES[format]);
    } catch (error) {
      byId("saved").textContent = `${format.toUpperCase()} was not written: ${error.reason ?? error.message}${error.help ? ` (${error.help})` : ""}`;
    }
  }

  tell(text) {
    byId("notice").hidden = !text;
    byId("notice").textContent = text;
  }

  tellRestart({ code, message }) {
    if (this.reader?.broken) return this.tell(`The reader did not start: ${message}.`);
    const why = code === "stopped" ? "The reader was stopped and started again." : `The reader ended and was started again: ${message}.`;
    this.tell(`${why} Other files can be read as before.`);
  }

  // The running request and its progress.
  showProgress(request, stage, share) {
    clearTimeout(this.soon);
    if (!request) {
      byId("work").hidden = true;
      return;
    }
    const item = this.items.find(({ id }) => id === request.item.id);
    const left = this.items.filter(({ state }) => state === "waiting").length;
    const place = left > 1 ? `${this.items.length - left + 1} of ${this.items.length}: ` : "";
    byId("work-text").textContent = `${place}${item?.name ?? ""}, ${STAGES[stage]}`;
    if (left > 1) byId("work-bar").value = 1 - left / this.items.length;
    else if (share === undefined) byId("work-bar").removeAttribute("value");
    else byId("work-bar").value = share;
    // What is done at once needs no bar.
    if (byId("work").hidden) this.soon = setTimeout(() => { byId("work").hidden = false; }, 120);
  }

  showList() {
    byId("opened").replaceChildren(...this.items.map((item) => this.row(item)));
    this.showCharacters();
  }

  showRow(item) {
    const row = byId("opened").children[this.items.indexOf(item)];
    const hadFocus = row?.contains(document.activeElement);
    const fresh = this.row(item);
    row?.replaceWith(fresh);
    if (hadFocus) fresh.querySelector(".item").focus();
  }

  row(item) {
    const { name, path, state, warnings, onto } = item;
    const said = { waiting: "waiting", ok: item.summary, error: `error: ${item.summary}` }[state];
    const warned = state === "ok" && warnings.length ? `, ${plural(warnings.length, "warning")}` : "";
    const row = make("li", { class: [state, warned && "has-warnings", item === this.chosen && "chosen"].filter(Boolean).join(" ") });
    row.append(make("button", { class: "item", "aria-current": item === this.chosen, title: onto ? name : path, onclick: () => this.show([item]) },
      make("span", {}, name), make("small", {}, `${said ?? ""}${warned}`)));
    const isBeside = this.shown.includes(item);
    if (state !== "error" && this.shown.length && !(isBeside && this.shown.length === 1)) {
      row.append(make("button", { class: "beside", "aria-pressed": isBeside, "aria-label": `${name} beside the others`, title: "Show beside the others", onclick: () => this.turnBeside(item) }, isBeside ? "✓" : "+"));
    }
    return row;
  }

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
    if (byId("details").hidden) return;
    const { name, state, error, warnings, answer } = item;
    byId("chosen-name").textContent = name;
    byId("chosen-facts").textContent = state === "error" ? "It could not be read." : this.facts(item);
    const findings = [...(error ? [[error, true]] : []), ...warnings.map((warning) => [warning, false])];
    byId("findings").hidden = !findings.length;
    byId("findings-title").textContent = [error && "1 error", warnings.length && plural(warnings.length, "warning")].filter(Boolean).join(", ");
    byId("finding-list").replaceChildren(...findings.map(([finding, isError]) => findingElement(finding, isError)));
    byId("tools").hidden = state !== "ok" || !answer;
    if (!byId("tools").hidden) this.showTools(item);
  }

  facts({ summary, answer }) {
    const report = answer?.retargeted;
    return report ? `${summary}; limbs ${report.mean_degrees.toFixed(1)}° off in the mean` : summary;
  }

  showTools(item) {
    const { read, change, answer, onto } = item;
    const reason = (topic) => {
      const found = answer.assumptions.find((assumption) => assumption.topic === topic);
      return found ? `${found.choice}: ${found.reason}${found.confidence ? ` (${found.confidence})` : ""}` : "";
    };
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
    // A motion on a character is cut and read as the motion is, before it is put on.
    byId("assumed").hidden = byId("trim").hidden = Boolean(onto);
    byId("trim").hidden ||= !item.frames;
    byId("trim-first").value = change.first?.frame ?? 0;
    byId("trim-last").value = change.last?.frame ?? Math.max(0, item.frames - 1);
    byId("trim-first").max = byId("trim-last").max = Math.max(0, item.frames - 1);
    byId("onto").hidden = Boolean(onto) || !answer.frames;
    byId("saved").textContent = "";
    this.showCharacters();
  }

  showCharacters() {
    const select = byId("character");
    const before = select.value;
    const items = this.items.filter((item) => item !== this.chosen && item.state === "ok" && !item.onto && item.format !== "c3d");
    // A file without motion is most likely a character.
    items.sort((a, b) => Number(Boolean(a.frames)) - Number(Boolean(b.frames)));
    select.replaceChildren(...items.map(({ id, name }) => make("option", { value: id }, name)), make("option", { value: "open" }, "open a file…"));
    if (items.some(({ id }) => String(id) === before)) select.value = before;
  }

  // The frame of the file at the tick that is shown.
  get fileFrame() {
    const { change, frames, answer } = this.chosen;
    const last = change.last?.frame ?? frames - 1;
    return Math.min(last, last + 1 - answer.frames + Math.round(this.player.tick));
  }

  trim(first, last) {
    const { frames } = this.chosen;
    const [from, to] = [first, last].map((frame) => Math.min(frames - 1, Math.max(0, Math.round(Number(frame) || 0))));
    if (to < from) return this.tell(`Not changed: the last frame, ${to}, is before the first, ${from}.`);
    return this.change(this.chosen, "change", { first: from > 0 ? { frame: from } : undefined, last: to < frames - 1 ? { frame: to } : undefined });
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
    onChange("root-offset", (policy) => this.change(this.chosen, "read", { rootOffset: policy === "auto" ? undefined : policy }));
    const bounds = () => [byId("trim-first").value, byId("trim-last").value];
    onChange("trim-first", () => this.trim(...bounds()));
    onChange("trim-last", () => this.trim(...bounds()));
    onClick("trim-first-here", () => this.trim(this.fileFrame, bounds()[1]));
    onClick("trim-last-here", () => this.trim(bounds()[0], this.fileFrame));
    onClick("trim-none", () => change({ first: undefined, last: undefined }));
    onClick("put-on", () => {
      const { value } = byId("character");
      const character = this.items.find(({ id }) => String(id) === value);
      if (character) this.putOn(this.chosen, character);
      else this.openCharacter();
    });
    for (const button of byId("save-row").children) button.addEventListener("click", () => this.save(button.dataset.format));
    onClick("stop", () => this.reader.stop());
    onClick("desk-button", () => this.showDesk(!byId("desk").classList.contains("open")));
    this.listenToFiles();
    document.addEventListener("keydown", (event) => {
      const by = { PageUp: -1, PageDown: 1 }[event.key];
      if (!by || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
      event.preventDefault();
      this.next(by);
    });
    document.querySelector(".keys").prepend(make("dt", {}, make("kbd", {}, "Page↑"), " ", make("kbd", {}, "Page↓")), make("dd", {}, "previous, next file"));
    // On a phone one panel is open at a time.
    onClick("panel-button", () => byId("panel").classList.contains("open") && this.showDesk(false));
  }

  showDesk(wanted) {
    byId("desk").classList.toggle("open", wanted);
    byId("desk-button").setAttribute("aria-expanded", wanted);
    if (wanted) this.player.showPanel(false);
  }

  // A file for the skeleton of a character: the motion stays what is shown.
  openCharacter() {
    const motion = this.chosen;
    const input = make("input", { type: "file" });
    input.addEventListener("change", () => {
      const [item] = itemsOf(chosenFiles(input)).items;
      if (item) this.putOn(motion, this.add(item));
    });
    input.click();
  }

  listenToFiles() {
    const inputs = { "open-files": "file-input", "start-open": "file-input", "open-folder": "folder-input" };
    for (const [button, input] of Object.entries(inputs)) byId(button).addEventListener("click", () => byId(input).click());
    for (const id of new Set(Object.values(inputs))) {
      byId(id).addEventListener("change", (event) => {
        this.open(chosenFiles(event.target));
        event.target.value = "";
      });
    }
    byId("open-folder").hidden = !("webkitdirectory" in byId("folder-input"));
    const onto = (type, act) => document.addEventListener(type, (event) => { event.preventDefault(); act(event); });
    onto("dragover", () => document.body.classList.add("dragging"));
    document.addEventListener("dragleave", (event) => event.relatedTarget || document.body.classList.remove("dragging"));
    onto("drop", async (event) => {
      document.body.classList.remove("dragging");
      try {
        this.open(await droppedFiles(event.dataTransfer));
      } catch (error) {
        this.tell(`What was dropped could not be read: ${error.message}; try the buttons instead.`);
      }
    });
  }
}
