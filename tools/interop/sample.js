// How much of its work a run does: all of it, or a sample that holds every form and every client.

export class Sample {
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
}
