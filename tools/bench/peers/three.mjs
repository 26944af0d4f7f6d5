// Prints the time of three.js for a BVH file: the median of `rounds` runs in milliseconds, as JSON.
import { readFileSync } from "node:fs";
import { performance } from "node:perf_hooks";
import { BVHLoader } from "three/examples/jsm/loaders/BVHLoader.js";

const [file, rounds] = process.argv.slice(2);
const times = [];
for (let round = 0; round < Number(rounds); round++) {
    const start = performance.now();
    new BVHLoader().parse(readFileSync(file, "utf8"));
    times.push(performance.now() - start);
}
times.sort((a, b) => a - b);
console.log(JSON.stringify({ median_ms: times[Math.floor(times.length / 2)] }));
