// Node and Deno: prints what it has played. `command.js FILE JOINT FRAME`

import { readFileSync } from "node:fs";
import process from "node:process";
import { play } from "./walk.js";

const [file, joint, frame] = process.argv.slice(2);
console.log(JSON.stringify(await play(readFileSync(file), joint, Number(frame))));
