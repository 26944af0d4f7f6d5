#!/usr/bin/env node
// The command line of the package: the commands of `mocap` that are jobs on files, with the same options, messages and exit
// codes. job.schema.json has the options.

import { existsSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { dirname, extname, join } from "node:path";
import { MocapError, load } from "./index.js";

const here = (name) => new URL(name, import.meta.url);
const { name: PACKAGE, version } = JSON.parse(readFileSync(here("package.json"), "utf8"));
const schema = JSON.parse(readFileSync(here("job.schema.json"), "utf8"));

/** The positional arguments and the effect of each command. */
const COMMANDS = {
  convert: ["INPUT [OUTPUT]", "convert a motion file: to GLB, VRMA, FBX, BVH and others"],
  retarget: ["INPUT TARGET -o OUTPUT", "retarget a motion to a character"],
  robot: ["INPUT --robot TARGET -o OUTPUT", "retarget a human motion to a robot"],
  edit: ["INPUT -o OUTPUT --step STEP", "change a motion: foot-lock, mirror, smooth:cut-off=8, ..."],
  check: ["INPUT..", "report errors and warnings of files"],
  run: ["JOB", "run the job of a JSON file"],
};

/** Options of a job with another name on the command line. */
const SPELLED = { joints: "joint-set" };

const FULL = "install the program: `cargo install mocap-cli`";

/** A mistake in the arguments. */
class Usage extends Error {}

/** The record to which a part of the schema refers, or the alternative that is an object. */
function record(part) {
  if (part.$ref) return record(schema.$defs[part.$ref.split("/").at(-1)]);
  return part.properties ? part : undefined;
}

/** The JSON types that a part of the schema accepts. */
function kinds(part) {
  if (part.$ref) return kinds(schema.$defs[part.$ref.split("/").at(-1)]);
  if (part.enum || typeof part.const === "string") return ["string"];
  return [part.type ?? [], ...(part.anyOf ?? part.oneOf ?? []).map(kinds)].flat(2);
}

/** The options of a job by their names, each with its path in the job; `target` is the kind of the target. */
function optionsOf(target) {
  const found = new Map();
  const add = (part, path) => {
    for (const [name, inner] of Object.entries(record(part).properties)) {
      const spelled = SPELLED[name] ?? name;
      if (record(inner)) add(inner, [...path, name]);
      else if (!found.has(spelled)) found.set(spelled, { path: [...path, name], kinds: kinds(inner) });
    }
  };
  const { read, source, write } = record({ $ref: "#/$defs/MotionJob" }).properties;
  if (target) add({ $ref: `#/$defs/${target === "robot" ? "RobotTarget" : "CharacterTarget"}` }, ["target", target]);
  add(source, ["source"]);
  add(read, ["read"]);
  add(write, ["write"]);
  for (const name of ["inputs", "output", "file"]) found.delete(name);
  found.set("with", { path: ["source", "with"], kinds: ["array"] });
  found.set("step", { path: ["steps"], kinds: ["array"] });
  return found;
}

function put(job, path, value) {
  const last = path.at(-1);
  const part = path.slice(0, -1).reduce((inner, key) => (inner[key] ??= {}), job);
  if (Array.isArray(value)) (part[last] ??= []).push(...value);
  else part[last] = value;
}

/** The job of a command line. */
function jobOf(command, words) {
  const target = { retarget: "character", robot: "robot" }[command];
  const options = optionsOf(target);
  const job = { source: { inputs: [] }, write: { output: "" } };
  const files = [];
  const rest = [...words];
  while (rest.length) {
    const word = rest.shift();
    if (word === "--") {
      files.push(...rest.splice(0));
      continue;
    }
    if (!word.startsWith("-") || word === "-") {
      files.push(word);
      continue;
    }
    const [flag, ...after] = word === "-o" ? ["--output"] : word.split("=");
    const name = flag.replace(/^--/, "");
    const value = () => {
      const given = after.length ? after.join("=") : rest.shift();
      if (given === undefined) throw new Usage(`a value is required for '${flag}'`);
      return given;
    };
    if (name === "output") job.write.output = value();
    else if (target && (name === target || name === "on")) put(job, ["target", target, "file"], value());
    else {
      const option = options.get(name);
      if (!option) throw new Usage(`unexpected argument '${flag}' found; ${PACKAGE} ${command} --help lists the options`);
      const { path, kinds } = option;
      if (kinds.includes("boolean")) put(job, path, true);
      else if (kinds.includes("array")) put(job, path, [value()]);
      else if (kinds.includes("string")) put(job, path, value());
      else put(job, path, number(flag, value()));
    }
  }
  if (target === "character" && !job.target?.character.file && files.length > 1) put(job, ["target", target, "file"], files.splice(1, 1)[0]);
  if (command === "convert" && !job.write.output) {
    const [input] = files;
    job.write.output = files.length > 1 ? files.pop() : `${input?.slice(0, input.length - extname(input).length)}.glb`;
  }
  if (!files.length) throw new Usage("the following required arguments were not provided: <INPUT>");
  if (target && !job.target?.[target].file) throw new Usage("the following required arguments were not provided: <TARGET>");
  if (!job.write.output) throw new Usage("the following required arguments were not provided: --output <OUTPUT>");
  if (files.length > 1 && !target && !job.steps) throw new Usage(`several motions need the full program; ${FULL}`);
  job.source.inputs = files;
  // Steps must not change a rest pose before the motion.
  if (command === "edit") (job.source.frames ??= {})["drop-first-frame"] ??= "auto";
  return job;
}

function number(flag, text) {
  const value = Number(text);
  if (text.trim() === "" || !Number.isFinite(value)) throw new Usage(`invalid value '${text}' for '${flag}': it is not a number`);
  return value;
}

/** The files that a job names and their companion files, with their bytes. */
function filesOf(value) {
  const names = new Set();
  const add = (name) => {
    if (names.has(name)) return;
    names.add(name);
    const beside = (other) => existsSync(join(dirname(name), other)) && add(join(dirname(name), other));
    const kind = extname(name).toLowerCase();
    if (kind === ".amc") readdirSync(dirname(name)).filter((other) => /\.asf$/i.test(other)).forEach(beside);
    if (kind === ".vmd") readdirSync(dirname(name)).filter((other) => /\.pmx$/i.test(other)).forEach(beside);
    if (![".gltf", ".urdf", ".xml", ".mjcf"].includes(kind)) return;
    const text = readFileSync(name, "utf8");
    for (const [, other] of text.matchAll(/"?\b(?:uri|filename|file)"?\s*[:=]\s*"(?:package:\/\/[^/"]*\/)?([^"]+)"/g)) {
      if (!other.startsWith("data:")) beside(decodeURIComponent(other));
    }
  };
  const walk = (part) => {
    if (typeof part === "string") existsSync(part) && !readsFolder(part) && add(part);
    else if (part && typeof part === "object") Object.values(part).forEach(walk);
  };
  walk(value);
  return [...names].map((name) => ({ name, bytes: readFileSync(name) }));
}

function readsFolder(path) {
  try {
    readdirSync(path);
    return true;
  } catch {
    return false;
  }
}

/** Writes a complete file or nothing. */
function save(name, bytes) {
  const part = `${name}.${process.pid}.part`;
  try {
    writeFileSync(part, bytes, { flag: "wx" });
    renameSync(part, name);
  } catch (error) {
    rmSync(part, { force: true });
    throw error;
  }
}

/** A diagnostic in the format of the program: the line with a marker, and the expected text. */
function shown(severity, file, { code, message, reason, line, column, length, text, joint, expected, found, help }) {
  const place = [file, line, column].filter((part) => part !== undefined && part !== null).join(":");
  const lines = [`${place}${place && ": "}${severity}[${code}]: ${reason ?? message}`];
  const margin = " ".repeat(String(line ?? "").length);
  if (text) lines.push(`${margin} |`, `${line} | ${text}`, `${margin} | ${" ".repeat((column ?? 1) - 1)}${"^".repeat(length || 1)}`, `${margin} |`);
  for (const [key, value] of Object.entries({ joint, expected, found, help })) if (value) lines.push(`${margin} = ${key}: ${value}`);
  return lines.join("\n");
}

const say = (text) => process.stderr.write(`${text}\n`);

function make(mocap, job, force) {
  const { output } = job.write;
  if (existsSync(output) && !force) {
    say(`error: ${output}: the file exists; name another one, or replace it with --force`);
    return 1;
  }
  const report = mocap.run(job, filesOf({ ...job, write: { ...job.write, output: undefined } }));
  for (const warning of report.warnings) say(shown("warning", job.source.inputs[0], warning));
  report.notes.forEach(say);
  for (const { name, bytes } of report.files) save(name, bytes);
  const bytes = report.files.reduce((sum, file) => sum + file.bytes.length, 0);
  say(`${job.source.inputs.join(" ")} -> ${output}: ${bytes} bytes`);
  if (report.problem) say(`error: ${report.problem}`);
  return report.problem ? 1 : 0;
}

function check(mocap, words) {
  const files = words.filter((word) => word !== "--");
  if (!files.length) throw new Usage("the following required arguments were not provided: <INPUT>");
  let failed = 0;
  for (const file of files) {
    const { status, diagnostics } = mocap.check(filesOf(file));
    for (const finding of diagnostics) console.log(shown(finding.severity ?? status, file, finding));
    const count = diagnostics.length === 1 ? `1 ${status}` : `${diagnostics.length} findings`;
    console.log(`${file}: ${status === "ok" ? "ok" : count}`);
    failed += status === "error";
  }
  if (!failed) return 0;
  return files.length > 1 ? 3 : 1;
}

function help(command) {
  const lines = command
    ? [`Usage: ${PACKAGE} ${command} ${COMMANDS[command][0]} [OPTIONS]`]
    : [`Usage: ${PACKAGE} COMMAND`, "", ...Object.entries(COMMANDS).map(([name, [, about]]) => `  ${name.padEnd(10)}${about}`)];
  if (command && !["check", "run"].includes(command)) {
    const names = [...optionsOf({ retarget: "character", robot: "robot" }[command]).keys()].sort();
    lines.push("", "Options, as in the full program:", ...names.map((name) => `  --${name}`));
  }
  return [...lines, "", `For all other commands, ${FULL}`].join("\n");
}

/** Runs a command; the exit code. */
async function main([command, ...words]) {
  if (command === undefined || ["help", "-h", "--help"].includes(command)) {
    console.log(help());
    return command === undefined ? 2 : 0;
  }
  if (["-V", "--version"].includes(command)) {
    console.log(`${PACKAGE} ${version}`);
    return 0;
  }
  if (!Object.hasOwn(COMMANDS, command)) throw new Usage(`${PACKAGE} has no command '${command}'; ${FULL}`);
  if (words.some((word) => ["-h", "--help"].includes(word))) {
    console.log(help(command));
    return 0;
  }
  const isJob = command === "run";
  if (isJob && words.length !== 1) throw new Usage("run takes one file: JOB");
  const job = command === "check" ? undefined : isJob ? JSON.parse(readFileSync(words[0], "utf8")) : jobOf(command, words);
  // Node 18 cannot find the module by itself.
  const named = job ? [...(job.source?.inputs ?? []), ...Object.values(job.target ?? {}).map(({ file }) => file)] : words;
  const missing = named.find((file) => file !== "--" && !existsSync(file));
  if (missing !== undefined) throw new MocapError({ code: "io", message: "file not found", file: missing });
  const mocap = await load(readFileSync(here("mocap.wasm")));
  return job ? make(mocap, job, isJob || job.write.force) : check(mocap, words);
}

try {
  process.exitCode = await main(process.argv.slice(2));
} catch (error) {
  const isUsage = error instanceof Usage;
  if (error instanceof MocapError) say(shown("error", error.file, { ...error, message: error.message }));
  else if (isUsage || error.code || error instanceof SyntaxError) say(`error: ${error.message}`);
  else throw error;
  process.exitCode = isUsage || error.code === "invalid-value" ? 2 : 1;
}
