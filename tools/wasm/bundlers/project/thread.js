// Plays in a worker thread of Node.

import process from "node:process";
import { Worker } from "node:worker_threads";

new Worker(new URL("command.js", import.meta.url), { argv: process.argv.slice(2) });
