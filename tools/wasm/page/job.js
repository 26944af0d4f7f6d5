// The job and the command line that write the shown motion.

import { quoted, turnedUp } from "../../../src/render/view/drag.js";
import { isRobotFormat } from "./opened.js";

/** The values of `drop-first-frame` for the choices of the page. */
const FIRST_FRAME = { drop: "yes", auto: "auto" };

const given = (options) => Object.fromEntries(Object.entries(options).filter(([, value]) => value !== undefined));
const filled = (part) => (Object.keys(part).length ? part : undefined);

/** The options of an item for reading, space and frames, by their names in a job. */
function optionsOf({ read, change }) {
  const { first, last, unit, up, firstFrame } = change;
  const trim = first || last ? `${first ? `${first.frame}f` : ""}..${last ? `${last.frame}f` : ""}` : undefined;
  return {
    read: given({ "root-offset": read.rootOffset, clip: read.clip === undefined ? undefined : String(read.clip) }),
    space: given({ unit: unit === undefined ? undefined : String(unit), up }),
    frames: given({ trim, "drop-first-frame": FIRST_FRAME[firstFrame] }),
  };
}

/** Converts steps for the program, in which +Y is up. The page has the axes of the file. */
const programSteps = ({ steps, clip }) => steps.map((step) => (step.startsWith("reach:") ? step.replace(/\bto=([^,]+)/, (_, to) => `to=${turnedUp(to.split("/").map(Number), clip?.data.up).join("/")}`) : step));

/** The job of `mocap run` that writes the shown motion. */
export function jobOf(item, output) {
  const { names, onto, retarget } = item;
  const steps = programSteps(item);
  const { read, space, frames } = optionsOf(item);
  // Steps need the motion without a rest pose before it, as in `mocap edit`.
  if (steps.length) frames["drop-first-frame"] ??= "auto";
  const isRobot = isRobotFormat(onto?.format);
  const body = onto && given({ file: onto.names[0], map: onto.change.bones, feet: isRobot || retarget.feet === "lock" ? undefined : retarget.feet });
  return given({
    read: filled(read),
    source: given({ inputs: [names[0]], map: item.change.bones, space: filled(space), frames: filled(frames) }),
    steps: steps.length ? steps : undefined,
    target: body ? { [isRobot ? "robot" : "character"]: body } : undefined,
    write: { output: isRobot ? output.replace(/glb$/, "csv") : output },
  });
}

/** The command line that writes the shown motion, or `mocap run job.json` if one command cannot. */
export function commandOf(item, output) {
  const { names, onto, retarget, change } = item;
  const steps = programSteps(item);
  const { read, space, frames } = optionsOf(item);
  const flags = Object.entries({ ...read, ...space, ...frames }).map(([name, value]) => `--${name}=${quoted(value)}`);
  const line = (...words) => ["mocap", ...words].join(" ");
  // A job contains the bones, but a command reads them from a file.
  if (change.bones || onto?.change.bones) return line("run", "job.json");
  if (steps.length && (onto || Object.keys(change).length)) return line("run", "job.json");
  if (steps.length) return line("edit", quoted(names[0]), ...flags, ...steps.flatMap((step) => ["--step", quoted(step)]), "-o", quoted(output));
  if (isRobotFormat(onto?.format)) return line("robot", quoted(names[0]), "--robot", quoted(onto.names[0]), ...flags, "-o", quoted(output.replace(/glb$/, "csv")));
  if (onto) {
    const feet = retarget.feet === "lock" ? [] : [`--feet=${retarget.feet}`];
    return line("retarget", quoted(names[0]), quoted(onto.names[0]), ...flags, ...feet, "-o", quoted(output));
  }
  return line("convert", quoted(names[0]), ...flags, quoted(output));
}
