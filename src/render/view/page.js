// The entry point of a page: passes its clips to a player.

import { byId } from "./dom.js";
import { Player } from "./player.js";
import { Blocks, loadAll, takeBytes, unpacked } from "./unpack.js";

const blocks = new Blocks(takeBytes);
const clips = JSON.parse(byId("page-data").textContent).clips.map((clip) => unpacked(clip, blocks));
const player = new Player();
player.show(clips);

loadAll(clips);

// For tests and the console.
window.mocap = player.handle;
