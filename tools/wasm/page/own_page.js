// Saves this page with the open items, so that another person can open the file and continue.

import { takeText } from "../../../src/render/view/unpack.js";
import { fromBase128, toBase128 } from "./base128.js";

const piped = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

const dataElement = (type, id, text) => `<script type="${type}" id="${id}">${text}<\/script>`;

/** The properties of an item that do not come from its files. */
const keptOf = ({ path, name, names, read, change, steps, retarget, isBefore }) => ({ path, name, names, read, change, steps, retarget, isBefore });

export class OwnPage {
  /** Call this before anything changes the page. `wasm` are the bytes of the module. */
  constructor() {
    this.wasm = fromBase128(takeText("wasm"));
    this.walk = takeText("walk");
    this.session = this.taken();
    this.html = `<!doctype html>\n${document.documentElement.outerHTML}`;
  }

  /** Takes the saved data out of this page. */
  taken() {
    const found = document.getElementById("session");
    if (!found) return null;
    const session = JSON.parse(found.textContent);
    for (const [index, file] of session.files.entries()) {
      file.text = takeText(`file-${index}`);
      document.getElementById(`file-${index}`).remove();
    }
    found.remove();
    return session;
  }

  /** The walk that an empty page offers. */
  get walkBytes() { return fromBase128(this.walk); }

  /** The items saved in this page, with their files and the index of each character, and the shown items. */
  async opened() {
    const { session } = this;
    const files = [];
    for (const { name, text, lastModified } of session.files) {
      files.push(new File([await piped(fromBase128(text), new DecompressionStream("gzip"))], name, { lastModified }));
    }
    // Release the texts, which may have megabytes.
    session.files = [];
    return session.items.map((item) => ({ ...item, files: item.files.map((index) => files[index]) }));
  }

  /** Makes a page with the shown items first, then their characters. */
  async with(shown) {
    const items = [...new Set([...shown, ...shown.flatMap(({ onto, from }) => [from, onto].filter(Boolean))])];
    const files = [...new Set(items.flatMap((item) => item.files))];
    const place = (item) => (item ? items.indexOf(item) : undefined);
    const session = {
      shown: shown.length,
      items: items.map((item) => ({ ...keptOf(item), files: item.files.map((file) => files.indexOf(file)), onto: place(item.onto), from: place(item.from) })),
      files: files.map(({ name, lastModified }) => ({ name, lastModified })),
    };
    const parts = [dataElement("application/json", "session", JSON.stringify(session).replaceAll("<", "\\u003c"))];
    for (const [index, file] of files.entries()) {
      const packed = await piped(await file.arrayBuffer(), new CompressionStream("gzip"));
      parts.push(dataElement("application/octet-stream", `file-${index}`, toBase128(packed)));
    }
    const texts = { wasm: toBase128(this.wasm), walk: this.walk };
    const html = this.html.replace(/(<script [^>]*id="(wasm|walk)">)(<\/script>)/g, (_, start, id, end) => `${start}${texts[id]}${end}`);
    // Insert after the last data element, before the script.
    const [before, after] = splitAfter(html, /<script [^>]*id="walk">[^<]*<\/script>/);
    return new Blob([before, ...parts, after], { type: "text/html" });
  }
}

function splitAfter(text, pattern) {
  const { 0: found, index } = pattern.exec(text);
  return [text.slice(0, index + found.length), text.slice(index + found.length)];
}
