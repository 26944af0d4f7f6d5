//! The output of `--json` of every command fits `docs/json.schema.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use clap::{Command, CommandFactory};
use mocap_cli::internals::{Args, schema};
use serde_json::{Map, Value};

use crate::program::{Folder, command_in};
use crate::published_schema::shorten;
use crate::{at_root, cut};

const DOCUMENT: &str = "../../docs/json.schema.json";

/// Commands without `--json`: the protocol of `mcp` is already JSON.
const WITHOUT: [&str; 1] = ["mcp"];

/// A command line for each shape of output.
const LINES: [&str; 41] = [
    "convert walk.bvh a.glb --json --max-error 1mm --verify",
    "convert walk.bvh a.npz --json --to amass",
    "solve markers.c3d solved.bvh --json",
    "clean walk.bvh -o cleaned.bvh --json",
    "run job.json --json",
    "graph walk.bvh -o graph.json --threshold 10cm --json",
    "graph walk graph.json --seconds 1 -o walked.bvh --json",
    "retarget walk.bvh hero.glb -o hero_walk.glb --json",
    "robot walk.bvh --robot h1.urdf -o robot.npz --trim 0..0.2 --json",
    "edit walk.bvh -o edited.bvh --step foot-lock --step loop --step mirror --step smooth:cut-off=6 --json",
    "edit walk.bvh run.bvh -o joined.bvh --step concat --step clean --json",
    "info walk.bvh --json",
    "info markers.c3d --markers auto --json",
    "fk walk.bvh -o a.csv --json",
    "angles walk.bvh -o a.mot --json",
    "gait walk.bvh --json",
    "forces plates.c3d -o forces.csv --json",
    "analog plates.c3d -o analog.csv --json",
    "pack walk.bvh run.bvh -o packed --json",
    "merge-manifest packed --json",
    "pose walk.bvh --tick 3 --json",
    "chain walk.bvh LeftHand --point 0.5,0,0 --json",
    "skeleton walk.bvh --explain --json",
    "check walk.bvh broken.bvh warned.bvh --json",
    "survey walk.bvh run.bvh --json",
    "index walk.bvh run.bvh -o moves.mdb --json",
    "find moves.mdb --like walk.bvh@10f..40f --json",
    "find moves.mdb --pose walk.bvh@10f --json",
    "match moves.mdb --path 0/0+0/1 --character hero.glb -o matched.glb --json",
    "dump walk.bvh --json",
    "verify walk.bvh whole.glb --json",
    "verify walk.bvh other.glb --json",
    "score walk.bvh robot.npz --robot h1.urdf --json",
    "view walk.bvh -o a.html --json",
    "sheet walk.bvh -o a.png --json",
    "gif walk.bvh -o a.gif --width 64 --height 48 --rate 5 --json",
    "plot walk.bvh --joint Head -o a.svg --json",
    "formats --json",
    "doctor --json",
    "completions bash --json",
    "man convert --json",
];

fn folder() -> Folder {
    let folder = Folder::of_real(&[]);
    for (name, file) in [
        ("hero.glb", "fixtures/characters/human_default.glb"),
        ("h1.urdf", "fixtures/robots/h1.urdf"),
        ("markers.c3d", "fixtures/markers/cmu_01_01.c3d"),
        ("plates.c3d", "fixtures/made/plates.c3d"),
        ("walk.bvh", "fixtures/real/cmu_12_01_walk.bvh"),
        ("warned.bvh", "fixtures/real/brekel_wrong_row_length.bvh"),
    ] {
        folder.write(name, &fs::read(at_root(file)).unwrap());
    }
    const FRAMES: usize = 240;
    folder.write(
        "run.bvh",
        cut::first_frames("real/cmu_12_01_walk.bvh", FRAMES).as_bytes(),
    );
    folder.write("broken.bvh", b"HIERARCHY\nROOT");
    let job =
        r#"{"source": {"inputs": ["walk.bvh"]}, "steps": ["mirror"], "write": {"output": "job.bvh"}, "verify": true}"#;
    folder.write("job.json", job.as_bytes());
    folder.succeeds("convert walk.bvh whole.glb");
    folder.succeeds("edit walk.bvh -o mirrored.bvh --step mirror");
    folder.succeeds("convert mirrored.bvh other.glb");
    folder
}

fn published() -> Value {
    let mut schema = schema();
    shorten(&mut schema);
    schema
}

/// `MOCAP_WRITE=1` writes the file.
#[test]
fn the_published_schema_of_json_is_that_of_the_types() {
    let text = serde_json::to_string_pretty(&published()).unwrap() + "\n";
    if std::env::var_os("MOCAP_WRITE").is_some() {
        fs::write(DOCUMENT, &text).unwrap();
    }
    let command = "MOCAP_WRITE=1 cargo test -p mocap-cli --features parquet,schema json_schema writes it";
    assert!(fs::read_to_string(DOCUMENT).unwrap() == text, "{command}");
}

/// `MOCAP_WRITE=1` writes the table, and keeps its units. A person replaces the `?` of a new key by its unit.
#[test]
fn the_page_of_robot_reports_has_every_key() {
    let path = at_root("docs/robots-report-keys.md");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once("<!-- keys -->\n").unwrap();
    let (rows, after) = rest.split_once("<!-- end of keys -->").unwrap();
    let units: BTreeMap<&str, &str> = rows
        .lines()
        .filter_map(|row| row.strip_prefix("| `")?.split_once("` | "))
        .map(|(key, rest)| (key, rest.split(" | ").next().unwrap()))
        .collect();
    let schema = published();
    let mut table = "| key | unit | meaning |\n|---|---|---|\n".to_owned();
    for (key, meaning) in keys_of(&schema["$defs"]["RobotReport"], &schema) {
        let unit = units.get(key.as_str()).unwrap_or(&"?");
        table += &format!("| `{key}` | {unit} | {meaning} |\n");
    }
    let expected = format!("{before}<!-- keys -->\n{table}<!-- end of keys -->{after}");
    if std::env::var_os("MOCAP_WRITE").is_some() {
        fs::write(&path, &expected).unwrap();
    }
    let command = "MOCAP_WRITE=1 cargo test -p mocap-cli --features parquet,schema json_schema writes it";
    assert!(fs::read_to_string(&path).unwrap() == expected, "{path}: {command}");
    assert!(!expected.contains("| ? |"), "{path}: a key has no unit");
}

/// The keys of an object and of the objects inside, each with its description: `limbs`, `limbs[].bone`.
fn keys_of(object: &Value, schema: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (name, property) in object["properties"].as_object().unwrap() {
        found.push((name.clone(), property["description"].as_str().unwrap().to_owned()));
        let inner = property.get("anyOf").map_or(property, |kinds| &kinds[0]);
        let (inner, joint) = inner.get("items").map_or((inner, "."), |items| (items, "[]."));
        let Some(pointer) = inner["$ref"].as_str() else {
            continue;
        };
        let inner = schema.pointer(pointer.trim_start_matches('#')).unwrap();
        if inner.get("properties").is_some() {
            let inner = keys_of(inner, schema).into_iter();
            found.extend(inner.map(|(key, meaning)| (format!("{name}{joint}{key}"), meaning)));
        }
    }
    found
}

#[test]
fn every_command_has_json_and_a_schema() {
    fn add(command: &Command, words: &str, found: &mut BTreeSet<String>) {
        for command in command.get_subcommands().filter(|command| command.get_name() != "help") {
            let words = format!("{words} {}", command.get_name()).trim().to_owned();
            add(command, &words, found);
            let has_json = command.get_arguments().any(|arg| arg.get_long() == Some("json"));
            assert_eq!(has_json, !WITHOUT.contains(&words.as_str()), "{words}");
            found.extend(has_json.then_some(words));
        }
    }
    let mut found = BTreeSet::new();
    add(&Args::command(), "", &mut found);
    let schema = schema();
    let known: BTreeSet<String> = schema["properties"].as_object().unwrap().keys().cloned().collect();
    assert_eq!(found, known);
    let streams = ["record", "play", "bridge"];
    let tried = LINES
        .iter()
        .map(|line| words_of(line, &known))
        .chain(streams.map(str::to_owned));
    assert_eq!(
        tried.collect::<BTreeSet<_>>(),
        known,
        "commands of which an output is tried"
    );
}

/// The command of a line.
fn words_of(line: &str, known: &BTreeSet<String>) -> String {
    let mut words = line.split(' ');
    let (first, second) = (words.next().unwrap(), words.next().unwrap());
    let both = format!("{first} {second}");
    if known.contains(&both) { both } else { first.to_owned() }
}

#[test]
fn what_is_printed_is_as_the_schema_says() {
    let (folder, schema) = (folder(), published());
    let known: BTreeSet<String> = schema["properties"].as_object().unwrap().keys().cloned().collect();
    let mut problems = Vec::new();
    for line in LINES {
        let ran = folder.run(line);
        let text = String::from_utf8(ran.stdout).unwrap();
        let values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
        let values: Vec<Value> = values.collect::<Result<_, _>>().unwrap();
        assert!(!values.is_empty(), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
        for value in values {
            let found = problem(&schema["properties"][words_of(line, &known)], &value, &schema);
            problems.extend(found.map(|found| format!("{line}: {found}")));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The two ends of a stream: playing to a recorder, and to a character.
#[test]
fn what_streams_print_is_as_the_schema_says() {
    let (folder, schema) = (folder(), published());
    folder.write("short.bvh", cut::first_frames("real/cmu_short.bvh", 20).as_bytes());
    for (command, line) in [
        ("record", "record vmc:0 -o take.bvh --json"),
        ("bridge", "bridge vmc:0 --character hero.glb --udp-json 9 --json"),
    ] {
        let mut listener = command_in(&folder.path(""), line);
        let mut listener = listener.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(listener.stderr.take().unwrap());
        let mut port = String::new();
        while port.is_empty() {
            let mut line = String::new();
            assert!(said.read_line(&mut line).unwrap() > 0, "{command}");
            let after = line.split_once("127.0.0.1:").map_or("", |(_, after)| after);
            port = after.chars().take_while(char::is_ascii_digit).collect();
        }
        let played = folder.run(&format!("play short.bvh --vmc {port} --json"));
        check(&schema, "play", &serde_json::from_slice(&played.stdout).unwrap());
        sleep(Duration::from_millis(100));
        let killed = std::process::Command::new("kill")
            .args(["-INT", &listener.id().to_string()])
            .status();
        assert!(killed.unwrap().success());
        let mut printed = String::new();
        listener.stdout.take().unwrap().read_to_string(&mut printed).unwrap();
        assert!(listener.wait().unwrap().success(), "{command}");
        let printed: Value = serde_json::from_str(&printed).unwrap();
        assert!(printed["packets"].as_u64() > Some(10), "{printed}");
        check(&schema, command, &printed);
    }
}

/// The test finds a value that violates the schema.
#[test]
fn the_check_finds_what_is_wrong() {
    let schema = published();
    let row = serde_json::json!({"output": "a.png", "width": 3, "height": 4, "bytes": 5});
    check(&schema, "plot", &row);
    let changes: [fn(&mut Map<String, Value>); 4] = [
        |row| drop(row.remove("bytes")),
        |row| row["width"] = "3".into(),
        |row| row["height"] = (-1).into(),
        |row| drop(row.insert("other".to_owned(), 1.into())),
    ];
    for change in changes {
        let mut wrong = row.clone();
        change(wrong.as_object_mut().unwrap());
        let found = problem(&schema["properties"]["plot"], &wrong, &schema);
        assert!(found.is_some(), "{wrong}");
    }
}

fn check(schema: &Value, command: &str, value: &Value) {
    if let Some(problem) = problem(&schema["properties"][command], value, schema) {
        panic!("{command}: {problem}");
    }
}

/// The first violation of the schema by a value, for the keywords of our schema. An unknown property is a violation:
/// the test fails if the schema lacks a property.
fn problem(schema: &Value, value: &Value, root: &Value) -> Option<String> {
    let Value::Object(keywords) = schema else {
        return (schema == &Value::Bool(false)).then(|| format!("{value} is not allowed"));
    };
    let all = |key: &str| {
        keywords
            .get(key)
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice)
    };
    let fits = |key: &str| {
        all(key)
            .iter()
            .filter(|schema| problem(schema, value, root).is_none())
            .count()
    };
    let wrong = |keyword: &str| Some(format!("{keyword}: {} of {schema}", short(value)));
    for (keyword, stated) in keywords {
        let found = match keyword.as_str() {
            "$ref" => {
                let pointer = stated.as_str().unwrap().trim_start_matches('#');
                problem(root.pointer(pointer).unwrap(), value, root)
            }
            "type" => {
                let types = stated.as_array().map_or(std::slice::from_ref(stated), Vec::as_slice);
                let is = |name: &Value| is_of_type(value, name.as_str().unwrap());
                if types.iter().any(is) { None } else { wrong("type") }
            }
            "enum" if !all("enum").contains(value) => wrong("enum"),
            "const" if stated != value => wrong("const"),
            "minimum" if value.as_f64().is_some_and(|own| Some(own) < stated.as_f64()) => wrong("minimum"),
            "maximum" if value.as_f64().is_some_and(|own| Some(own) > stated.as_f64()) => wrong("maximum"),
            "anyOf" if fits("anyOf") == 0 => wrong("anyOf"),
            "oneOf" if fits("oneOf") != 1 => wrong("oneOf"),
            "allOf" if fits("allOf") != all("allOf").len() => wrong("allOf"),
            "required" => value.as_object().and_then(|object| {
                let lacks = |name: &&Value| !object.contains_key(name.as_str().unwrap());
                all("required")
                    .iter()
                    .find(lacks)
                    .map(|name| format!("{name} is not in {}", short(value)))
            }),
            "properties" => value.as_object().and_then(|object| {
                let others = keywords.get("additionalProperties");
                object
                    .iter()
                    .find_map(|(name, inner)| match (stated.get(name), others) {
                        (Some(schema), _) | (None, Some(schema)) => {
                            problem(schema, inner, root).map(|problem| format!("{name}: {problem}"))
                        }
                        (None, None) => Some(format!("{name} is not in the schema")),
                    })
            }),
            "additionalProperties" if !keywords.contains_key("properties") => {
                let values = value.as_object().into_iter().flat_map(Map::values);
                values.into_iter().find_map(|value| problem(stated, value, root))
            }
            "items" => {
                let values = value.as_array().map_or(&[][..], Vec::as_slice);
                values
                    .iter()
                    .skip(all("prefixItems").len())
                    .find_map(|value| problem(stated, value, root))
            }
            "prefixItems" => {
                let values = value.as_array().map_or(&[][..], Vec::as_slice);
                std::iter::zip(all("prefixItems"), values).find_map(|(schema, value)| problem(schema, value, root))
            }
            "minItems" if length(value).is_some_and(|own| Some(own) < stated.as_u64()) => wrong("minItems"),
            "maxItems" if length(value).is_some_and(|own| Some(own) > stated.as_u64()) => wrong("maxItems"),
            "enum"
            | "const"
            | "minimum"
            | "maximum"
            | "anyOf"
            | "oneOf"
            | "allOf"
            | "additionalProperties"
            | "minItems"
            | "maxItems"
            | "title"
            | "description"
            | "format"
            | "default" => None,
            other => panic!("the keyword {other} is not checked"),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn length(value: &Value) -> Option<u64> {
    Some(value.as_array()?.len() as u64)
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("the type {other} is not known"),
    }
}

fn short(value: &Value) -> String {
    value.to_string().chars().take(200).collect()
}
