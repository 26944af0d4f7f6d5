// A page that plays in a worker.

async function start() {
  const { joint, frame } = Object.fromEntries(new URLSearchParams(location.search));
  const bytes = await (await fetch("/walk.bvh")).arrayBuffer();
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }) => { window.played = data; };
  worker.onerror = ({ message }) => { window.played = { error: message || "the worker did not start" }; };
  worker.postMessage({ bytes, joint, frame: Number(frame) });
}

start();
