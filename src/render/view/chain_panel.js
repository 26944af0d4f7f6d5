// Shows the chain of the selected joint, T = J0 L1 J1 L2 ... The user multiplies its matrices one by one. The panel
// also shows the lines of the file that define the last matrix.

import { byId, make, short } from "./dom.js";
import { transformPoint } from "./math.js";
import { chainMatrices } from "./product.js";
import { SourceText, matrixLines } from "./source_text.js";

const AXIS_LETTERS = ["X", "Y", "Z"];
// The number of lines shown before and after the marked lines.
const AROUND = 8;

const subscript = (letter, index) => make("span", {}, letter, make("sub", {}, String(index)));
const angleText = (clip, id) => {
  const angles = clip.angles(id);
  return clip.nodes[id].order.map((axis, i) => `${AXIS_LETTERS[axis]}\u00a0${short(angles[i])}°`).join("  ");
};

export class ChainPanel {
  // `state.grown` is the number of multiplied matrices. 0 shows the whole product, without the intermediate frames.
  constructor(state, { choose, changed }) {
    Object.assign(this, { state, choose, changed, texts: new Map() });
    byId("chain-more").addEventListener("click", () => this.grow(1));
    byId("chain-fewer").addEventListener("click", () => this.grow(-1));
    byId("point").addEventListener("input", () => this.showPoint());
  }

  get clip() { return this.state.clips[this.state.active]; }

  // Called when the user selects another joint.
  show() {
    const { clip, state } = this;
    state.grown = 0;
    this.parts = chainMatrices(clip, state.joint);
    this.symbols = this.parts.map(({ letter, index }) => subscript(letter, index));
    byId("chain-product").replaceChildren("T = ", ...this.symbols.flatMap((symbol) => [symbol, " "]));
    this.outputs = this.parts.map(() => make("output", {}));
    this.rows = this.parts.map((part, i) => {
      const { letter, index, id } = part;
      const node = clip.nodes[id];
      const [what, position] = [node.moves ? "position channels" : "OFFSET", index > 0 ? "rotation channels" : "position and rotation"];
      const name = make("button", { class: "link", onclick: () => this.choose(state.active, id) }, node.name);
      const symbol = make("button", { class: "link", title: "Multiply up to here", onclick: () => this.growTo(i + 1) }, subscript(letter, index));
      return make("tr", {}, make("th", { scope: "row" }, symbol), make("td", {}, name, make("small", {}, letter === "L" ? what : position)),
        make("td", { class: "line" }, String(matrixLines(node, part).lines[0] ?? "")), make("td", {}, this.outputs[i]));
    });
    byId("chain").replaceChildren(...this.rows);
    this.showGrown();
  }

  // Multiplies one matrix more or fewer. Past either end, shows the whole product.
  grow(by) {
    if (this.state.joint < 0) return;
    const count = this.parts.length + 1;
    this.growTo((this.state.grown + by + count) % count);
  }

  growTo(grown) {
    this.state.grown = grown;
    this.showGrown();
    this.changed();
  }

  get last() { return (this.state.grown || this.parts.length) - 1; }

  showGrown() {
    const { grown } = this.state;
    this.symbols.forEach((symbol, i) => symbol.classList.toggle("later", grown > 0 && i >= grown));
    this.rows.forEach((row, i) => {
      row.classList.toggle("later", grown > 0 && i >= grown);
      row.classList.toggle("marked", grown > 0 && i === grown - 1);
    });
    byId("chain-grown").textContent = grown ? `${grown} of ${this.parts.length} matrices` : "the whole product";
    this.showTick();
    this.showLines();
  }

  // Updates the values at the current tick.
  showTick() {
    const { clip } = this;
    this.parts = chainMatrices(clip, this.state.joint);
    this.parts.forEach(({ letter, index, id, matrix }, i) => {
      const moved = matrix.slice(12, 15).map(short).join("  ");
      this.outputs[i].textContent = letter === "L" ? moved : index > 0 ? angleText(clip, id) : `${moved}  ·  ${angleText(clip, id)}`;
    });
    const { product } = this.parts[this.last];
    byId("matrix").textContent = [0, 1, 2].map((r) => [0, 1, 2, 3].map((c) => short(product[4 * c + r]).padStart(8)).join("")).join("\n");
    this.showPoint();
    this.showRow();
  }

  // Shows a point of the joint's frame, transformed by the matrices multiplied so far.
  showPoint() {
    if (this.state.joint < 0) return;
    const words = byId("point").value.replaceAll("−", "-").split(/[\s,]+/).filter(Boolean);
    const point = words.map(Number);
    const isPoint = point.length === 3 && point.every(Number.isFinite);
    byId("point").setAttribute("aria-invalid", String(words.length > 0 && !isPoint));
    byId("point-in-world").textContent = isPoint ? `T p = ${transformPoint(this.parts[this.last].product, point).map(short).join("  ")}`
      : words.length ? "expected three numbers: x, y, z" : "";
  }

  get text() {
    const { clip, texts } = this;
    if (!texts.has(clip)) texts.set(clip, clip.source ? new SourceText(clip.source.bytes()) : null);
    return texts.get(clip);
  }

  // Shows the lines of the HIERARCHY around the lines of the last matrix.
  showLines() {
    const { text, clip } = this;
    const part = this.parts[this.last];
    const { name, lines } = matrixLines(clip.nodes[part.id], part);
    byId("file-lines").hidden = !text || !lines.length;
    if (byId("file-lines").hidden) return;
    const marked = new Set(lines);
    const first = Math.max(1, Math.min(name, ...lines) - AROUND);
    const end = text.hierarchyEnd < 0 ? text.lines.length : text.hierarchyEnd;
    const last = Math.min(end, Math.max(...lines) + AROUND);
    const shown = Array.from({ length: last - first + 1 }, (_, i) => first + i);
    byId("hierarchy").replaceChildren(...shown.map((number) => {
      const line = `${String(number).padStart(String(last).length)}  ${text.lines[number - 1]}`;
      return make(marked.has(number) ? "mark" : "span", {}, `${line}\n`);
    }));
    const mark = byId("hierarchy").querySelector("mark");
    byId("hierarchy").scrollTop = mark.offsetTop - byId("hierarchy").offsetTop - byId("hierarchy").clientHeight / 2;
    this.rowShown = null;
    this.showRow();
  }

  // Shows the row of the MOTION at this tick, with the columns of the last matrix.
  showRow() {
    if (byId("file-lines").hidden) return;
    const { clip, text } = this;
    const part = this.parts[this.last];
    // If a step changed the clip, the rows of the file do not describe the clip.
    const { all, marked, names } = clip.file ? text.columns(clip.nodes, part) : { marked: [] };
    const row = marked.length ? text.row(Math.floor(clip.tick), all) : null;
    byId("motion-row").hidden = byId("motion-title").hidden = !row;
    if (!row || this.rowShown === row.line) return;
    this.rowShown = row.line;
    byId("motion-title").textContent = `MOTION, line ${row.line}: ${names.join(" ")}, column${marked.length > 1 ? "s" : ""} ${marked.map((column) => column + 1).join(" ")}`;
    byId("motion-row").replaceChildren(...row.words.flatMap((word, column) => [marked.includes(column) ? make("mark", {}, word) : word, " "]));
    const mark = byId("motion-row").querySelector("mark");
    byId("motion-row").scrollLeft = mark.offsetLeft - byId("motion-row").offsetLeft - byId("motion-row").clientWidth / 3;
  }
}
