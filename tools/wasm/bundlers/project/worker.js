// A worker that plays for its page.

import { play } from "./walk.js";

onmessage = async ({ data: { bytes, joint, frame } }) => {
  postMessage(await play(bytes, joint, frame).catch((error) => ({ error: `${error.message}: ${error.help ?? ""}` })));
};
