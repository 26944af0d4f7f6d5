// Lets the user select steps of `mocap edit`, apply them to the shown motion, and undo them.

import { byId, make } from "../../../src/render/view/dom.js";

/** The values of an option as text. */
const TAKES = {
  S: "seconds", M: "metres", "M/S": "metres a second", HZ: "hertz", DEGREES: "degrees", TIMES: "a factor", FRACTION: "0 to 1", N: "a number",
  "A..B": "from..to", "A+B+...": "frames, with +", "0..1 or S:0..1+...": "0 to 1", "[S:]M/M+...": "points x/z, with +", "S=S,...": "from=to",
  "M/M/M or NAME": "x/y/z or a joint", "M/M/M": "x/y/z", NAME: "a joint", "NAME+NAME+...": "joints, with +",
};
/** The number of report values per line. */
const NUMBERS_SHOWN = 3;

/** The values of a report as a line. */
function reportLine(report) {
  const numbers = Object.entries(report?.changed ?? report ?? {}).filter(([name, value]) => typeof value === "number" && name !== "with");
  return numbers.slice(0, NUMBERS_SHOWN).map(([name, value]) => `${name.replaceAll("_", " ")} ${Number(value.toPrecision(3))}`).join(", ");
}

export class Steps {
  // `acts`: known() is a promise of the package's steps, change(steps) applies other steps to the shown motion, and compare()
  // shows the motion with and without steps.
  constructor(acts) {
    this.acts = acts;
    byId("step-name").addEventListener("change", () => this.showKeys());
    byId("step-add").addEventListener("click", () => this.acts.change([...this.item.steps, this.text()]));
    byId("step-undo").addEventListener("click", () => this.acts.change(this.item.steps.slice(0, -1)));
    byId("step-before").addEventListener("click", () => this.acts.compare());
    // Request the list when it is first visible.
    byId("steps").addEventListener("toggle", () => byId("steps").open && this.load());
  }

  async load() {
    if (this.known) return;
    // Skip steps with a second motion, because the page has only one.
    this.known = (await this.acts.known()).filter(({ takesOther }) => !takesOther);
    byId("step-name").replaceChildren(...this.known.map(({ name }) => make("option", { value: name }, name)));
    this.showKeys();
  }

  get step() { return this.known?.find(({ name }) => name === byId("step-name").value); }

  showKeys() {
    const { step } = this;
    if (!step) return;
    byId("step-help").textContent = `To ${step.help}. Empty fields mean the defaults.`;
    byId("step-keys").replaceChildren(...step.keys.map(({ name, takes, words }) => {
      const id = `step-key-${name}`;
      const options = words ?? (takes === "true|false" ? ["true", "false"] : null);
      const control = options
        ? make("select", { id, name }, make("option", { value: "" }, "as usual"), ...options.map((word) => make("option", { value: word }, word)))
        : make("input", { id, name, placeholder: TAKES[takes] ?? takes, autocomplete: "off", spellcheck: "false" });
      return make("div", { class: "choice" }, make("label", { for: id }, name.replaceAll("-", " ")), control);
    }));
  }

  /** The step in the form of the command line. */
  text() {
    const controls = Array.from(byId("step-keys").querySelectorAll("input, select")).filter(({ value }) => value.trim());
    const { step } = this;
    const isBare = (name) => step.keys.find((key) => key.name === name).takes === "S=S,...";
    const parts = controls.map(({ name, value }) => (isBare(name) ? value.trim() : `${name}=${value.trim()}`));
    return parts.length ? `${step.name}:${parts.join(",")}` : step.name;
  }

  show(item) {
    this.item = item;
    const reports = item.answer?.edits ?? [];
    byId("step-list").replaceChildren(...item.steps.map((step, index) => make("li", {}, step, make("small", {}, reportLine(reports[index])))));
    byId("step-undo").disabled = byId("step-before").disabled = !item.steps.length;
  }
}
