// The page embedded in another page: <mocap-player> of the package sends files and settings, and receives events.

/** Milliseconds between two messages with the current time. */
const TIME_EVERY = 100;

const say = (message) => parent.postMessage(message, "*");

function set({ player }, { speed, loop, paused, theme }) {
  player.setSpeed(speed);
  if (theme === "light" || theme === "dark") player.setTheme(theme);
  if (!player.clip) return;
  player.toggle("loop", loop);
  player.play(!paused);
}

async function open(desk, files, settings) {
  desk.clear();
  await desk.open(files.map(({ name, bytes }) => ({ file: new File([bytes], name), path: name })));
  const failed = desk.items.find(({ state }) => state === "error");
  const { clips } = desk.player.state;
  if (failed || !desk.shown.length) {
    const { error } = failed ?? {};
    say({ mocap: "error", message: error?.reason ?? error?.message ?? document.getElementById("notice").textContent, ...error });
    return;
  }
  set(desk, settings);
  say({ mocap: "load", duration: desk.player.longest, clips: clips.map(({ name, seconds, frames }) => ({ name, seconds, frames })) });
}

export function listenToParent(desk) {
  if (location.hash !== "#embedded" || parent === window) return;
  document.body.classList.add("embedded");
  addEventListener("message", ({ source, data }) => {
    if (source !== parent || data?.mocap !== "do") return;
    if (data.open) open(desk, data.open, data.settings);
    else if (data.settings) set(desk, data.settings);
    if (data.seek !== undefined && desk.player.clip) desk.player.seekTime(data.seek);
  });
  let before;
  setInterval(() => {
    const { state, longest } = desk.player;
    const now = JSON.stringify([state.time, state.playing]);
    if (state.clips.length && now !== before) say({ mocap: "time", seconds: state.time, duration: longest, playing: state.playing });
    before = now;
  }, TIME_EVERY);
  say({ mocap: "ready" });
}
