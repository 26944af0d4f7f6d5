// Files that are saved, and the job that makes them without the page.

import { byId, save } from "../../../src/render/view/dom.js";
import { copy } from "../../../src/render/view/drag.js";
import { commandOf, jobOf } from "./job.js";

const TYPES = { glb: "model/gltf-binary", vrma: "model/gltf-binary", bvh: "text/plain", csv: "text/csv", png: "image/png" };
/** Formats that may be written within an error. */
const WITHIN = new Set(["glb", "vrma", "fbx", "mclip"]);

export const stem = (name) => name.replace(/\.\w+$/, "");

export class Saving {
  // `acts`: chosen() is the item that is saved, ask(item, request) is a promise of the reader's answer.
  constructor(acts) {
    this.acts = acts;
    for (const button of byId("save-row").children) button.addEventListener("click", () => this.save(button.dataset.format));
    for (const [button, text] of [["job-copy", "job-text"], ["command-copy", "command-text"]]) {
      byId(button).addEventListener("click", () => copy(byId(text).textContent, byId(text)));
    }
  }

  async bytes(item, format) {
    const maxError = Number(byId("max-error").value);
    const options = maxError && WITHIN.has(format) ? { maxError } : {};
    const { bytes, warnings } = await this.acts.ask(item, { call: "save", name: stem(item.name), format, options });
    const notes = warnings.map(({ message }) => message).join("; ");
    byId("saved").textContent = `${format.toUpperCase()}: ${bytes.length.toLocaleString("en")} bytes${notes ? `; ${notes}` : ""}`;
    return bytes;
  }

  async save(format) {
    const item = this.acts.chosen();
    try {
      save(await this.bytes(item, format), `${stem(item.name)}.${format}`, TYPES[format] ?? "application/octet-stream");
    } catch (error) {
      byId("saved").textContent = `${format.toUpperCase()} was not written: ${error.reason ?? error.message}${error.help ? ` (${error.help})` : ""}`;
    }
  }

  show(item) {
    const output = `${stem(item.name)}.glb`;
    byId("saved").textContent = "";
    byId("job-text").textContent = JSON.stringify(jobOf(item, output), null, 2);
    byId("command-text").textContent = commandOf(item, output);
  }
}
