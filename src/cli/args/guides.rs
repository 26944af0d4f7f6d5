//! The start of each command's help: the most used options, and two examples.

/// The options that `-h` shows of a command, and the examples at the end of its help.
pub struct Guide {
    /// The words of the command.
    pub command: &'static str,
    /// The options that `-h` shows, in this order. `--help` shows the others after them.
    pub options: &'static [&'static str],
    /// Two command lines, each with its effect. `src/cli/tests/it/help.rs` runs them.
    pub examples: [(&'static str, &'static str); 2],
}

const fn guide(
    command: &'static str,
    options: &'static [&'static str],
    examples: [(&'static str, &'static str); 2],
) -> Guide {
    Guide {
        command,
        options,
        examples,
    }
}

/// One for every command.
pub const GUIDES: &[Guide] = &[
    guide(
        "convert",
        &["output", "to", "trim", "fps", "max-error", "verify"],
        [
            (
                "convert walk.bvh walk.glb --max-error 1mm",
                "a small glTF file, within 1 mm",
            ),
            ("convert takes -o converted --fps 30", "every motion of a folder"),
        ],
    ),
    guide(
        "retarget",
        &["output", "character", "trim", "fps", "max-angle", "json"],
        [
            (
                "retarget walk.bvh hero.glb -o hero_walk.glb",
                "the character with the motion",
            ),
            (
                "retarget takes --character hero.glb -o heroes/",
                "one file for each motion of a folder",
            ),
        ],
    ),
    guide(
        "robot",
        &["output", "robot", "to", "trim", "fps", "require"],
        [
            (
                "robot walk.bvh --robot h1.urdf -o h1.npz",
                "the joints of the robot, for NumPy",
            ),
            (
                "robot walk.bvh --robot h1.urdf -o h1.glb",
                "the moving robot, to look at",
            ),
        ],
    ),
    guide(
        "edit",
        &["output", "step", "loop-frames", "with", "to", "verify"],
        [
            (
                "edit walk.bvh -o held.bvh --step foot-lock --step smooth:cut-off=8",
                "two steps in order",
            ),
            (
                "edit walk.bvh run.bvh -o both.glb --step concat:blend=0.4",
                "one after the other",
            ),
        ],
    ),
    guide(
        "clean",
        &["output", "only", "without", "report", "to", "verify"],
        [
            (
                "clean walk.bvh -o clean.bvh --report clean.json",
                "with the measures before and after",
            ),
            ("clean takes -o cleaned/ --without floor", "every motion of a folder"),
        ],
    ),
    guide(
        "graph",
        &["output", "threshold", "window", "rate", "character", "matrix"],
        [
            ("graph walk.bvh -o moves.json", "the transitions within a motion"),
            (
                "graph walk.bvh -o wide.json --threshold 8cm",
                "more transitions, which are less smooth",
            ),
        ],
    ),
    guide(
        "graph walk",
        &["output", "seconds", "path", "through", "character", "to"],
        [
            (
                "graph walk moves.json --seconds 10 -o wander.glb",
                "ten seconds of motion",
            ),
            ("graph walk moves.json --path 0/0+0/2 -o ahead.bvh", "two metres ahead"),
        ],
    ),
    guide(
        "solve",
        &["output", "joint-set", "smooth", "to", "fps", "verify"],
        [
            ("solve trial.c3d trial.glb", "a skeleton from labelled markers"),
            ("solve trial.c3d smooth.bvh --smooth=6", "without motion above 6 Hz"),
        ],
    ),
    guide(
        "run",
        &["json", "schema", "to", "dry-run", "resume", "force"],
        [
            (
                "convert walk.bvh job.glb --print-job > job.json",
                "a job from the options of a command",
            ),
            ("run job.json", "run the job"),
        ],
    ),
    guide(
        "index",
        &["output", "mirror", "pack", "resume", "threads", "force"],
        [
            ("index takes -o moves.mdb", "a database to search in"),
            (
                "index takes -o both.mdb --mirror --pack",
                "with mirror images, in one file",
            ),
        ],
    ),
    guide(
        "find",
        &["like", "pose", "count", "where", "sheet", "page"],
        [
            (
                "find moves.mdb --like walk.bvh@0.5s..1.5s",
                "parts similar to this second",
            ),
            (
                "find moves.mdb --pose walk.bvh@0.5s --sheet found.png",
                "similar poses, with a picture",
            ),
        ],
    ),
    guide(
        "match",
        &["output", "character", "path", "gamepad", "speed", "json"],
        [
            (
                "match moves.mdb --path 0/0+0/2 --character hero.glb -o led.glb",
                "two metres ahead",
            ),
            (
                "match moves.mdb --path 0/0+0/1+1/1 --character hero.glb -o turn.bvh",
                "round a corner",
            ),
        ],
    ),
    guide(
        "record",
        &["output", "seconds", "clean", "force"],
        [
            ("record vmc:39539 -o take.bvh", "until Ctrl-C"),
            (
                "record vmc:39539 -o take.vrma --seconds 60 --clean",
                "a minute, cleaned",
            ),
        ],
    ),
    guide(
        "play",
        &["vmc", "robot", "loop", "rate", "clean", "delay"],
        [
            ("play walk.bvh --vmc 39539 --loop", "to a program on this machine"),
            ("play vmc:39539 --clean --vmc 39540", "a live stream, without its noise"),
        ],
    ),
    guide(
        "bridge",
        &["character", "vmc", "udp-json", "clean", "delay"],
        [
            (
                "bridge vmc:39539 --character hero.glb --vmc 39540",
                "the stream moves the character",
            ),
            (
                "bridge vmc:39539 --robot h1.urdf --udp-json 5005",
                "the stream moves the robot",
            ),
        ],
    ),
    guide(
        "view",
        &["output", "character", "robot", "trim", "fps", "force"],
        [
            ("view walk.bvh -o walk.html", "a page; or open it without -o"),
            (
                "view walk.bvh run.bvh -o both.html --character hero.glb",
                "two motions on a character",
            ),
        ],
    ),
    guide(
        "info",
        &["json", "clip", "from", "strict"],
        [
            ("info walk.bvh", "frames, rate, joints, unit"),
            ("info walk.bvh --json > walk.json", "for a program"),
        ],
    ),
    guide(
        "skeleton",
        &["json", "explain", "unit", "up", "map"],
        [
            ("skeleton walk.bvh --explain", "the reasons for the bone of each joint"),
            ("skeleton walk.bvh --json > bones.json", "bones to correct, for --map"),
        ],
    ),
    guide(
        "sheet",
        &["output", "poses", "width", "robot", "t-pose", "clip"],
        [
            (
                "sheet walk.bvh run.bvh -o sheet.png --poses 5",
                "one row for each motion",
            ),
            ("sheet hero.glb -o pose.svg --t-pose", "the T-pose of a character"),
        ],
    ),
    guide(
        "gif",
        &["output", "width", "height", "rate", "playback-speed", "robot"],
        [
            ("gif walk.bvh -o walk.gif --rate 5", "five pictures per second"),
            (
                "gif walk.bvh -o slow.png --rate 5 --playback-speed 2",
                "an animated PNG, twice as fast",
            ),
        ],
    ),
    guide(
        "plot",
        &["joint", "output", "width", "to", "clip", "force"],
        [
            ("plot walk.bvh --joint LeftFoot -o foot.svg", "position and angles"),
            (
                "plot walk.bvh --joint LeftFoot --joint RightFoot -o feet.png",
                "two joints",
            ),
        ],
    ),
    guide(
        "fk",
        &["output", "to", "rot", "joints", "fps", "contacts"],
        [
            ("fk walk.bvh -o walk.npz --rot 6d --fps 30", "arrays for training"),
            ("fk walk.bvh -o walk.csv --contacts", "a table, with foot contacts"),
        ],
    ),
    guide(
        "angles",
        &["output", "to", "unit", "up", "map", "clip"],
        [
            ("angles walk.bvh -o walk.mot", "for OpenSim"),
            ("angles walk.bvh -o angles.csv", "a table"),
        ],
    ),
    guide(
        "gait",
        &["json", "unit", "up", "map", "clip"],
        [
            ("gait walk.bvh", "the table"),
            ("gait walk.bvh --json > gait.json", "for a program"),
        ],
    ),
    guide(
        "forces",
        &["output", "to", "from", "force"],
        [
            ("forces plates.c3d -o forces.mot", "for OpenSim"),
            ("forces plates.c3d -o forces.csv", "a table"),
        ],
    ),
    guide(
        "analog",
        &["output", "to", "from", "force"],
        [
            ("analog plates.c3d -o analog.sto", "for OpenSim"),
            ("analog plates.c3d -o analog.csv", "a table"),
        ],
    ),
    #[cfg(feature = "parquet")]
    guide(
        "pack",
        &["output", "table", "rot", "fps", "resume", "threads"],
        [
            ("pack takes -o packed --rot 6d --fps 30", "arrays for training"),
            ("pack takes -o listed --table inventory", "one row per file"),
        ],
    ),
    guide(
        "pose",
        &["tick", "world", "loop", "json", "csv", "clip"],
        [
            ("pose walk.bvh --tick 10", "each joint relative to its parent"),
            (
                "pose walk.bvh --tick 10 --world --csv > pose.csv",
                "each joint relative to the world",
            ),
        ],
    ),
    guide(
        "chain",
        &["tick", "point", "json", "clip"],
        [
            (
                "chain walk.bvh LeftFoot --tick 10",
                "every matrix from the root to the foot",
            ),
            (
                "chain walk.bvh LeftFoot --point 0,0,1",
                "the position of a point on the foot",
            ),
        ],
    ),
    guide(
        "dump",
        &["json", "raw", "layout", "clip"],
        [
            ("dump walk.bvh tree bone", "two sections"),
            ("dump walk.bvh --json > scene.json", "the whole scene"),
        ],
    ),
    guide(
        "check",
        &["json", "strict", "threads", "allow-empty"],
        [
            ("check takes", "every motion of a folder"),
            ("check takes --strict -q", "only the files with a warning or an error"),
        ],
    ),
    guide(
        "survey",
        &["output", "html", "where", "select", "threshold", "fail-on"],
        [
            ("survey takes -o survey.csv", "a row for each clip"),
            ("survey takes --html survey.html", "a page with the worst clips"),
        ],
    ),
    guide(
        "verify",
        &["max-error", "json", "with", "clip"],
        [
            ("verify walk.bvh walk.glb", "every joint within 1 mm"),
            (
                "verify walk.bvh walk.glb --max-error 5mm --json > verified.json",
                "for a program",
            ),
        ],
    ),
    guide(
        "score",
        &["robot", "json", "body", "map", "clip"],
        [
            ("robot walk.bvh --robot h1.urdf -o h1.npz", "a motion of the robot"),
            (
                "score walk.bvh h1.npz --robot h1.urdf",
                "how closely it follows the walk",
            ),
        ],
    ),
    guide(
        "formats",
        &["json"],
        [
            ("formats", "readable and writable formats"),
            ("formats --json > formats.json", "for a program"),
        ],
    ),
    guide(
        "doctor",
        &["json"],
        [
            ("doctor", "missing features, and the commands that need them"),
            ("doctor --json > doctor.json", "for a program"),
        ],
    ),
    guide(
        "merge-manifest",
        &[],
        [
            (
                "convert takes -o shards --shard 1/2",
                "half of a folder, on one machine",
            ),
            ("merge-manifest shards", "when both halves are done"),
        ],
    ),
    guide(
        "completions",
        &[],
        [
            ("completions bash > mocap.bash", "source this file in ~/.bashrc"),
            ("completions zsh > _mocap", "put this file into a folder of $fpath"),
        ],
    ),
    guide(
        "man",
        &["output"],
        [
            ("man convert > convert.1", "to read with: man ./convert.1"),
            ("man -o pages", "the pages of all commands, for a package"),
        ],
    ),
    guide(
        "mcp",
        &["root", "time-limit"],
        [
            ("mcp --root takes", "an agent may use this folder"),
            ("mcp --root takes --time-limit 60", "each call may take one minute"),
        ],
    ),
];

/// The examples of the whole program.
pub(super) const FIRST: [(&str, &str); 2] = [
    ("view walk.bvh", "look at a motion"),
    ("convert walk.bvh walk.glb", "for engines and viewers"),
];
