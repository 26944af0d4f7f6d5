// Passes dropped and selected files to the desk.

import { byId } from "../../../src/render/view/dom.js";
import { chosenFiles, droppedFiles } from "./files.js";

/** The desk opens files that the user drops on the page or selects with its buttons. */
export function listenToFiles(desk) {
  const inputs = { "open-files": "file-input", "start-open": "file-input", "open-folder": "folder-input" };
  for (const [button, input] of Object.entries(inputs)) byId(button).addEventListener("click", () => byId(input).click());
  for (const id of new Set(Object.values(inputs))) {
    byId(id).addEventListener("change", (event) => {
      desk.open(chosenFiles(event.target));
      event.target.value = "";
    });
  }
  byId("start-walk").addEventListener("click", () => desk.openWalk());
  byId("open-folder").hidden = !("webkitdirectory" in byId("folder-input"));
  const onto = (type, act) => document.addEventListener(type, (event) => { event.preventDefault(); act(event); });
  onto("dragover", () => document.body.classList.add("dragging"));
  document.addEventListener("dragleave", (event) => event.relatedTarget || document.body.classList.remove("dragging"));
  onto("drop", async (event) => {
    document.body.classList.remove("dragging");
    const onFigure = event.target.closest?.("#view") && desk.shown.length === 1 ? desk.shown[0] : null;
    try {
      desk.open(await droppedFiles(event.dataTransfer), onFigure);
    } catch (error) {
      desk.tell(`The dropped files could not be read: ${error.message}; try the buttons instead.`);
    }
  });
}
