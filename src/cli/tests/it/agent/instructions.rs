//! The calls that the instructions and the documentation show.

use std::fs;

use serde_json::{Deserializer, Value, json};

use super::{Server, answers, call};
use crate::at_root;
use crate::program::Folder;

/// The calls of a text: lines that begin with the name of a tool and an object.
fn calls(text: &str, tools: &[&str]) -> Vec<(&'static str, Value)> {
    let call_of = |line: &str| {
        let (tool, rest) = line.split_once(' ')?;
        let is_call = tools.contains(&tool) && rest.trim_start().starts_with('{');
        let mut values = Deserializer::from_str(rest).into_iter::<Value>();
        is_call.then(|| call(tool, values.next().unwrap().unwrap()))
    };
    text.lines().filter_map(call_of).collect()
}

fn names(tools: &Value) -> Vec<&str> {
    let tools = tools["result"]["tools"].as_array().unwrap();
    tools.iter().map(|tool| tool["name"].as_str().unwrap()).collect()
}

/// A folder with a take and two characters.
fn with_a_take(name: &str) -> Folder {
    let folder = Folder::of_real(&[]);
    let copy = |from: &str, to: &str| folder.write(to, &fs::read(at_root(from)).unwrap());
    copy("fixtures/real/cmu_12_01_walk.bvh", name);
    copy("fixtures/characters/human_vrm0.vrm", "hero.vrm");
    copy("fixtures/characters/human_default.glb", "hero.glb");
    folder
}

/// Makes the calls in order. Each call succeeds and writes the named files.
fn make(folder: &Folder, calls: &[(&str, Value)]) {
    for (answer, (_, call)) in answers(folder, calls).iter().zip(calls) {
        assert_eq!(answer["result"]["isError"], false, "{call}: {answer}");
        if let Some(output) = call["arguments"]["output"].as_str() {
            assert!(folder.path(output).exists(), "{call}: {answer}");
        }
    }
}

#[test]
fn every_call_of_the_instructions_is_made() {
    let folder = with_a_take("takes/walk.bvh");
    let found = answers(&folder, &[("server/discover", json!({})), ("tools/list", json!({}))]);
    let text = found[0]["result"]["instructions"].as_str().unwrap();
    let calls = calls(text, &names(&found[1]));
    // No call is inside a sentence, where the test would not find it.
    assert_eq!(calls.len(), text.matches('{').count(), "{text}");
    for tool in ["list", "survey", "edit", "retarget", "convert", "sheet", "read"] {
        assert!(calls.iter().any(|(_, call)| call["name"] == tool), "{tool}: {text}");
    }
    make(&folder, &calls);
    // Clients with a handshake get the same instructions.
    let mut server = Server::start(&folder, &[]);
    let params =
        json!({"protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}});
    server.send(&json!({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": params}).to_string());
    assert_eq!(server.next()["result"]["instructions"], text);
    server.end();
}

#[test]
fn every_call_of_the_documentation_is_made() {
    let folder = with_a_take("walk.bvh");
    let found = answers(&folder, &[("tools/list", json!({}))]);
    let text = fs::read_to_string(at_root("docs/agents.md")).unwrap();
    let calls = calls(&text, &names(&found[0]));
    assert!(calls.len() >= 5, "{text}");
    make(&folder, &calls);
    // The page has a row for each tool.
    for name in names(&found[0]) {
        assert!(
            text.contains(&format!("`{name}`")),
            "docs/agents.md does not name {name}"
        );
    }
}
