// Prints the number of errors and warnings that the Khronos validator finds in each file, as one line of JSON per file.
//
// usage: node validate.js FILE..
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

const require = createRequire(new URL("../interop/package.json", import.meta.url));
const validator = require("gltf-validator");

for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(await readFile(file)), { maxIssues: 20 });
  const messages = issues.messages.filter(({ severity }) => severity === 0).map(({ message, pointer }) => `${pointer}: ${message}`);
  console.log(JSON.stringify({ file, errors: issues.numErrors, warnings: issues.numWarnings, messages }));
}
