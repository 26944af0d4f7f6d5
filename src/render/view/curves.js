// The curves of a joint: rows with one number per frame. A long clip is sampled in pieces.

import { eulerAngles, nearestAngles } from "./math.js";

const PIECE = 256;

export class Curves {
  constructor(clip, id) {
    Object.assign(this, { clip, id });
    this.frames = Math.max(1, clip.frames);
    // The number of sampled frames.
    this.filled = 0;
    const table = (columns) => Array.from({ length: columns }, () => new Float64Array(this.frames));
    this.rows = { local: table(3), world: table(3), euler: table(3), quaternion: table(4) };
    this.before = [0, 0, 0];
  }

  get complete() { return this.filled === this.frames; }

  // Samples frames for about `milliseconds`.
  fill(milliseconds) {
    const end = performance.now() + milliseconds;
    while (!this.complete && performance.now() < end) {
      const last = Math.min(this.frames, this.filled + PIECE);
      for (; this.filled < last; this.filled++) this.sample(this.filled);
    }
  }

  sample(tick) {
    const { clip, id, rows } = this;
    const rotation = clip.rotation(id, tick);
    this.before = nearestAngles(this.before, eulerAngles(rotation, clip.nodes[id].order));
    const world = clip.worldAt(id, tick);
    const local = clip.translation(id, tick);
    for (let i = 0; i < 4; i++) {
      rows.quaternion[i][tick] = rotation[i];
      if (i === 3) break;
      rows.local[i][tick] = local[i];
      rows.world[i][tick] = world[12 + i];
      rows.euler[i][tick] = this.before[i];
    }
  }
}
