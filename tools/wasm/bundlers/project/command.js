// For Node and Deno: plays a file and prints the result. `command.js FILE JOINT FRAME`

import { readFileSync } from "node:fs";
import process from "node:process";
import { play } from "./walk.js";

const [file, joint, frame] = process.argv.slice(2);
console.log(JSON.stringify(await play(readFileSync(file), joint, Number(frame))));
