// A page. `window.played` gets the result or the error.

import { play } from "./walk.js";

async function start() {
  const { joint, frame } = Object.fromEntries(new URLSearchParams(location.search));
  return play(await (await fetch("/walk.bvh")).arrayBuffer(), joint, Number(frame));
}

start().then((played) => { window.played = played; }, (error) => { window.played = { error: `${error.message}: ${error.help ?? ""}` }; });
