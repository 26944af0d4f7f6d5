// What is shown, as the job of a file and as the command line that does the same.

import { quoted, turnedUp } from "../../../src/render/view/drag.js";
import { isRobotFormat } from "./opened.js";

/** `drop-first-frame` by the choices of the page. */
const FIRST_FRAME = { drop: "yes", auto: "auto" };

const given = (options) => Object.fromEntries(Object.entries(options).filter(([, value]) => value !== undefined));
const filled = (part) => (Object.keys(part).length ? part : undefined);

/** The options of reading, space and frames of an item, by their names in a job. */
function optionsOf({ read, change }) {
  const { first, last, unit, up, firstFrame } = change;
  const trim = first || last ? `${first ? `${first.frame}f` : ""}..${last ? `${last.frame}f` : ""}` : undefined;
  return {
    read: given({ "root-offset": read.rootOffset, clip: read.clip === undefined ? undefined : String(read.clip) }),
    space: given({ unit: unit === undefined ? undefined : String(unit), up }),
    frames: given({ trim, "drop-first-frame": FIRST_FRAME[firstFrame] }),
  };
}

/** Steps as the program takes them, for which +Y is up: the page has the axes of the file. */
const programSteps = ({ steps, clip }) => steps.map((step) => (step.startsWith("reach:") ? step.replace(/\bto=([^,]+)/, (_, to) => `to=${turnedUp(to.split("/").map(Number), clip?.data.up).join("/")}`) : step));

/** The job of `mocap run` that writes what is shown. */
export function jobOf(item, output) {
  const { names, onto, retarget } = item;
  const steps = programSteps(item);
  const { read, space, frames } = optionsOf(item);
  // Steps are for the motion without a rest pose before it, as `mocap edit` does it.
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

/** The command line that writes what is shown; of a job file where it is more than one command. */
export function commandOf(item, output) {
  const { names, onto, retarget, change } = item;
  const steps = programSteps(item);
  const { read, space, frames } = optionsOf(item);
  const flags = Object.entries({ ...read, ...space, ...frames }).map(([name, value]) => `--${name}=${quoted(value)}`);
  const line = (...words) => ["mocap", ...words].join(" ");
  // A command takes bones from a file, a job has them in it.
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
