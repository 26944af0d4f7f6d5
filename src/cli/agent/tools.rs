//! The tools. Each is a command with the files and the options that an agent needs. A job for `run` has all other
//! options. Two tools have no command: `list` shows a folder, and `read` reads a resource for clients that only support
//! tools.

use serde_json::{Map, Value};

use super::answers;
use super::protocol::Fault;

/// A tool of the server.
pub struct Tool {
    /// The name of the tool: its command, or the command's last word.
    pub name: &'static str,
    /// The description for the model of a client.
    pub(super) about: &'static str,
    pub(super) files: &'static [FileArgument],
    /// The options of the command that the tool has, by their long names.
    pub options: &'static [&'static str],
    /// The JSON Schema of the tool's answer.
    pub(super) answer: fn() -> Value,
}

/// An argument that names files.
pub(super) struct FileArgument {
    pub(super) name: &'static str,
    pub(super) slot: Slot,
    pub(super) is_list: bool,
    pub(super) is_required: bool,
    pub(super) about: &'static str,
}

/// The position of files on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// Without an option, as a plain argument.
    Position,
    /// With the option of the argument's name.
    Option,
    /// The output of `convert`: without an option, or with `--output` if the output is a folder.
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
    "The file to write; its extension is its format. With / at its end, a folder",
);

const INPUTS: FileArgument = inputs("Motions; folders too if the output is one");

const WITH: FileArgument = FileArgument {
    is_list: true,
    ..option("with", false, "Second motions that steps join or blend")
};

/// All tools of the server.
pub const TOOLS: &[Tool] = &[
    Tool {
        name: "list",
        about: "List the files in a folder and its subfolders that mocap reads, with format and size",
        files: &[option("folder", false, "A folder [default: the root folder]")],
        options: &[],
        answer: answers::listed,
    },
    Tool {
        name: "info",
        about: "Inspect a file: format, joints, frames, clips, guesses, warnings",
        files: &[input("input", "The file")],
        options: &["clip", "from"],
        answer: answers::inspected,
    },
    Tool {
        name: "skeleton",
        about: "Show unit, axes, rest pose, and the joint of each bone, with confidence and reason",
        files: &[input("input", "The file")],
        options: &["clip", "unit", "up", "map", "explain"],
        answer: answers::skeleton,
    },
    Tool {
        name: "check",
        about: "Report errors and warnings of files, with line, column and remedy; the worst first",
        files: &[inputs("Files, folders and wildcards")],
        options: &["strict"],
        answer: answers::checked,
    },
    Tool {
        name: "survey",
        about: "Grade every clip of folders: verdict, quality from 0 to 1, defects and where they are, near-duplicates, \
                activity; the best first. Begin here to choose takes",
        files: &[
            inputs("Files, folders and wildcards; . is the root folder"),
            option("output", false, "A table to write: .csv, .json, .jsonl or .txt"),
            option("html", false, "A page to write for the user"),
        ],
        options: &["where", "select", "threshold", "fail-on"],
        answer: answers::surveyed,
    },
    Tool {
        name: "index",
        about: "Build a database of the frames of many motions, for find and match",
        files: &[
            inputs("Files, folders and wildcards"),
            option("output", true, "The database to write: .mdb"),
        ],
        options: &["mirror", "pack"],
        answer: answers::indexed,
    },
    Tool {
        name: "find",
        about: "Search a database of index for the frames most similar to a clip (like: walk.bvh@2.0s..3.5s) or a pose",
        files: &[input("database", "The .mdb file")],
        options: &["like", "pose", "count", "where"],
        answer: answers::found,
    },
    Tool {
        name: "match",
        about: "Move a character along a path by motion matching in a database of index",
        files: &[
            input("database", "The .mdb file"),
            option("on", true, "The character"),
            option("output", true, "The file to write"),
        ],
        options: &["path", "speed"],
        answer: answers::matched,
    },
    Tool {
        name: "graph",
        about: "Find all transitions between motions, for walk",
        files: &[
            inputs("Motions of one skeleton, or of humanoids with on; folders too"),
            option("on", false, "A body to which all motions are retargeted first"),
            option("output", true, "The graph to write: .json"),
            option(
                "matrix",
                false,
                "The file for the distance matrix of two motions: .png or .npy",
            ),
        ],
        options: &["threshold"],
        answer: answers::graphed,
    },
    Tool {
        name: "walk",
        about: "Write a walk through a graph: for some seconds, along a path, or \
                through two clips or more (walk.bvh, turn.bvh@2)",
        files: &[
            input("graph", "The .json file of graph"),
            option("on", false, "A character to which the walk is retargeted"),
            option("output", true, "The file to write"),
        ],
        options: &["seconds", "path", "through", "seed"],
        answer: answers::walked,
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
            "trim",
            "fps",
            "in-place",
            "names",
            "target",
            "max-error",
            "verify",
        ],
        answer: answers::written,
    },
    Tool {
        name: "retarget",
        about: "Retarget motions to a character (GLB, VRM, FBX, BVH). The character's file keeps all contents. \
                Reports for each motion whether it is good, and which limb has the largest error",
        files: &[
            INPUTS,
            option("character", false, "The character"),
            option("to-skeleton", false, "Instead of character: only this file's skeleton"),
            OUTPUT,
        ],
        options: &[
            "to",
            "clip",
            "unit",
            "up",
            "map",
            "character-map",
            "trim",
            "fps",
            "in-place",
            "scale",
            "feet",
            "replace-animations",
            "max-angle",
            "max-error",
        ],
        answer: answers::retargeted,
    },
    Tool {
        name: "robot",
        about: "Retarget human motion to a robot of URDF or MJCF, within its joint limits. Reports for each motion \
                whether it is good, and which limb has the largest error",
        files: &[
            INPUTS,
            option("robot", true, "The robot: .urdf, or .xml of MuJoCo"),
            OUTPUT,
        ],
        options: &[
            "to",
            "clip",
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
            "time-scale",
            "require",
        ],
        answer: answers::retargeted,
    },
    Tool {
        name: "edit",
        about: "Change a motion in steps, such as foot-lock, mirror, smooth:cut-off=8, loop, trim. read mocap://steps \
                lists them with their options",
        files: &[INPUTS, WITH, OUTPUT],
        options: &["step", "to", "clip", "unit", "up", "max-error", "verify"],
        answer: answers::written,
    },
    Tool {
        name: "clean",
        about: "Clean motion from video estimators, sensors and generators: time, flips, noise, lengths, floor, \
                contacts. Reports what each part changed",
        files: &[INPUTS, OUTPUT],
        options: &["only", "without", "to", "clip", "unit", "up", "max-error", "verify"],
        answer: answers::written,
    },
    Tool {
        name: "sheet",
        about: "Draw motions: a picture of poses over time, one row for each file, or of the T-pose",
        files: &[
            inputs("Motion files"),
            option("output", false, "A .png or .svg to write"),
        ],
        options: &["poses", "width", "t-pose", "clip"],
        answer: answers::drawn,
    },
    Tool {
        name: "verify",
        about: "Compare a file of convert, edit or clean with its source, joint by joint in every frame. For a motion \
                on another body, retarget reports the error",
        files: &[
            input("source", "The source"),
            input("result", "The file made from the source"),
            WITH,
        ],
        options: &["max-error"],
        answer: answers::verified,
    },
    Tool {
        name: "score",
        about: "Score a robot's motion, from any program, against its reference",
        files: &[
            input("source", "The reference: of a person, or of the robot in body"),
            input("result", "The robot's motion"),
            option("robot", true, "The robot: .urdf, or .xml of MuJoCo"),
            option("body", false, "The robot of the reference"),
        ],
        options: &[],
        answer: answers::scored,
    },
    Tool {
        name: "run",
        about: "Run a job, which has every option",
        files: &[],
        options: &[],
        answer: answers::run,
    },
    Tool {
        name: READ,
        about: "Read a report of an earlier call (mocap://reports/1), mocap://steps, mocap://formats or \
                mocap://job.schema.json",
        files: &[
            option("uri", true, "Its URI"),
            option("pointer", false, "The part to read, as a JSON Pointer: /clips/0"),
        ],
        options: &[],
        answer: answers::read,
    },
];

/// The tool that reads a resource.
pub(super) const READ: &str = "read";

/// The tool of a call, and its arguments.
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
    /// The name by which a client calls the tool.
    pub(super) fn tool_name(&self) -> &'static str {
        match self.name {
            // For agents, `mocap info` has the name `inspect`.
            "info" => "inspect",
            name => name,
        }
    }

    /// The words of the tool's command.
    pub(super) fn command(&'static self) -> &'static [&'static str] {
        match self.name {
            "walk" => &["graph", "walk"],
            // These tools have no command, and no options of a command.
            "list" | READ => &[],
            _ => std::slice::from_ref(&self.name),
        }
    }

    /// Whether the output may be a folder with one file for each input.
    pub(super) fn has_folder_outputs(&self) -> bool {
        ["convert", "retarget", "robot", "edit", "clean"].contains(&self.name)
    }

    /// Whether a call of the tool may write files.
    pub(super) fn writes(&self) -> bool {
        self.name == "run" || self.files.iter().any(|file| file.name == "output")
    }
}
