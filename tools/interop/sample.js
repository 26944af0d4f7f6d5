// Selects the work of a run: all of it, or a sample with every form and every client.

import { spawnSync } from "node:child_process";

/** The seed is the same in every run on a commit, and changes with the commit. MOCAP_SEED overrides it. */
function chosenSeed() {
  const { MOCAP_SEED } = process.env;
  if (MOCAP_SEED !== undefined) return Number(MOCAP_SEED);
  const { status, stdout } = spawnSync("git", ["rev-parse", "HEAD"], { cwd: import.meta.dirname, encoding: "utf8" });
  return status === 0 ? Number.parseInt(stdout.slice(0, 5), 16) : 0;
}

export class Sample {
  /** Selects all work, or the sample of this run's seed, which it prints. */
  static chosen(isAll) {
    const seed = chosenSeed();
    if (!Number.isSafeInteger(seed) || seed < 0) {
      throw new Error(`MOCAP_SEED must be a whole number of at least 0, got ${process.env.MOCAP_SEED}`);
    }
    if (!isAll) console.log(`a sample, MOCAP_SEED=${seed}; --all for everything`);
    return new Sample(isAll, seed);
  }

  /** `seed` determines where the sample begins, so that each seed selects other files. */
  constructor(isAll, seed) {
    this.isAll = isAll;
    this.seed = seed;
  }

  /** The items of sample `part` of `parts`: all items, or every `parts`th item. */
  share(items, part, parts) {
    return this.isAll ? items : items.filter((_, index) => (index + this.seed) % parts === part % parts);
  }

  /** One of `parts` samples. */
  some(items, parts) {
    return this.share(items, 0, parts);
  }

  /** One list of all items, or lists of one item each, beginning with the item at `place`. */
  turns(items, place) {
    if (this.isAll) return [items];
    const first = (place + this.seed) % items.length;
    return [...items.slice(first), ...items.slice(0, first)].map((item) => [item]);
  }
}
