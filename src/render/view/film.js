// Saves the current picture, or a film of the motion. Each picture of a film is drawn separately, so that slow machines
// skip none.

import { byId, save } from "./dom.js";
import { Gif, paletteOf } from "./gif.js";
import { mp4Of } from "./mp4.js";
import { webmOf } from "./webm.js";

// The codecs to try for each file extension: the browser's name, and WebM's name. The levels allow large pictures.
const CODECS = { mp4: [["avc1.640034"], ["avc1.42003d"]], webm: [["vp09.00.51.08", "V_VP9"], ["vp8", "V_VP8"]] };
// Bits per pixel of each picture of a film.
const BITS = 0.2;
// Seconds between key frames.
const KEY_EVERY = 2;
// The largest number of pictures in the encoder's queue.
const WAITING = 8;
const GIF_RATE = 20;
// The largest side of a GIF, in pixels.
const GIF_SIZE = 640;
// The number of pictures from which a GIF's palette is computed.
const PALETTE_PICTURES = 6;
// Milliseconds after which the page must handle events.
const PATIENCE = 40;

const pause = () => new Promise((done) => setTimeout(done));
const even = (size) => Math.max(2, 2 * Math.round(size / 2));

// The encoder settings for a film of this size, or null if the browser cannot encode it.
async function encodingOf(extension, { width, height, rate }) {
  for (const [codec, name] of globalThis.VideoEncoder ? CODECS[extension] : []) {
    const config = { codec, width, height, framerate: rate, bitrate: Math.round(BITS * width * height * rate) };
    const { supported } = await VideoEncoder.isConfigSupported(config).catch(() => ({}));
    if (supported) return { config, name };
  }
  return null;
}

export class Film {
  constructor(player) {
    this.player = player;
    byId("film-save").addEventListener("click", () => (this.working ? this.stop() : this.make()));
    byId("film-kind").addEventListener("change", () => this.showChoices());
    byId("film-dialog").addEventListener("close", () => this.stop());
  }

  async open() {
    const kinds = byId("film-kind");
    for (const extension of Object.keys(CODECS)) {
      const option = kinds.querySelector(`[value=${extension}]`);
      option.disabled = !(await encodingOf(extension, { width: 1280, height: 720, rate: 30 }));
    }
    if (kinds.selectedOptions[0].disabled) kinds.value = kinds.querySelector("option:not(:disabled)").value;
    this.showChoices();
    byId("film-dialog").showModal();
  }

  stop() { this.isStopped = true; }

  showChoices() {
    const kind = byId("film-kind").value;
    byId("film-rate-choice").hidden = !(kind in CODECS);
    byId("film-said").textContent = kind === "png" ? "The current picture." : `${this.range.map((seconds) => seconds.toFixed(2)).join(" to ")} s, the visible part of the time line, at ${this.player.state.speed}×.`;
  }

  get range() {
    const [from, to] = this.player.line.range;
    return [Math.max(from, this.player.start), to];
  }

  // Width and height of the picture: the selected size, or the size of the canvas.
  get size() {
    const { canvas } = this.player;
    const chosen = byId("film-size").value;
    return chosen ? chosen.split("x").map(Number) : [canvas.width, canvas.height].map(even);
  }

  async make() {
    const { player } = this;
    const { state, stage } = player;
    const before = { time: state.time, playing: state.playing };
    player.play(false);
    this.working = true;
    this.isStopped = false;
    byId("film-save").textContent = "Stop";
    byId("film-bar").hidden = false;
    const { camera } = stage;
    const look = { target: camera.target, yaw: camera.yaw, pitch: camera.pitch, distance: camera.distance };
    try {
      const kind = byId("film-kind").value;
      const made = await { png: () => this.picture(), gif: () => this.gif(), mp4: () => this.film("mp4"), webm: () => this.film("webm") }[kind]();
      if (made) {
        save(made, `${player.clip.name.replace(/\.\w+$/, "")}.${kind}`, made.type);
        byId("film-said").textContent = `${(made.size / 1e6).toFixed(2)} MB saved.`;
      } else {
        byId("film-said").textContent = "Stopped.";
      }
    } catch (error) {
      byId("film-said").textContent = `Saving failed: ${error.message}.`;
    }
    stage.size = null;
    this.working = false;
    byId("film-save").textContent = "Save";
    byId("film-bar").hidden = true;
    state.time = before.time;
    stage.draw();
    Object.assign(camera, look);
    stage.before = null;
    player.play(before.playing);
  }

  async picture() {
    const { stage, canvas } = this.player;
    stage.size = this.size;
    stage.draw();
    return new Promise((done) => canvas.toBlob(done, "image/png"));
  }

  // Draws the pictures of the film and calls `take` for each. Returns whether the film is complete.
  async each(rate, take) {
    const { state, stage } = this.player;
    const [from, to] = this.range;
    const count = Math.floor(((to - from) / state.speed) * rate + 1e-6) + 1;
    let since = performance.now();
    for (let at = 0; at < count; at++) {
      state.time = Math.min(to, from + (at * state.speed) / rate);
      stage.draw();
      await take(at, count);
      byId("film-bar").value = (at + 1) / count;
      if (performance.now() - since > PATIENCE) {
        await pause();
        since = performance.now();
      }
      if (this.isStopped) return false;
    }
    return true;
  }

  async film(extension) {
    const { stage, canvas } = this.player;
    const rate = Number(byId("film-rate").value);
    const [width, height] = this.size.map(even);
    stage.size = [width, height];
    const { config, name } = (await encodingOf(extension, { width, height, rate })) ?? {};
    if (!config) throw new Error(`this browser cannot encode a film of ${width} × ${height} pixels`);
    const pictures = [];
    let [format, failure] = [null, null];
    const encoder = new VideoEncoder({
      output: (chunk, { decoderConfig } = {}) => {
        format ??= decoderConfig;
        const bytes = new Uint8Array(chunk.byteLength);
        chunk.copyTo(bytes);
        pictures.push({ bytes, milliseconds: Math.round(chunk.timestamp / 1000), isKey: chunk.type === "key" });
      },
      error: (error) => { failure = error; },
    });
    encoder.configure(config);
    try {
      const isWhole = await this.each(rate, async (at) => {
        const frame = new VideoFrame(canvas, { timestamp: Math.round((1e6 * at) / rate), duration: Math.round(1e6 / rate) });
        encoder.encode(frame, { keyFrame: at % (KEY_EVERY * rate) === 0 });
        frame.close();
        while (encoder.encodeQueueSize > WAITING && !failure) await pause();
        if (failure) throw failure;
      });
      if (!isWhole) return null;
      await encoder.flush();
      if (extension === "webm") return webmOf(pictures, { codec: name, width, height, rate, colorSpace: format?.colorSpace });
      const { description } = format;
      const bytes = ArrayBuffer.isView(description) ? new Uint8Array(description.buffer, description.byteOffset, description.byteLength) : new Uint8Array(description);
      return mp4Of(pictures, { width, height, rate, description: bytes });
    } finally {
      if (encoder.state !== "closed") encoder.close();
    }
  }

  async gif() {
    const { stage, canvas, state } = this.player;
    const whole = this.size;
    const smaller = Math.min(1, GIF_SIZE / Math.max(...whole));
    const [width, height] = whole.map((size) => Math.round(size * smaller));
    stage.size = [width, height];
    const pen = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    const pixels = () => {
      pen.drawImage(canvas, 0, 0);
      return pen.getImageData(0, 0, width, height).data;
    };
    const [from, to] = this.range;
    const samples = Array.from({ length: PALETTE_PICTURES }, (_, i) => {
      state.time = from + ((to - from) * i) / (PALETTE_PICTURES - 1);
      stage.draw();
      return pixels();
    });
    const gif = new Gif({ width, height, hundredths: Math.round(100 / GIF_RATE), palette: paletteOf(samples) });
    return (await this.each(GIF_RATE, () => gif.add(pixels()))) ? gif.blob : null;
  }
}
