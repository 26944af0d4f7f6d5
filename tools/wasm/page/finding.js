// Shows a problem of a file with its location, as a list element.

import { make } from "../../../src/render/view/dom.js";

/** A line of a file with a mark below the wrong part. A long line is cut to the text around this part. */
function marked({ text, column = 1, length = 1 }) {
  const [before, most] = [24, 120];
  const characters = Array.from(text);
  const from = column > 60 ? column - 1 - before : 0;
  const line = characters.slice(from, from + most).map((character) => (character === "\t" ? " " : character));
  const [start, end] = [from > 0 ? "…" : "", from + most < characters.length ? "…" : ""];
  const mark = "^".repeat(Math.max(1, Math.min(length, line.length - (column - 1 - from))));
  return `${start}${line.join("")}${end}\n${" ".repeat(start.length + Math.max(0, column - 1 - from))}${mark}`;
}

/** Makes an element of a diagnostic of the package. */
export function findingElement(finding, isError) {
  const { code, file, line, column, text, joint, pointer, expected, found, help, count } = finding;
  const message = finding.reason ?? finding.message;
  const place = [file, line && `line ${line}`, line && column && `column ${column}`, pointer, code].filter(Boolean).join(", ");
  const element = make("li", { class: isError ? "is-error" : "is-warning" }, make("b", {}, message), make("span", { class: "place" }, place));
  if (text) element.append(make("pre", { role: "group", tabindex: 0, "aria-label": "The line of the file" }, marked(finding)));
  const more = { joint, expected, found, help, "in all": count > 1 ? `${count} times` : undefined };
  for (const [name, value] of Object.entries(more)) {
    if (value !== undefined && value !== null && value !== "") element.append(make("div", {}, `${name}: ${value}`));
  }
  return element;
}
