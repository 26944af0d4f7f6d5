// The open items, without duplicates, and their rows.

import { byId, make } from "../../../src/render/view/dom.js";

export const plural = (count, one) => `${count} ${one}${count === 1 ? "" : "s"}`;
const rounded = (value) => Number(value.toFixed(2));

/** The fewest joints of a human skeleton. */
const FEWEST_OF_A_PERSON = 15;

/** Whether a file is a figure without a motion, to which motions can be retargeted. */
export const isCharacter = ({ state, frames, joints, onto, format }) =>
  state === "ok" && !frames && !onto && format !== "c3d" && (joints >= FEWEST_OF_A_PERSON || isRobotFormat(format));

/** Whether the format is a robot's. Motions can also be retargeted to robots. */
export const isRobotFormat = (format) => format === "urdf" || format === "mjcf";

/** A summary of a file in a list. */
export function summaryOf({ frames, ticksPerSecond, joints, clips, format }) {
  if (!frames && isRobotFormat(format)) return `a robot, ${plural(joints, "link")}`;
  if (!frames) return joints < FEWEST_OF_A_PERSON ? `no motion, ${plural(joints, "joint")}` : `a character, ${plural(joints, "joint")}`;
  const others = clips?.length > 1 ? `${plural(clips.length, "clip")}, ` : "";
  return `${others}${rounded((frames - 1) / ticksPerSecond)} s, ${plural(frames, "frame")}, ${plural(joints, "joint")}`;
}

/** The identity of an open file. */
const signature = ({ path, files }) => JSON.stringify([path, ...files.map(({ name, size, lastModified }) => [name, size, lastModified])]);

export class Opened {
  // `acts` are called with an item: show, turnBeside, remove.
  constructor(acts) {
    this.acts = acts;
    this.items = [];
    this.last = 0;
  }

  // Adds an item, or returns the equal open item.
  add(item) {
    const mark = item.onto ? null : item.mark ?? signature(item);
    const known = mark && this.items.find((other) => other.mark === mark);
    if (known) return known;
    const added = { onto: null, read: {}, change: {}, steps: [], retarget: { feet: "lock" }, state: "waiting", warnings: [], id: ++this.last, ...item, mark };
    this.items.push(added);
    return added;
  }

  remove(item) {
    this.items = this.items.filter((other) => other !== item);
  }

  show(chosen, shown) {
    Object.assign(this, { chosen, shown });
    byId("opened").replaceChildren(...this.items.map((item) => this.row(item)));
    byId("remove-all").hidden = this.items.length < 2;
    this.reveal();
  }

  // Scrolls to the row of the selected item.
  reveal() {
    byId("opened").children[this.items.indexOf(this.chosen)]?.scrollIntoView({ block: "nearest" });
  }

  showRow(item, chosen, shown) {
    Object.assign(this, { chosen, shown });
    const row = byId("opened").children[this.items.indexOf(item)];
    const hadFocus = row?.contains(document.activeElement);
    const fresh = this.row(item);
    row?.replaceWith(fresh);
    if (hadFocus) fresh.querySelector(".item").focus();
    if (item === chosen) this.reveal();
  }

  row(item) {
    const { name, path, state, warnings, onto } = item;
    const { acts, shown } = this;
    const said = { waiting: "waiting", stopped: "stopped; press to read it again", ok: item.summary, error: `error: ${item.summary}` }[state];
    const warned = state === "ok" && warnings.length ? `, ${plural(warnings.length, "warning")}` : "";
    const row = make("li", { class: [state, warned && "has-warnings", item === this.chosen && "chosen"].filter(Boolean).join(" ") });
    row.append(make("button", { class: "item", "aria-current": item === this.chosen, title: onto ? name : path, onclick: () => acts.show(item) },
      make("span", {}, name), make("small", {}, `${said ?? ""}${warned}`)));
    const isBeside = shown.includes(item);
    if (state === "ok" && shown.length && !(isBeside && shown.length === 1)) {
      row.append(make("button", { class: "beside", "aria-pressed": isBeside, "aria-label": `${name} beside the others`, title: "Show beside the others", onclick: () => acts.turnBeside(item) }, isBeside ? "✓" : "+"));
    }
    row.append(make("button", { class: "remove", "aria-label": `Remove ${name} from the list`, title: "Remove from the list", onclick: () => acts.remove(item) }, "×"));
    return row;
  }
}

/**
 * The motion and the character to combine: a motion with the only character among the dropped files. If the files were dropped
 * on a figure, the figure is a candidate too.
 */
export function pairOf(added, onFigure) {
  const isMotion = (item) => item.state === "ok" && item.frames > 0;
  const characters = added.filter(isCharacter);
  const motions = added.filter((item) => isMotion(item) && !item.onto);
  if (characters.length === 1 && motions.length > 0) return { motion: motions[0], character: characters[0] };
  if (!onFigure || added.length === 0) return null;
  if (characters.length === 1 && isMotion(onFigure)) {
    // If the figure shows a retargeted motion, use the source motion.
    return { motion: onFigure.from ?? onFigure, character: characters[0] };
  }
  const body = onFigure.onto ?? onFigure;
  const hasBody = isCharacter(onFigure) || onFigure.onto || onFigure.hasSkin;
  return hasBody && motions.length > 0 ? { motion: motions[0], character: body } : null;
}
