// The entry point of the drop page: the reader, a player without clips, and the desk that connects them.

import { byId } from "../../../src/render/view/dom.js";
import { Player } from "../../../src/render/view/player.js";
import { Desk } from "./desk.js";
import { listenToParent } from "./embed.js";
import { OwnPage } from "./own_page.js";
import { Reader } from "./reader.js";

const ownPage = new OwnPage();
const player = new Player();
const reader = new Reader({
  script: byId("worker").textContent,
  wasm: Promise.resolve(ownPage.wasm),
  progress: (...stage) => desk.showProgress(...stage),
  restarted: (error) => desk.tellRestart(error),
});
const desk = new Desk(player, reader, ownPage);

// For tests and the console.
Object.defineProperty(window, "mocap", { get: () => player.handle });
window.desk = desk;
listenToParent(desk);
if (ownPage.session) desk.restore();
