//! The tools: each is a command with the files and the options that an agent needs. All others are in a job, for `run`.

use serde_json::{Map, Value};

use super::protocol::Fault;

/// A tool.
pub struct Tool {
    /// Its name: its command, or the command's last word.
    pub name: &'static str,
    /// What the model of a client reads.
    pub(super) about: &'static str,
    pub(super) files: &'static [FileArgument],
    /// The options of the command that the tool has, by their long names.
    pub options: &'static [&'static str],
}

/// An argument that names files.
pub(super) struct FileArgument {
    pub(super) name: &'static str,
    pub(super) slot: Slot,
    pub(super) is_list: bool,
    pub(super) is_required: bool,
    pub(super) about: &'static str,
}

/// Where files stand on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// Without an option.
    Position,
    /// With the option of the argument's name.
    Option,
    /// The output of `convert`: without an option, or with `--out-dir` where it is a folder.
    OutputOrFolder,
}

const fn input(name: &'static str, about: &'static str) -> FileArgument {
    FileArgument {
        name,
        slot: Slot::Position,
        is_list: false,
        is_required: true,
        about,
    }
}

const fn inputs(about: &'static str) -> FileArgument {
    FileArgument {
        is_list: true,
        ..input("inputs", about)
    }
}

const fn option(name: &'static str, is_required: bool, about: &'static str) -> FileArgument {
    FileArgument {
        slot: Slot::Option,
        is_required,
        ..input(name, about)
    }
}

const OUTPUT: FileArgument = option(
    "output",
    true,
    "The file to write, in the format of its extension; or with / at its end a folder, for a file of each input",
);

const INPUTS: FileArgument = inputs("The motions; folders and wildcards too where the output is a folder");

const WITH: FileArgument = FileArgument {
    is_list: true,
    ..option(
        "with",
        false,
        "Second motions that steps join, blend or layer with the first",
    )
};

/// All tools.
pub const TOOLS: &[Tool] = &[
    Tool {
        name: "info",
        about: "Inspect a file: format, joints, frames, clips, what is guessed, warnings",
        files: &[input("input", "The motion file")],
        options: &["clip", "from"],
    },
    Tool {
        name: "skeleton",
        about: "Say unit, axes, rest pose, and which joint is which bone of a humanoid, how sure that is, and why",
        files: &[input("input", "The motion file")],
        options: &["clip", "from", "unit", "up", "map", "explain"],
    },
    Tool {
        name: "check",
        about: "Report errors and warnings of files, with line, column, and how to mend them",
        files: &[inputs("Motion files, folders and wildcards")],
        options: &["clip", "from", "strict"],
    },
    Tool {
        name: "survey",
        about: "Grade every clip of folders: verdict, quality from 0 to 1, defects and where they are, twins, activity; \
                the best first. Begin here to choose takes",
        files: &[
            inputs("Motion files, folders and wildcards; . is the root folder"),
            option("output", false, "A table to write: .csv, .json, .jsonl or .txt"),
            option("html", false, "A page to write, on which the user sees the corpus"),
            option("sarif", false, "The findings to write as SARIF"),
        ],
        options: &["where", "select", "by", "threshold", "fail-on"],
    },
    Tool {
        name: "index",
        about: "Make a database of what every frame of many motions does, for find",
        files: &[
            inputs("Motion files, folders and wildcards; an .mdb file is what an earlier call wrote"),
            option("output", true, "The database to write: .mdb"),
        ],
        options: &["mirror", "pack"],
    },
    Tool {
        name: "find",
        about: "Find in a database of index what is most like a part of a motion (like: walk.bvh@2.0s..3.5s), or a pose",
        files: &[input("database", "The .mdb file")],
        options: &["like", "pose", "count", "no-mirror", "where"],
    },
    Tool {
        name: "match",
        about: "Let a character follow a path over the ground (path: 0/0+0/4+3/4, x/z in metres), or a gamepad, by motion \
                matching in a database of index. The report says how far from the path it was",
        files: &[
            input(
                "database",
                "The .mdb file; motions that are not packed within it are read again",
            ),
            option("on", true, "The character"),
            option("gamepad", false, "The sticks over time: .csv or .json"),
            option("output", true, "The file to write, in the format of its extension"),
        ],
        options: &["path", "speed"],
    },
    Tool {
        name: "graph",
        about: "Find all moments at which a figure can pass from one motion to another, for walk",
        files: &[
            inputs("Motions of one skeleton, or of humanoids with on; folders and wildcards too"),
            option("on", false, "A body on which all motions are put first"),
            option("output", true, "The graph to write: .json"),
            option(
                "matrix",
                false,
                "The distances of all moments of two motions to write besides: .png or .npy",
            ),
        ],
        options: &["threshold", "window", "rate", "whole", "unit", "up"],
    },
    Tool {
        name: "walk",
        about: "Write a motion that walks over a graph: for so many seconds, along a path in metres (0/0+4/0+4/6), or through \
                two clips or more (walk.bvh, turn.bvh@2)",
        files: &[
            input("graph", "The .json file of graph; its motions are read again"),
            option("on", false, "A character that the walk is put on"),
            option("output", true, "The file to write, in the format of its extension"),
        ],
        options: &["seconds", "path", "through", "seed"],
    },
    Tool {
        name: "convert",
        about: "Write a motion in another format: GLB, VRMA, FBX, BVH, packed clip",
        files: &[
            INPUTS,
            FileArgument {
                slot: Slot::OutputOrFolder,
                ..OUTPUT
            },
        ],
        options: &[
            "to",
            "clip",
            "from",
            "unit",
            "up",
            "map",
            "trim",
            "fps",
            "retime",
            "rest",
            "in-place",
            "root-motion",
            "names",
            "bone-axis",
            "target",
            "out-unit",
            "out-up",
            "skeleton-only",
            "max-error",
            "compress",
            "verify",
        ],
    },
    Tool {
        name: "retarget",
        about: "Put motions on a character (GLB, VRM, FBX, BVH), which keeps all that is in its file. The report says \
                how far limbs are off, and how feet slide",
        files: &[
            INPUTS,
            option("character", false, "The character"),
            option(
                "to-skeleton",
                false,
                "Instead of a character: a file of which the skeleton alone is taken",
            ),
            OUTPUT,
        ],
        options: &[
            "to",
            "clip",
            "from",
            "unit",
            "up",
            "map",
            "character-map",
            "trim",
            "fps",
            "in-place",
            "root-motion",
            "scale",
            "feet",
            "names-of-clips",
            "replace-animations",
            "max-angle",
            "max-error",
            "compress",
        ],
    },
    Tool {
        name: "robot",
        about: "Put motions of humans on a robot of URDF or MJCF, within the limits of its joints",
        files: &[
            INPUTS,
            option("robot", true, "The robot: .urdf, or .xml of MuJoCo"),
            OUTPUT,
        ],
        options: &[
            "to",
            "clip",
            "from",
            "unit",
            "up",
            "map",
            "robot-map",
            "trim",
            "fps",
            "scale",
            "feet",
            "passes",
            "floor",
            "velocity-limits",
            "require",
        ],
    },
    Tool {
        name: "edit",
        about: "Change a motion in steps, such as foot-lock, mirror, smooth:cut-off=8, loop, trim; mocap://steps lists \
                them with their options",
        files: &[INPUTS, WITH, OUTPUT],
        options: &[
            "step",
            "loop",
            "to",
            "clip",
            "from",
            "unit",
            "up",
            "map",
            "fps",
            "names",
            "max-error",
            "compress",
            "verify",
        ],
    },
    Tool {
        name: "clean",
        about: "Clean a motion of a camera or a generator: time, flips, noise, lengths, floor, contacts; the report has \
                measures before and after",
        files: &[INPUTS, OUTPUT],
        options: &[
            "only",
            "without",
            "to",
            "clip",
            "from",
            "unit",
            "up",
            "map",
            "fps",
            "max-error",
            "verify",
        ],
    },
    Tool {
        name: "sheet",
        about: "See motions: a picture of poses over time, a row for each file, or of the T-pose",
        files: &[
            inputs("Motion files"),
            option("output", false, "A .png or .svg to write besides"),
        ],
        options: &["poses", "width", "t-pose", "clip", "from", "up"],
    },
    Tool {
        name: "verify",
        about: "Compare a written file with its source: how far every joint is off in every frame",
        files: &[
            input("source", "The source"),
            input("result", "The file that was made of it"),
            WITH,
        ],
        options: &["max-error", "clip"],
    },
    Tool {
        name: "run",
        about: "Do a job: read, source, steps, onto, write, with every option that there is",
        files: &[],
        options: &[],
    },
];

/// The tool that a call names, and its arguments.
pub(super) fn named(params: &Value) -> Result<(&'static Tool, Map<String, Value>), Fault> {
    let name = params["name"].as_str().unwrap_or_default();
    let shown: String = name.chars().take(64).collect();
    let tool = TOOLS.iter().find(|tool| tool.tool_name() == name);
    let tool = tool.ok_or_else(|| {
        let names: Vec<&str> = TOOLS.iter().map(Tool::tool_name).collect();
        Fault::invalid_params(format!("there is no tool {shown:?}; there are {}", names.join(", ")))
    })?;
    match params.get("arguments") {
        None | Some(Value::Null) => Ok((tool, Map::new())),
        Some(Value::Object(arguments)) => Ok((tool, arguments.clone())),
        Some(_) => Err(Fault::invalid_params("\"arguments\" must be an object")),
    }
}

impl Tool {
    /// The name under which a client calls it.
    pub(super) fn tool_name(&self) -> &'static str {
        match self.name {
            // What it does for an agent.
            "info" => "inspect",
            name => name,
        }
    }

    /// The words of the command line that name its command.
    pub(super) fn command(&'static self) -> &'static [&'static str] {
        match self.name {
            "walk" => &["graph", "walk"],
            _ => std::slice::from_ref(&self.name),
        }
    }

    /// Whether a call may write.
    pub(super) fn writes(&self) -> bool {
        self.name == "run" || self.files.iter().any(|file| file.name == "output")
    }
}
