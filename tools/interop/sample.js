// How much of its work a run does: all of it, or a sample that holds every form and every client.

import { spawnSync } from "node:child_process";

/** The same in every run on a commit, another in the next. MOCAP_SEED chooses one. */
function chosenSeed() {
  const { MOCAP_SEED } = process.env;
  if (MOCAP_SEED !== undefined) return Number(MOCAP_SEED);
  const { status, stdout } = spawnSync("git", ["rev-parse", "HEAD"], { cwd: import.meta.dirname, encoding: "utf8" });
  return status === 0 ? Number.parseInt(stdout.slice(0, 5), 16) : 0;
}

export class Sample {
  /** All, or the sample of the seed of this run, which it prints. */
  static chosen(isAll) {
    const seed = chosenSeed();
    if (!Number.isSafeInteger(seed) || seed < 0) {
      throw new Error(`MOCAP_SEED must be a whole number of at least 0, got ${process.env.MOCAP_SEED}`);
    }
    if (!isAll) console.log(`a sample, MOCAP_SEED=${seed}; --all for everything`);
    return new Sample(isAll, seed);
  }

  /** `seed` says where the sample begins, so that each seed looks at other files. */
  constructor(isAll, seed) {
    this.isAll = isAll;
    this.seed = seed;
  }

  /** The items that are the turn of `part` of `parts`: all of them, or every `parts`th. */
  share(items, part, parts) {
    return this.isAll ? items : items.filter((_, index) => (index + this.seed) % parts === part % parts);
  }

  /** One of `parts` shares. */
  some(items, parts) {
    return this.share(items, 0, parts);
  }

  /** All items as one list, or lists of one item each, the first that is the turn of `place`. */
  turns(items, place) {
    if (this.isAll) return [items];
    const first = (place + this.seed) % items.length;
    return [...items.slice(first), ...items.slice(0, first)].map((item) => [item]);
  }
}
