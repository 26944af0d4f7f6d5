// Lists and calls every tool of `mocap mcp` with the client of npm's `@modelcontextprotocol/sdk`, and with the command line of
// the protocol's inspector. See README.md.
//
//     node client.js MOCAP

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";

const here = import.meta.dirname;
const fixtures = join(here, "../../fixtures");
const calls = JSON.parse(readFileSync(join(here, "calls.json"), "utf8"));
const mocap = process.argv[2];

/** Calls `use` with a folder of takes, which is removed after it. */
async function withRoot(use) {
    const root = mkdtempSync(join(tmpdir(), "mocap-"));
    try {
        mkdirSync(join(root, "takes"));
        for (const [name, source] of [["walk", "cmu_12_01_walk"], ["short", "cmu_short"], ["dance", "rokoko_dance"]]) {
            copyFileSync(join(fixtures, "real", `${source}.bvh`), join(root, "takes", `${name}.bvh`));
        }
        copyFileSync(join(fixtures, "characters/human_default.glb"), join(root, "hero.glb"));
        copyFileSync(join(fixtures, "robots/h1.urdf"), join(root, "h1.urdf"));
        await use(root);
    } finally {
        rmSync(root, { recursive: true });
    }
}

function hold(root, tool, given, wanted, found) {
    for (const key of wanted) {
        assert.ok(key in found, `${tool} answers without ${key}`);
    }
    const output = given.output ?? given.job?.write.output;
    assert.ok(output === undefined || existsSync(join(root, output)), `${tool} has not written ${output}`);
}

async function sdk(root) {
    const client = new Client({ name: "judge", version: "1" });
    await client.connect(new StdioClientTransport({ command: mocap, args: ["mcp", "--root", root] }));
    const { tools } = await client.listTools();
    const names = new Set(calls.map(([tool]) => tool));
    assert.deepEqual(new Set(tools.map((tool) => tool.name)), names);
    for (const [tool, given, wanted] of calls) {
        const answer = await client.callTool({ name: tool, arguments: given }, undefined, { timeout: 300_000 });
        assert.ok(!answer.isError, `${tool}: ${JSON.stringify(answer.content)}`);
        hold(root, tool, given, wanted, answer.structuredContent);
    }
    const wrong = await client.callTool({ name: "convert", arguments: { inputs: ["../a.bvh"], output: "a.glb" } });
    assert.ok(wrong.isError);
    const { resources } = await client.listResources();
    for (const { uri } of resources) {
        JSON.parse((await client.readResource({ uri })).contents[0].text);
    }
    await client.close();
    console.log(`mcp: npm's client: ${tools.length} tools listed and called, ${resources.length} resources read`);
}

/** The inspector's command line, with a process for each call. */
function inspect(root, ...words) {
    const inspector = join(here, "node_modules/.bin/mcp-inspector");
    const command = ["--cli", mocap, "mcp", "--root", root, "--method", ...words];
    return JSON.parse(execFileSync(inspector, command, { encoding: "utf8", maxBuffer: 1 << 26 }));
}

function inspector(root) {
    const { tools } = inspect(root, "tools/list");
    assert.equal(tools.length, new Set(calls.map(([tool]) => tool)).size);
    for (const [tool, given, wanted] of calls) {
        const text = (value) => (typeof value === "string" ? value : JSON.stringify(value));
        const words = Object.entries(given).flatMap(([key, value]) => ["--tool-arg", `${key}=${text(value)}`]);
        // Another process wrote the file for `verify`, so this session may only read the file.
        const answer = inspect(root, "tools/call", "--tool-name", tool, ...words);
        assert.ok(!answer.isError, `${tool}: ${JSON.stringify(answer.content)}`);
        hold(root, tool, given, wanted, answer.structuredContent);
    }
    console.log(`mcp: the inspector: ${tools.length} tools listed and called`);
}

await withRoot(sdk);
await withRoot(inspector);
