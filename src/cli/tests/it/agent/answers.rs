//! Compares the answers of the tools with the schemas in `tools/list`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use serde_json::{Value, json};

use super::{answers, call, error};
use crate::at_root;
use crate::program::{Folder, MANIFEST};

/// The largest size of the list of tools, in bytes. A client passes the whole list to its model in every session.
const MOST_BYTES: usize = 24_000;

/// The violations of a schema by a value. Supports the part of JSON Schema that the server uses.
fn faults(schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let known = ["type", "description", "properties", "required", "items", "enum"];
    let keys = schema.as_object().unwrap().keys();
    let mut faults: Vec<String> = keys
        .filter(|key| !known.contains(&key.as_str()))
        .map(|key| format!("{at}: this test does not know {key}"))
        .collect();
    let is_of_type = match schema["type"].as_str() {
        None => true,
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some(other) => panic!("{at}: an unknown type {other}"),
    };
    if !is_of_type {
        faults.push(format!("{at}: {value} is no {}", schema["type"]));
    }
    if let Some(values) = schema["enum"].as_array()
        && !values.contains(value)
    {
        faults.push(format!("{at}: {value} is none of {values:?}"));
    }
    let required = schema["required"].as_array().into_iter().flatten();
    for name in required.map(|name| name.as_str().unwrap()) {
        if value.get(name).is_none() {
            faults.push(format!("{at}: {name} is missing"));
        }
    }
    for (name, value) in value.as_object().into_iter().flatten() {
        if let Some(schema) = schema["properties"].get(name) {
            faults.extend(self::faults(schema, value, &format!("{at}/{name}")));
        }
    }
    if let Some(items) = schema.get("items") {
        for (index, value) in value.as_array().into_iter().flatten().enumerate() {
            faults.extend(self::faults(items, value, &format!("{at}/{index}")));
        }
    }
    faults
}

/// The schemas of the arguments and of the answer of each tool.
fn schemas(list: &Value) -> BTreeMap<&str, [&Value; 2]> {
    let mut schemas = BTreeMap::new();
    for tool in list["result"]["tools"].as_array().unwrap() {
        let name = tool["name"].as_str().unwrap();
        schemas.insert(name, [&tool["inputSchema"], &tool["outputSchema"]]);
    }
    schemas
}

/// Checks a successful answer: its content fits the schema, and equals the text.
fn check(schemas: &BTreeMap<&str, [&Value; 2]>, call: &Value, answer: &Value) {
    let tool = call["name"].as_str().unwrap();
    let [_, schema] = schemas[tool];
    let result = &answer["result"];
    let found = &result["structuredContent"];
    assert_eq!(faults(schema, found, tool), [""; 0], "{call}: {answer}");
    let text: Value = serde_json::from_str(result["content"][0]["text"].as_str().unwrap()).unwrap();
    assert_eq!(&text, found);
    assert!(!found.as_object().unwrap().values().any(Value::is_null), "{found}");
    // Only an error has the key `error`, with the reason.
    let is_error = result["isError"] == true;
    assert_eq!(found.get("problem").is_some(), is_error, "{call}: {answer}");
    assert!(found.get("error").is_none(), "{call}: {answer}");
}

fn with_takes() -> Folder {
    let folder = Folder::of_real(&[]);
    let files = [
        ("fixtures/real/cmu_12_01_walk.bvh", "takes/walk.bvh"),
        ("fixtures/real/cmu_short.bvh", "takes/short.bvh"),
        ("fixtures/real/rokoko_dance.bvh", "takes/dance.bvh"),
        ("fixtures/characters/human_default.glb", "hero.glb"),
        ("fixtures/robots/h1.urdf", "h1.urdf"),
    ];
    for (from, to) in files {
        folder.write(to, &fs::read(at_root(from)).unwrap());
    }
    folder
}

/// Makes the calls of `tools/mcp/calls.json`, which has every tool.
#[test]
fn every_answer_is_of_the_schema_of_its_tool() {
    let folder = with_takes();
    let calls: Value = serde_json::from_slice(&fs::read(at_root("tools/mcp/calls.json")).unwrap()).unwrap();
    let mut requests = vec![("tools/list", json!({}))];
    for line in calls.as_array().unwrap() {
        let (tool, arguments) = (line[0].as_str().unwrap(), &line[1]);
        // The answer of a dry run also fits the schema.
        if arguments["output"].is_string() {
            let mut dry = arguments.clone();
            dry["dry-run"] = true.into();
            requests.push(call(tool, dry));
        }
        requests.push(call(tool, arguments.clone()));
    }
    let found = answers(&folder, &requests);
    let schemas = schemas(&found[0]);
    let mut lines = calls.as_array().unwrap().iter();
    for (answer, (_, call)) in found.iter().zip(&requests).skip(1) {
        let [arguments, _] = schemas[call["name"].as_str().unwrap()];
        assert_eq!(faults(arguments, &call["arguments"], "arguments"), [""; 0], "{call}");
        let given = call["arguments"].as_object().unwrap().keys();
        for name in given {
            assert!(arguments["properties"].get(name).is_some(), "{call}: {name}");
        }
        assert_eq!(answer["result"]["isError"], false, "{call}: {answer}");
        check(&schemas, call, answer);
        if call["arguments"]["dry-run"] == true {
            continue;
        }
        for key in lines.next().unwrap()[2].as_array().unwrap() {
            let found = &answer["result"]["structuredContent"];
            assert!(found.get(key.as_str().unwrap()).is_some(), "{call}: no {key}: {found}");
        }
    }
    // Each property of a schema occurs in an answer.
    for [_, schema] in schemas.values() {
        let is_of_it = |call: &Value| call["name"].as_str().is_some_and(|tool| schemas[tool][1] == *schema);
        let of_it = found.iter().zip(&requests).filter(|(_, (_, call))| is_of_it(call));
        let contents: Vec<&Value> = of_it
            .map(|(answer, _)| &answer["result"]["structuredContent"])
            .collect();
        for property in schema["properties"].as_object().unwrap().keys() {
            let is_there = contents.iter().any(|content| content.get(property).is_some());
            assert!(is_there || property == "problem", "no answer has {property}: {schema}");
        }
    }
    let called: BTreeSet<&str> = requests[1..]
        .iter()
        .map(|(_, call)| call["name"].as_str().unwrap())
        .collect();
    assert_eq!(called, schemas.keys().copied().collect());
}

#[test]
fn the_list_of_tools_is_short() {
    let folder = Folder::of_real(&[]);
    let list = &answers(&folder, &[("tools/list", json!({}))])[0]["result"];
    let bytes = list.to_string().len();
    assert!(bytes <= MOST_BYTES, "{bytes} bytes");
    for tool in list["tools"].as_array().unwrap() {
        let (name, output) = (&tool["name"], &tool["outputSchema"]);
        assert_eq!(output["type"], "object", "{name}");
        assert!(output["properties"].is_object(), "{name}");
        for (option, schema) in tool["inputSchema"]["properties"].as_object().unwrap() {
            let about = schema["description"].as_str().unwrap();
            assert!(!about.is_empty() && !about.contains("--"), "{name}: {option}: {about}");
        }
    }
}

/// Broken files, and results that the arguments do not allow.
#[test]
fn answers_say_what_failed_and_what_is_worse_than_allowed() {
    let folder = with_takes();
    let text = String::from_utf8(folder.read("takes/short.bvh")).unwrap();
    folder.write("mixed/good.bvh", text.as_bytes());
    folder.write("mixed/wrong.bvh", text.replacen("Xposition", "Xpositon", 1).as_bytes());
    folder.write("robots/h1.urdf", &folder.read("h1.urdf"));
    let strict = json!({"inputs": ["takes/short.bvh"], "character": "hero.glb", "output": "a.glb", "max-angle": 0});
    let requests = [
        ("tools/list", json!({})),
        // Calls whose output is written, but worse than the arguments allow.
        call("retarget", strict.clone()),
        call(
            "retarget",
            json!({"inputs": ["mixed/good.bvh"], "character": "hero.glb", "output": "a/", "max-angle": 0}),
        ),
        call("convert", json!({"inputs": ["mixed"], "output": "b/"})),
        call("survey", json!({"inputs": ["mixed"], "fail-on": "bad"})),
        call(
            "verify",
            json!({"source": "takes/walk.bvh", "result": "takes/short.bvh"}),
        ),
        // Calls that ask for a report of problems.
        call("check", json!({"inputs": ["mixed"]})),
        // Calls without an output.
        call("inspect", json!({"input": "mixed/wrong.bvh"})),
        call("inspect", json!({"input": "none.bvh"})),
        call("index", json!({"inputs": ["robots"], "output": "moves.mdb"})),
        call(
            "convert",
            json!({"inputs": ["takes/short.bvh"], "output": "a.bvh", "nonsense": 1}),
        ),
        call("list", json!({"folder": "h1.urdf"})),
        call("list", json!({"path": "."})),
        call("read", json!({"uri": "mocap://nothing"})),
        call("read", json!({"uri": "mocap://steps", "pointer": "/none"})),
        call("inspect", json!({"input": "takes"})),
        call("sheet", json!({"inputs": ["takes/*.bvh"]})),
        call(
            "robot",
            json!({"inputs": ["takes"], "robot": "h1.urdf", "output": "one.npz"}),
        ),
        call("retarget", json!({"inputs": ["takes/short.bvh"], "output": "b.glb"})),
        call(
            "retarget",
            json!({"inputs": ["takes/short.bvh"], "character": "hero.vrm", "output": "b.glb"}),
        ),
        call("convert", json!({"inputs": ["takes/short.bvh"], "output": "new/b.glb"})),
    ];
    let found = answers(&folder, &requests);
    let schemas = schemas(&found[0]);
    let content = |index: usize| &found[index]["result"]["structuredContent"];
    for (answer, (_, call)) in found.iter().zip(&requests).skip(1).take(5) {
        assert_eq!(answer["result"]["isError"], true, "{answer}");
        check(&schemas, call, answer);
    }
    let problem = |index: usize| content(index)["problem"].as_str().unwrap();
    assert!(problem(1).contains("has an error of"), "{}", problem(1));
    assert!(problem(2).contains("larger errors"), "{}", problem(2));
    assert!(problem(3).contains("wrong.bvh"), "{}", problem(3));
    assert_eq!((&content(3)["count"], &content(3)["failed"]), (&json!(2), &json!(1)));
    assert_eq!(content(3)["motions"][0]["input"], "wrong.bvh");
    assert_eq!(content(5)["ok"], false);
    check(&schemas, &requests[6].1, &found[6]);
    assert_eq!(content(6)["statuses"], json!({"error": 1, "warning": 0, "ok": 1}));
    assert_eq!(content(6)["files"][0]["file"], "mixed/wrong.bvh");
    let words = [
        (7, "Xpositon"),
        (8, "none.bvh"),
        (9, "no motion of a humanoid"),
        (10, "nonsense"),
        (11, "folder not found"),
        (12, "folder"),
        (13, "mocap://steps"),
        (14, "/0"),
        (15, "list shows the files"),
        (16, "list shows the files"),
        (17, "end \\\"output\\\" with /"),
        (18, "needs \\\"character\\\""),
        (19, "file not found: hero.vrm"),
        (20, "there is no folder new"),
    ];
    for (index, word) in words {
        let error = error(&found[index])["error"].to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// The manifest of the command states the same verdict for each motion. The worst limb has the largest angle in the
/// manifest.
#[test]
fn a_folder_has_a_verdict_and_the_worst_limb_of_each_motion() {
    let folder = with_takes();
    folder.succeeds("retarget takes hero.glb -o expected/");
    let manifest = String::from_utf8(folder.read(&format!("expected/{MANIFEST}"))).unwrap();
    let one = json!({"inputs": ["takes/dance.bvh"], "character": "hero.glb", "output": "one.glb"});
    let found = answers(
        &folder,
        &[
            call(
                "retarget",
                json!({"inputs": ["takes"], "character": "hero.glb", "output": "found/"}),
            ),
            call("retarget", one),
        ],
    );
    let content = |index: usize| &found[index]["result"]["structuredContent"];
    let motions = content(0)["motions"].as_array().unwrap();
    let mut counts = json!({"good": 0, "fair": 0, "poor": 0});
    for line in manifest.lines() {
        let record: Value = serde_json::from_str(line).unwrap();
        let report = &record["retarget"][0];
        let motion = motions
            .iter()
            .find(|motion| motion["input"] == record["input"])
            .unwrap();
        assert_eq!(motion["verdict"], report["verdict"], "{motion}");
        let is_explained = motion.get("reasons").is_some();
        assert_eq!(is_explained, report["verdict"] != "good", "{motion}");
        let verdict = report["verdict"].as_str().unwrap();
        counts[verdict] = (counts[verdict].as_u64().unwrap() + 1).into();
        let angle = |limb: &&Value| limb["mean_degrees"].as_f64().unwrap();
        let limbs = report["limbs"].as_array().unwrap().iter();
        let worst = limbs.max_by(|a, b| angle(a).total_cmp(&angle(b))).unwrap();
        assert_eq!(motion["worst_limb"]["bone"], worst["bone"], "{motion}");
        let difference = motion["worst_limb"]["mean_degrees"].as_f64().unwrap() - angle(&worst);
        assert!(difference.abs() <= 0.005, "{motion}: {worst}");
        // A single output has the same verdict.
        if record["input"] == "dance.bvh" {
            let clip = &content(1)["clips"][0];
            assert_eq!(clip["worst_limb"], motion["worst_limb"]);
            assert_eq!(clip["verdict"], motion["verdict"]);
        }
    }
    assert_eq!(content(0)["verdicts"], counts);
    assert_eq!(content(0)["count"], 3);
    // The worst motion is first.
    let grade = |motion: &Value| ["poor", "fair", "good"].iter().position(|it| motion["verdict"] == *it);
    assert!(motions.is_sorted_by_key(grade), "{motions:?}");
}

/// A choice of takes needs motions, so a character and a robot come last, with any verdict.
#[test]
fn a_survey_of_a_whole_folder_begins_with_motions() {
    let folder = with_takes();
    let found = answers(&folder, &[call("survey", json!({"inputs": ["."]}))]);
    let clips = found[0]["result"]["structuredContent"]["clips"].as_array().unwrap();
    let files: Vec<&str> = clips.iter().map(|clip| clip["file"].as_str().unwrap()).collect();
    let (takes, others) = files.split_at(3);
    assert!(takes.iter().all(|file| file.starts_with("takes/")), "{files:?}");
    let mut others = others.to_vec();
    others.sort_unstable();
    assert_eq!(others, ["h1.urdf", "hero.glb"]);
}

/// A client with only tools can read the resources.
#[test]
fn the_tool_read_gives_what_resources_give() {
    let folder = with_takes();
    let survey = json!({"inputs": ["takes"]});
    let read = |uri: &str, pointer: &str| call("read", json!({"uri": uri, "pointer": pointer}));
    let found = answers(
        &folder,
        &[
            call("survey", survey),
            ("resources/read", json!({"uri": "mocap://reports/1"})),
            read("mocap://reports/1", ""),
            read("mocap://reports/1", "/clips/0/file"),
            ("resources/read", json!({"uri": "mocap://job.schema.json"})),
            read("mocap://job.schema.json", ""),
            read("mocap://steps", ""),
            read("mocap://formats", ""),
            // A null value is a valid part.
            read("mocap://reports/1", "/clips/0/error"),
        ],
    );
    let resource = |index: usize| -> Value {
        serde_json::from_str(found[index]["result"]["contents"][0]["text"].as_str().unwrap()).unwrap()
    };
    let value = |index: usize| &found[index]["result"]["structuredContent"]["value"];
    let report = resource(1);
    assert_eq!(value(2)["clips"].as_array().unwrap().len(), 3);
    assert_eq!(value(3), &report["clips"][0]["file"]);
    // The schema of a job is returned without cuts.
    assert_eq!(value(5), &resource(4));
    assert!(found[5]["result"]["structuredContent"].get("note").is_none());
    let steps = value(6).as_array().unwrap();
    assert!(steps.iter().any(|step| step["name"] == "foot-lock"), "{steps:?}");
    assert!(value(7).as_array().unwrap().len() > 15);
    assert_eq!(value(8), &report["clips"][0]["error"]);
    assert!(found[8]["result"]["structuredContent"].get("value").is_some());
}
