// Saves files, and shows the job that makes them without the page.

import { byId, save } from "../../../src/render/view/dom.js";
import { copy } from "../../../src/render/view/drag.js";
import { zipOf } from "./archive.js";
import { npzOfRobot } from "./arrays.js";
import { commandOf, jobOf } from "./job.js";
import { plural } from "./opened.js";

const TYPES = { glb: "model/gltf-binary", vrma: "model/gltf-binary", bvh: "text/plain", csv: "text/csv", png: "image/png" };
/** Formats with an error bound. */
const WITHIN = new Set(["glb", "vrma", "fbx", "mclip"]);

/** The size of a motion above which a saved page packs it, in bytes, and the error bound in metres. */
const LARGE_FILE = 16e6;
const PAGE_ERROR = 1e-4;

export const stem = (name) => name.replace(/\.\w+$/, "");

export class Saving {
  // `acts`: chosen() is the item that is saved, all() are the items that can be saved, shown() are the items in the
  // picture; ask(item, request) is a promise of the reader's answer, page(items) of this page with them; film() asks
  // for a picture or a film.
  constructor(acts) {
    this.acts = acts;
    for (const button of byId("save-row").querySelectorAll("[data-format]")) {
      button.addEventListener("click", () => (byId("save-all").checked ? this.saveAll(button.dataset.format) : this.save(button.dataset.format)));
    }
    byId("save-page").addEventListener("click", () => this.savePage());
    byId("save-film").addEventListener("click", () => this.acts.film());
    for (const [button, text] of [["job-copy", "job-text"], ["command-copy", "command-text"]]) {
      byId(button).addEventListener("click", () => copy(byId(text).textContent, byId(text)));
    }
  }

  async bytes(item, format) {
    if (format === "npz") return new Uint8Array(await npzOfRobot(await this.acts.ask(item, { call: "robotMotion" })).arrayBuffer());
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

  // Saves all motions in one archive. Motions that cannot be written are named, and the others are saved.
  async saveAll(format) {
    const items = this.acts.all();
    const [files, failed] = [[], []];
    for (const item of items) {
      try {
        files.push({ name: `${stem(item.name)}.${format}`, bytes: await this.bytes(item, format) });
      } catch (error) {
        if (error.code === "stopped") return;
        failed.push(`${item.name}: ${error.reason ?? error.message}`);
      }
      byId("saved").textContent = `${files.length + failed.length} of ${items.length}`;
    }
    try {
      if (files.length) save(zipOf(files), `motions_${format}.zip`, "application/zip");
      byId("saved").textContent = [`${plural(files.length, "file")} in one archive`, ...failed.map((text) => `not written, ${text}`)].join("; ");
    } catch (error) {
      byId("saved").textContent = `The archive could not be saved: ${error.message}.`;
    }
  }

  async savePage() {
    try {
      const shown = this.acts.shown();
      const items = [];
      for (const item of shown) items.push(await this.forPage(item));
      const page = await this.acts.page(items);
      save(page, `${stem(this.acts.chosen().name)}.html`, "text/html");
      const packed = items.some((item, index) => item !== shown[index]) ? `, packed within ${1000 * PAGE_ERROR} mm` : "";
      byId("saved").textContent = `A page of ${(page.size / 1e6).toFixed(1)} MB with the motion${packed}. Any browser can open it.`;
    } catch (error) {
      byId("saved").textContent = `The page could not be saved: ${error.reason ?? error.message}`;
    }
  }

  // The files in a saved page: the original files, or for a long motion a packed clip, a tenth of the size.
  async forPage(item) {
    const size = item.files.reduce((sum, file) => sum + file.size, 0);
    if (item.onto || item.hasSkin || size <= LARGE_FILE) return item;
    const name = `${stem(item.name)}.mclip`;
    const { bytes } = await this.acts.ask(item, { call: "save", name: stem(item.name), format: "mclip", options: { maxError: PAGE_ERROR } });
    return { ...item, path: name, name, files: [new File([bytes], name)], names: [name], read: {}, change: {}, steps: [], from: undefined };
  }

  show(item) {
    // Only robots have arrays. A robot has no bones for a VRM animation.
    const isRobot = Boolean(item.answer?.robot);
    for (const format of ["npz", "pkl"]) byId("save-row").querySelector(`[data-format=${format}]`).hidden = !isRobot;
    const { length } = this.acts.all();
    byId("save-all-choice").hidden = length < 2;
    byId("save-all").checked &&= length > 1;
    byId("save-all-text").textContent = `all ${length} motions, in one archive`;
    const output = `${stem(item.name)}.glb`;
    byId("saved").textContent = "";
    byId("job-text").textContent = JSON.stringify(jobOf(item, output), null, 2);
    byId("command-text").textContent = commandOf(item, output);
  }
}
