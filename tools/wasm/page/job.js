// What is shown, as the job of a file and as the command line that does the same.

import { quoted } from "../../../src/render/view/drag.js";

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

/** The job of `mocap run` that writes what is shown. */
export function jobOf(item, output) {
  const { names, steps, onto, retarget } = item;
  const { read, space, frames } = optionsOf(item);
  // Steps are for the motion without a rest pose before it, as `mocap edit` does it.
  if (steps.length) frames["drop-first-frame"] ??= "auto";
  const character = onto && given({ file: onto.names[0], feet: retarget.feet === "lock" ? undefined : retarget.feet });
  return given({
    read: filled(read),
    source: given({ inputs: [names[0]], space: filled(space), frames: filled(frames) }),
    steps: steps.length ? steps : undefined,
    onto: character ? { character } : undefined,
    write: { output },
  });
}

/** The command line that writes what is shown; of a job file where it is more than one command. */
export function commandOf(item, output) {
  const { names, steps, onto, retarget, change } = item;
  const { read, space, frames } = optionsOf(item);
  const flags = Object.entries({ ...read, ...space, ...frames }).map(([name, value]) => `--${name}=${quoted(value)}`);
  const line = (...words) => ["mocap", ...words].join(" ");
  if (steps.length && (onto || Object.keys(change).length)) return line("run", "job.json");
  if (steps.length) return line("edit", quoted(names[0]), ...flags, ...steps.flatMap((step) => ["--step", quoted(step)]), "-o", quoted(output));
  if (onto) {
    const feet = retarget.feet === "lock" ? [] : [`--feet=${retarget.feet}`];
    return line("retarget", quoted(names[0]), quoted(onto.names[0]), ...flags, ...feet, "-o", quoted(output));
  }
  return line("convert", quoted(names[0]), ...flags, quoted(output));
}
