/** The milliseconds of the fastest of `rounds` runs of each function. Runs alternate, so other load affects all equally. */
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
