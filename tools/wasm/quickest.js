/** The milliseconds of the quickest of `rounds` runs of each function, in turns, so that a busy machine is fair to all. */
export function quickest(runs, rounds) {
  const best = runs.map(() => Infinity);
  for (let round = 0; round < rounds; round++) {
    for (const [index, run] of runs.entries()) {
      const start = performance.now();
      run();
      best[index] = Math.min(best[index], performance.now() - start);
    }
  }
  return best;
}
