//! Tests every command and language with every written format and every kind of compression. Each cell works or has a
//! reason. The test writes `docs/doors.md`.

use std::fs;
use std::path::Path;

use mocap::arrays::BodyLayout;
use mocap::convert::RestPoseSource;
use mocap::figure::{BoneNames, Humanoid};
use mocap::gltf::Compression;
use mocap::job::{Job, RobotFormat};
use mocap::{Conversion, Exporter, Format, FormatInfo, MemoryFile, Scene, WriteOption};

use crate::at_root;
use crate::cut;
use crate::program::{Folder, words};
use crate::sample::Sample;

/// The commands that write motions, each with the words before the options of the output.
const COMMANDS: [(&str, &str); 6] = [
    ("`convert`", "convert walk.bvh OUT"),
    ("`edit`", "edit walk.bvh -o OUT --step smooth"),
    ("`clean`", "clean walk.bvh -o OUT"),
    ("`retarget` on a `.glb` character", "retarget walk.bvh hero.glb -o OUT"),
    (
        "`retarget --to-skeleton`",
        "retarget walk.bvh --to-skeleton body.bvh -o OUT",
    ),
    ("`robot`", "robot walk.bvh --robot robot.urdf -o OUT"),
];

/// The files that the commands name besides the motion.
const FILES: [(&str, &str); 3] = [
    ("hero.glb", "fixtures/characters/human_default.glb"),
    ("body.bvh", "fixtures/skeletons/xsens_names_tpose.bvh"),
    ("robot.urdf", "fixtures/robots/h1.urdf"),
];

/// The folder with the inputs. The motion has only its first frames.
fn folder() -> Folder {
    const FRAMES: usize = 12;
    let folder = Folder::with(&[]);
    folder.write("walk.bvh", cut::first_frames("real/cmu_short.bvh", FRAMES).as_bytes());
    for (name, file) in FILES {
        folder.write(name, &fs::read(at_root(file)).unwrap());
    }
    folder
}

/// A row of the table: the name of the output, and its options.
struct Row {
    output: String,
    options: String,
}

impl Row {
    fn name(&self) -> String {
        let extension = self.output.trim_start_matches("out");
        format!("`{extension} {}`", self.options).replace(" `", "`")
    }

    /// A message without the name of the output.
    fn without_names(&self, message: &str) -> String {
        let message = message.replace(&self.output, "OUT");
        match self.options.strip_prefix("--to ") {
            Some(format) => message.replace(format, "NAME"),
            None => message,
        }
    }
}

/// Every written format: plain, with an error bound, with other names and another rest pose, and with every kind of
/// compression in its row. Then the outputs of characters and robots.
fn rows() -> Vec<Row> {
    let row = |extension: &str, options: String| Row {
        output: format!("out.{extension}"),
        options,
    };
    let mut rows = Vec::new();
    for format in FormatInfo::ALL.iter().filter(|format| format.writes()) {
        for extension in format.extensions {
            rows.push(row(extension, String::new()));
            if format.takes(WriteOption::MaxError) {
                rows.push(row(extension, "--max-error 1mm".to_owned()));
            }
            if format.takes(WriteOption::Names) {
                rows.push(row(extension, "--names unreal".to_owned()));
            }
            if format.takes(WriteOption::Rest) {
                rows.push(row(extension, "--rest t-pose".to_owned()));
                rows.push(row(extension, "--t-pose-first".to_owned()));
            }
            let kinds = Compression::ALL.iter().filter(|_| format.takes(WriteOption::Compress));
            rows.extend(kinds.map(|kind| row(extension, format!("--compress {}", kind.as_str()))));
        }
    }
    rows.push(row("vrm", String::new()));
    let bodies = BodyLayout::ALL.into_iter();
    rows.extend(bodies.map(|layout| row(layout.extension(), format!("--to {}", layout.as_str()))));
    rows.extend(
        RobotFormat::ALL
            .into_iter()
            .map(|format| match format.name() == format.extension() {
                true => row(format.extension(), String::new()),
                false => row(format.extension(), format!("--to {}", format.name())),
            }),
    );
    rows
}

/// The result of a cell: `None` if it works, or else the reason.
type Cell = Option<String>;

/// Runs a command, and then its printed job on a disk and in memory.
fn cell(folder: &Folder, row: &Row, command: &str) -> Cell {
    let line = format!("{} {}", command.replace("OUT", &row.output), row.options);
    let line = line.trim();
    remove_output(folder, row);
    let done = folder.run(line);
    let made = fs::read(folder.path(&row.output)).ok();
    assert_eq!(done.status.success(), made.is_some(), "{line}: {}", words(&done));
    if made.is_none() {
        return Some(row.without_names(&reason(&words(&done))));
    }
    let printed = folder.run(&format!("{line} --print-job"));
    let job = String::from_utf8(printed.stdout).unwrap();
    folder.write("job.json", job.as_bytes());
    remove_output(folder, row);
    folder.succeeds("run job.json");
    assert!(folder.read(&row.output) == made.clone().unwrap(), "{line}: mocap run");
    let files = ["walk.bvh", "hero.glb", "body.bvh", "robot.urdf"].map(|name| (name, folder.read(name)));
    let files = files.each_ref().map(|(name, bytes)| MemoryFile { name, bytes });
    let (written, _) = Job::from_json(&job).unwrap().run_in_memory(&files).unwrap();
    let bytes = written.files.last().unwrap().bytes().into_owned();
    assert!(bytes == made.unwrap(), "{line}: in memory");
    None
}

/// Removes an output, and the buffer of a `.gltf`, whose writer would be unknown without the `.gltf`.
fn remove_output(folder: &Folder, row: &Row) {
    for name in [row.output.as_str(), "out.bin"] {
        let _ = fs::remove_file(folder.path(name));
    }
}

/// The reason why a command stopped. A build without a feature does not change the table.
fn reason(said: &str) -> String {
    let line = said.lines().rfind(|line| line.contains("error")).unwrap_or(said);
    let (_, message) = line.split_once(": ").unwrap_or(("", line));
    // Remove the remedy from the reason.
    let message = message.split("; did you mean ").next().unwrap();
    let message = message.split("; mocap ").next().unwrap();
    // Escape the names of values, so that they are not HTML tags in a page.
    message.replace('|', "\\|").replace(['<', '>'], "")
}

/// Writes a scene as Rust's `Exporter` and JavaScript's `write` do: the row of the format, its rejected options, and
/// the writer.
fn by_call(scene: &Scene, row: &Row) -> Cell {
    let path = Path::new(&row.output);
    let extension = path.extension().unwrap().to_str().unwrap();
    let Some(format) = FormatInfo::of_output(path) else {
        return Some(format!("the writer accepts {}", FormatInfo::written_extensions()));
    };
    let (mut exporter, mut option) = (Exporter::new(), None);
    let mut scene = scene.clone();
    let conversion = Conversion::new().keep_units(true);
    match row.options.split(' ').collect::<Vec<_>>()[..] {
        ["--max-error", _] => (exporter, option) = (exporter.max_error(0.001), Some(WriteOption::MaxError)),
        ["--compress", kind] => {
            (exporter, option) = (exporter.compression(kind.parse().unwrap()), Some(WriteOption::Compress));
        }
        ["--names", names] => {
            let bones = Humanoid::of(&scene);
            let names = BoneNames::named(names).unwrap().names();
            mocap::figure::name_joints(&mut scene, &bones, &names).unwrap();
            option = Some(WriteOption::Names);
        }
        ["--rest", _] => {
            conversion.rest(RestPoseSource::TPose).apply(&mut scene).unwrap();
            option = Some(WriteOption::Rest);
        }
        ["--t-pose-first"] => {
            conversion.t_pose_first(true).apply(&mut scene).unwrap();
        }
        _ => {}
    }
    if let Some(refusal) = option.and_then(|option| format.refusal(option, extension)) {
        return Some(refusal.message);
    }
    let written = exporter.write_as(&scene, path);
    written.err().map(|error| error.diagnostic().message.clone())
}

/// Whether a row needs a feature that this build lacks. The published table then keeps the result of a build with the
/// feature.
fn is_left_out(row: &Row) -> bool {
    !cfg!(feature = "meshopt") && row.options.contains("meshopt")
}

/// The table, and the reasons of cells that do not work.
fn table(cells: &[(Row, Vec<Cell>)]) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    let mut text = format!(
        "| output | {} | Rust's `Exporter`, JavaScript's `write` |\n|---|{}\n",
        COMMANDS.map(|(name, _)| name).join(" | "),
        "---|".repeat(COMMANDS.len() + 1)
    );
    // Merge consecutive rows with the same cells.
    for rows in cells.chunk_by(|(_, one), (_, next)| one == next) {
        let names: Vec<String> = rows.iter().map(|(row, _)| row.name()).collect();
        text += &format!("| {} |", names.join(", "));
        for cell in &rows[0].1 {
            match cell {
                None => text += " yes |",
                Some(reason) => {
                    let known = reasons.iter().position(|known| known == reason);
                    let index = known.unwrap_or_else(|| {
                        reasons.push(reason);
                        reasons.len() - 1
                    });
                    text += &format!(" no ({}) |", index + 1);
                }
            }
        }
        text += "\n";
    }
    text += "\nThe messages of the refusals; NAME is the format of `--to`:\n\n| number | message |\n|---|---|\n";
    for (index, reason) in reasons.iter().enumerate() {
        text += &format!("| {} | {reason} |\n", index + 1);
    }
    text
}

const HEAD: &str = "# Commands and languages by output format

The first table shows which commands and calls write which outputs. A number refers to the message of a refusal.
`MOCAP_WRITE=1 cargo test --features meshopt --test it doors` runs each cell, and writes this page.

Each combination marked \"yes\" can also run as a job: the command with its options, as JSON. `--print-job` prints
this job. In every language, the job gives the same bytes:

- `mocap run`, `mocap.run` in Python and `mocap_run` in C read the input files from the disk.
- `run` in JavaScript reads the input files from memory.

Python's `mocap.convert` writes the same formats as the command `convert`. `--compress meshopt` and `meshopt-khr` need
the feature `meshopt`.

";

/// The cells of a row of the published table; `None` without such a row.
fn published(text: &str, row: &Row) -> Option<Vec<Cell>> {
    let names = |line: &str| {
        line.strip_prefix("| ")?
            .split_once(" |")
            .map(|(names, _)| names.to_owned())
    };
    let name = row.name();
    let line = text
        .lines()
        .find(|line| names(line).is_some_and(|names| names.split(", ").any(|other| other == name)))?;
    let cells = line.trim_matches('|').split('|').skip(1).map(str::trim);
    let reason = |number: &str| {
        let start = format!("| {number} | ");
        let message = text.lines().find_map(|line| line.strip_prefix(&start))?;
        Some(message.strip_suffix(" |")?.to_owned())
    };
    let cell = |cell: &str| match cell.strip_prefix("no (").and_then(|cell| cell.strip_suffix(')')) {
        Some(number) => Some(reason(number).unwrap_or_default()),
        None => (cell != "yes").then(|| cell.to_owned()),
    };
    Some(cells.map(cell).collect())
}

/// For each command, the equivalent calls in each language, or an empty text. The Rust library has an equivalent of
/// every command.
const CALLS: [(&str, [&str; 4]); 29] = [
    // Command, Python, C and C++, JavaScript, a tool of `mocap mcp`.
    (
        "convert",
        ["convert run", "mocap_convert mocap_run", "convert write run", "convert"],
    ),
    (
        "retarget",
        [
            "retarget run",
            "mocap_retargeter_new mocap_run",
            "retarget run",
            "retarget",
        ],
    ),
    (
        "robot",
        [
            "Robot.retarget Robot.stream run",
            "mocap_robot_stream_new mocap_run",
            "robotMotion run",
            "robot",
        ],
    ),
    ("edit", ["edit.apply run", "mocap_edit mocap_run", "edit run", "edit"]),
    ("clean", ["edit.clean run", "mocap_edit mocap_run", "edit run", "clean"]),
    ("solve", ["read", "mocap_run", "read", "run"]),
    ("run", ["run", "mocap_run", "run", "run"]),
    ("graph", ["graph run", "mocap_run", "run", "graph walk"]),
    ("index, find", ["index Database.find", "", "", "index find"]),
    ("match", ["", "mocap_controller_new", "controller", "match"]),
    ("record, play, bridge", ["", "", "", ""]),
    ("view", ["Scene.show", "", "toPlayer", ""]),
    ("info", ["Scene.metadata", "mocap_report", "toJson", "inspect"]),
    ("skeleton", ["Scene.figure", "mocap_report", "toJson", "skeleton"]),
    ("sheet", ["Scene.sheet", "", "toPng", "sheet"]),
    ("gif", ["", "", "", ""]),
    ("plot", ["Scene.plot", "", "", ""]),
    (
        "fk",
        ["Scene.to_numpy Scene.to_smpl", "mocap_world_matrices", "toCsv", ""],
    ),
    ("angles", ["Scene.joint_angles", "mocap_table_new", "jointAngles", ""]),
    ("gait", ["Scene.gait", "mocap_report", "gait", ""]),
    ("forces", ["Scene.ground_forces", "mocap_table_new", "groundForces", ""]),
    ("analog", ["Scene.analog", "mocap_table_new", "analog", ""]),
    ("pack", ["Scene.to_arrow table write_dataset", "", "", ""]),
    ("pose", ["Scene.pose", "mocap_world_matrices", "pose", ""]),
    ("chain", ["Scene.chain", "", "chain", ""]),
    ("check", ["Scene.warnings", "mocap_warning_text", "check", "check"]),
    ("survey", ["survey", "mocap_run", "run", "survey"]),
    ("verify", ["", "mocap_verify", "", "verify"]),
    ("score", ["Robot.score", "mocap_score", "score", "score"]),
];

/// The files that declare the calls of each language.
const DECLARED: [&str; 4] = [
    "tools/python/python/mocap",
    "tools/capi/mocap.h",
    "tools/wasm/package/index.d.ts",
    "docs/agents.md",
];

/// The table of [`CALLS`].
fn calls() -> String {
    let mut text = "\n## Commands in other languages\n\n\
        The table lists the calls that do the same as a command in other languages. `run` executes a job. A job has the options\n\
        of `convert`, `retarget`, `robot`, `edit`, `clean`, surveys and graphs. If a job reads a file with the option `joints`\n\
        or `markers`, it computes a skeleton, like `mocap solve`. The Rust library has all of these functions.\n\n\
        | command | Python | C and C++ | JavaScript | agents |\n|---|---|---|---|---|\n"
        .to_owned();
    for (command, cells) in CALLS {
        let cells = cells.map(|calls| match calls {
            "" => "no".to_owned(),
            _ => calls
                .split(' ')
                .map(|call| format!("`{call}`"))
                .collect::<Vec<_>>()
                .join(", "),
        });
        text += &format!("| {command} | {} |\n", cells.join(" | "));
    }
    text
}

/// Every call of the second table is declared in its language, and every command is in the table.
#[test]
fn what_does_the_work_of_a_command_is_there() {
    let declared = DECLARED.map(at_root).map(|path| match Path::new(&path).is_dir() {
        false => fs::read_to_string(path).unwrap(),
        true => fs::read_dir(path)
            .unwrap()
            .filter_map(|entry| fs::read_to_string(entry.unwrap().path()).ok())
            .collect(),
    });
    for (command, cells) in CALLS {
        for ((calls, declared), language) in cells.into_iter().zip(&declared).zip(["def", "(", "(", "`"]) {
            for call in calls.split_whitespace() {
                let name = call.rsplit('.').next().unwrap();
                let is_there = match language {
                    "def" => declared.contains(&format!("def {name}(")),
                    "`" => declared.contains(&format!("`{name}`")),
                    _ => declared.contains(&format!("{name}(")),
                };
                assert!(is_there, "{command}: {call}");
            }
        }
    }
    assert!(
        fs::read_to_string(at_root("docs/doors.md"))
            .unwrap()
            .ends_with(&calls())
    );
    // The shown commands, except commands that print lists.
    let help = String::from_utf8(Folder::with(&[]).run("--help").stdout).unwrap();
    let (help, _) = help.split_once("\nExamples:").unwrap();
    let named =
        |line: &str| Some(line.strip_prefix("  ")?.split(' ').next()?.to_owned()).filter(|name| !name.is_empty());
    for name in help
        .lines()
        .filter_map(named)
        .filter(|name| name.starts_with(|letter: char| letter.is_ascii_lowercase()))
    {
        let is_listed = CALLS
            .iter()
            .any(|(command, _)| command.split(", ").any(|own| own == name));
        let is_own = [
            "formats",
            "doctor",
            "merge-manifest",
            "dump",
            "mcp",
            "completions",
            "man",
        ]
        .contains(&name.as_str());
        assert!(is_listed || is_own, "{name}");
    }
}

/// Each cell of `docs/doors.md` works or has the stated reason. The test tries some rows, or all rows with `MOCAP_ALL`.
#[test]
fn every_door_writes_every_format_or_says_why_not() {
    let folder = folder();
    let mut scene = mocap::import(folder.path("walk.bvh")).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let writes = std::env::var_os("MOCAP_WRITE").is_some();
    let rows = rows().into_iter().filter(|row| !is_left_out(row)).collect::<Vec<_>>();
    let rows = match writes {
        true => rows,
        false => Sample::new().some(rows, 12),
    };
    let tried = rows.into_iter().map(|row| {
        let commands = COMMANDS.iter().map(|(_, command)| cell(&folder, &row, command));
        let cells = commands.chain([by_call(&scene, &row)]).collect();
        (row, cells)
    });
    let tried: Vec<(Row, Vec<Cell>)> = tried.collect();
    let path = &at_root("docs/doors.md");
    if writes && cfg!(feature = "meshopt") {
        fs::write(path, format!("{HEAD}{}{}", table(&tried), calls())).unwrap();
    }
    let text = fs::read_to_string(path).unwrap();
    assert!(text.starts_with(HEAD));
    for (row, cells) in &tried {
        let command = "MOCAP_WRITE=1 cargo test --features meshopt --test it doors writes it";
        assert_eq!(published(&text, row).as_ref(), Some(cells), "{}: {command}", row.name());
    }
}

/// The cells of other languages match their functions.
#[test]
fn other_languages_call_what_the_table_tries() {
    for (file, call) in [
        ("tools/python/src/run.rs", "job.run()"),
        ("tools/capi/src/run.rs", "job.run()"),
        ("tools/wasm/src/request.rs", "job.run_in_memory("),
        ("tools/python/src/convert.rs", "maker.make("),
        ("tools/wasm/src/writing.rs", "FormatInfo::of_output("),
        ("tools/wasm/src/request.rs", "name_joints("),
        ("tools/wasm/src/options.rs", ".conversion()"),
    ] {
        assert!(
            fs::read_to_string(at_root(file)).unwrap().contains(call),
            "{file}: {call}"
        );
    }
}

/// The outputs of commands in formats that the library's `Exporter` does not write.
const WRITTEN_BY_COMMANDS: [(Format, &str, &str); 6] = [
    (Format::Npz, "yes: [arrays](arrays.md#written-layouts)", "`robot`, `fk`"),
    (Format::Npy, "yes: HumanML3D", "`fk`"),
    (Format::Pickle, "only motions of robots", "`robot`"),
    (
        Format::Parquet,
        "yes, with the feature `parquet`",
        "`fk`, `pack`, `forces`, `analog`",
    ),
    (Format::Csv, "yes", "`robot`, `fk`, `angles`, `forces`, `analog`"),
    (Format::Mot, "no", "`angles`, `forces`, `analog`"),
];

/// The row of a VRM character. For the library, the file is a glTF.
const VRM_ROW: &str = "| VRM | `.vrm` | as glTF, with the bones that the file states | only from a VRM file | \
                       `retarget`, on a VRM character |\n";

/// The table of formats in the book consists of the rows of `FormatInfo` and of the formats that only commands write.
#[test]
fn the_book_has_the_table_of_formats() {
    let (start, end) = ("<!-- formats -->\n", "<!-- end of formats -->");
    let mut made =
        "| format | files | read | written by `convert` | written by other commands |\n|---|---|---|---|---|\n"
            .to_owned();
    for row in FormatInfo::ALL {
        let extensions = row.extensions.iter().map(|extension| format!("`.{extension}`"));
        let extensions = Vec::from_iter(extensions).join(", ");
        let name = row.name.trim_start_matches("a ");
        let elsewhere = WRITTEN_BY_COMMANDS.iter().find(|(format, ..)| *format == row.format);
        let (convert, others) = match elsewhere {
            Some((_, convert, others)) => (*convert, *others),
            None if row.writes() => (row.writing, "`edit`, `retarget` and others"),
            None => (row.writing, "no"),
        };
        made += &format!("| {name} | {extensions} | {} | {convert} | {others} |\n", row.reading);
        if row.format == Format::Gltf {
            made += VRM_ROW;
        }
        assert_eq!(row.writing.starts_with("no"), !row.writes(), "{name}");
        assert!(!row.reads || !row.reading.starts_with("no"), "{name}");
    }
    let text = fs::read_to_string(at_root("docs/formats.md")).unwrap();
    let (before, rest) = text.split_once(start).unwrap();
    let (_, after) = rest.split_once(end).unwrap();
    let whole = format!("{before}{start}{made}{end}{after}");
    if std::env::var_os("MOCAP_WRITE").is_some() {
        fs::write(at_root("docs/formats.md"), &whole).unwrap();
    }
    assert!(
        text == whole || std::env::var_os("MOCAP_WRITE").is_some(),
        "MOCAP_WRITE=1 cargo test --test it doors writes it"
    );
}
