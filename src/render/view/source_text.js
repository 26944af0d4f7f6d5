// The text of a BVH file: which lines and which columns of its motion a matrix comes from.

const ROTATIONS = /rotation$/i;

export class SourceText {
  constructor(bytes) {
    this.lines = new TextDecoder().decode(bytes).split(/\r\n?|\n/);
    const frameTime = this.lines.findIndex((line) => /^\s*Frame Time:/i.test(line));
    this.hierarchyEnd = this.lines.findIndex((line) => /^\s*MOTION\b/i.test(line));
    // The lines of the rows, from 0.
    this.rows = [];
    if (frameTime >= 0) this.lines.forEach((line, at) => { if (at > frameTime && line.trim()) this.rows.push(at); });
  }

  // The words after CHANNELS and their number, in a line of the file counted from 1.
  channels(line) {
    const [count, ...names] = (this.lines[line - 1] ?? "").split(/\bCHANNELS\b/i).at(1)?.trim().split(/\s+/) ?? [0];
    return names.slice(0, Number(count) || 0);
  }

  // The columns of the motion that a matrix of a joint comes from, from 0, and how many there are.
  columns(nodes, { letter, index, id }) {
    let [first, all] = [0, 0];
    let own = [];
    nodes.forEach(({ lines }, node) => {
      const names = lines?.channels ? this.channels(lines.channels) : [];
      if (node === id) [first, own] = [all, names];
      all += names.length;
    });
    const isWanted = (name) => (index === 0 ? true : ROTATIONS.test(name) === (letter === "J"));
    return { all, marked: own.flatMap((name, i) => (isWanted(name) ? [first + i] : [])), names: own.filter(isWanted) };
  }

  // The numbers of a row of the motion as they are written, and the line, from 1; null where the file has them otherwise.
  row(number, columns) {
    const line = this.rows[number];
    const words = line === undefined ? [] : this.lines[line].trim().split(/\s+/);
    return words.length === columns ? { line: line + 1, words } : null;
  }
}

// The lines of the file, from 1, that say a matrix: of an L the OFFSET, or position channels; of a J the channels.
export function matrixLines(node, { letter, index }) {
  const { name, offset, channels } = node.lines ?? {};
  const isMoved = letter === "L" && node.moves;
  const wanted = letter === "J" ? [channels ?? offset, index === 0 ? offset : null] : [isMoved ? channels : offset];
  return { name, lines: wanted.filter(Boolean) };
}
