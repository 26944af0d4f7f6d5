// The trimmed part of a motion, in frames of its file.

import { byId } from "../../../src/render/view/dom.js";

export class Trim {
  // `acts`: tick() returns the shown tick, change(values) applies new bounds, tell(text) shows an error.
  constructor(acts) {
    this.acts = acts;
    const bounds = () => [byId("trim-first").value, byId("trim-last").value];
    for (const id of ["trim-first", "trim-last"]) byId(id).addEventListener("change", () => this.apply(...bounds()));
    byId("trim-first-here").addEventListener("click", () => this.apply(this.fileFrame, bounds()[1]));
    byId("trim-last-here").addEventListener("click", () => this.apply(bounds()[0], this.fileFrame));
    byId("trim-none").addEventListener("click", () => acts.change({ first: undefined, last: undefined }));
  }

  // The frame of the file at the shown tick.
  get fileFrame() {
    const { change, frames, answer } = this.item;
    const last = change.last?.frame ?? frames - 1;
    return Math.min(last, last + 1 - answer.frames + Math.round(this.acts.tick()));
  }

  apply(first, last) {
    const { frames } = this.item;
    const [from, to] = [first, last].map((frame) => Math.min(frames - 1, Math.max(0, Math.round(Number(frame) || 0))));
    if (to < from) return this.acts.tell(`Not changed: the last frame, ${to}, is before the first, ${from}.`);
    return this.acts.change({ first: from > 0 ? { frame: from } : undefined, last: to < frames - 1 ? { frame: to } : undefined });
  }

  show(item) {
    const { frames, change, onto } = item;
    this.item = item;
    byId("trim").hidden = Boolean(onto) || !frames;
    byId("trim-first").value = change.first?.frame ?? 0;
    byId("trim-last").value = change.last?.frame ?? Math.max(0, frames - 1);
    byId("trim-first").max = byId("trim-last").max = Math.max(0, frames - 1);
  }
}
