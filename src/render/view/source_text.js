// The text of a BVH file: finds the lines and motion columns that define a matrix.

const ROTATIONS = /rotation$/i;

export class SourceText {
  constructor(bytes) {
    this.lines = new TextDecoder().decode(bytes).split(/\r\n?|\n/);
    const frameTime = this.lines.findIndex((line) => /^\s*Frame Time:/i.test(line));
    this.hierarchyEnd = this.lines.findIndex((line) => /^\s*MOTION\b/i.test(line));
    // The line indices of the motion rows, from 0.
    this.rows = [];
    if (frameTime >= 0) this.lines.forEach((line, at) => { if (at > frameTime && line.trim()) this.rows.push(at); });
  }

  // The words after CHANNELS and the channel count, in a line counted from 1.
  channels(line) {
    const [count, ...names] = (this.lines[line - 1] ?? "").split(/\bCHANNELS\b/i).at(1)?.trim().split(/\s+/) ?? [0];
    return names.slice(0, Number(count) || 0);
  }

  // The motion columns that define a matrix of a joint, from 0, and the number of all columns.
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

  // The written numbers of a motion row, and its line from 1; null if the row has another number of columns.
  row(number, columns) {
    const line = this.rows[number];
    const words = line === undefined ? [] : this.lines[line].trim().split(/\s+/);
    return words.length === columns ? { line: line + 1, words } : null;
  }
}

// The lines of the file, from 1, that define a matrix. An L comes from the OFFSET or position channels, a J from the
// channels.
export function matrixLines(node, { letter, index }) {
  const { name, offset, channels } = node.lines ?? {};
  const isMoved = letter === "L" && node.moves;
  const wanted = letter === "J" ? [channels ?? offset, index === 0 ? offset : null] : [isMoved ? channels : offset];
  return { name, lines: wanted.filter(Boolean) };
}
