// Where a page begins: its clips, and a player that shows them.

import { byId } from "./dom.js";
import { Player } from "./player.js";
import { unpacked } from "./unpack.js";

const clips = JSON.parse(byId("page-data").textContent).clips.map(unpacked);
const player = new Player();
player.show(clips);

// Between pictures, until every block is loaded, so that a jump to any frame is quick.
function loadMore() {
  if (clips.some((clip) => clip.loadNext())) setTimeout(loadMore, 4);
}
requestAnimationFrame(() => setTimeout(loadMore));

// For tests, and for a console.
window.mocap = player.handle;
