//! `mocap mcp`, by messages on standard input. `tools/mcp` holds it against a client of the protocol's authors.

mod line;
mod schema;

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::at_root;
use crate::program::Folder;

/// The answers of a server to requests, one for each.
fn answers(folder: &Folder, requests: &[(&str, Value)]) -> Vec<Value> {
    let mut server = Command::new(env!("CARGO_BIN_EXE_mocap"))
        .args(["mcp", "--root"])
        .arg(folder.path(""))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = server.stdin.take().unwrap();
    for (index, (method, params)) in requests.iter().enumerate() {
        let mut params = params.clone();
        params["_meta"] = json!({
            "io.modelcontextprotocol/protocolVersion": "2026-07-28",
            "io.modelcontextprotocol/clientCapabilities": {},
        });
        let message = json!({"jsonrpc": "2.0", "id": index, "method": method, "params": params});
        writeln!(input, "{message}").unwrap();
    }
    drop(input);
    let output = server.wait_with_output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let answers: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(
        answers.iter().enumerate().all(|(index, answer)| answer["id"] == index),
        "{text}"
    );
    assert_eq!(answers.len(), requests.len());
    answers
}

fn call(tool: &str, arguments: Value) -> (&'static str, Value) {
    ("tools/call", json!({"name": tool, "arguments": arguments}))
}

#[test]
fn a_call_gives_the_bytes_of_the_command() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.succeeds("convert cmu_short.bvh command.glb --max-error 1mm");
    let arguments = json!({"inputs": ["cmu_short.bvh"], "output": "call.glb", "max-error": "1mm"});
    let dry = json!({"inputs": ["cmu_short.bvh"], "output": "dry.glb", "dry-run": true});
    let job = json!({"source": {"inputs": ["cmu_short.bvh"]}, "write": {"output": "job.glb", "smaller": {"max-error": "1mm"}}});
    let found = answers(
        &folder,
        &[
            call("convert", arguments),
            call("convert", dry),
            call("run", json!({"job": job})),
        ],
    );
    for answer in &found {
        assert_eq!(answer["result"]["isError"], false, "{answer}");
    }
    assert_eq!(folder.read("call.glb"), folder.read("command.glb"));
    assert_eq!(folder.read("job.glb"), folder.read("command.glb"));
    assert!(!folder.path("dry.glb").exists());
    let bytes = found[0]["result"]["structuredContent"]["files"][0]["bytes"].as_u64();
    assert_eq!(bytes, Some(folder.read("command.glb").len() as u64));
}

#[test]
fn a_call_stays_in_its_folder_and_replaces_nothing() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let root = Folder::of_real(&[]);
    root.write("take.bvh", &folder.read("cmu_short.bvh"));
    root.write("mine.glb", b"somebody's work");
    let secret = folder.path("cmu_short.bvh").display().to_string();
    let requests = [
        call("inspect", json!({"input": "../cmu_short.bvh"})),
        call("inspect", json!({"input": secret})),
        call("convert", json!({"inputs": ["take.bvh"], "output": "mine.glb"})),
        call(
            "convert",
            json!({"inputs": ["take.bvh"], "output": folder.path("new.glb").display().to_string()}),
        ),
        call("convert", json!({"inputs": ["-"], "output": "new.glb"})),
    ];
    for answer in answers(&root, &requests) {
        let error = answer["result"]["structuredContent"]["error"].as_str().unwrap();
        assert_eq!(answer["result"]["isError"], true, "{answer}");
        let is_expected = ["leads out of", "has not written it", "- is standard input"];
        assert!(is_expected.iter().any(|words| error.contains(words)), "{error}");
    }
    assert_eq!(root.read("mine.glb"), b"somebody's work");
    assert!(!folder.path("new.glb").exists());
}

#[test]
fn errors_carry_the_help_and_the_server_goes_on() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let text = String::from_utf8(folder.read("cmu_short.bvh")).unwrap();
    folder.write("wrong.bvh", text.replacen("Xposition", "Xpositon", 1).as_bytes());
    let found = answers(
        &folder,
        &[
            call("inspect", json!({"input": "wrong.bvh"})),
            call(
                "edit",
                json!({"inputs": ["cmu_short.bvh"], "step": ["smoth"], "output": "a.glb"}),
            ),
            ("nonsense", json!({})),
            call("inspect", json!({"input": "cmu_short.bvh"})),
        ],
    );
    let content = |index: usize| found[index]["result"]["structuredContent"].clone();
    assert_eq!(content(0)["help"], "did you mean Xposition?");
    assert!(
        content(1)["error"].as_str().unwrap().contains("smooth"),
        "{}",
        content(1)
    );
    assert_eq!(found[2]["error"]["code"], -32601);
    assert_eq!(content(3)["frames"], 75);
}

/// A link out of the folder of a file is that of its user, who made it. A server opens nothing outside of its root.
#[cfg(unix)]
#[test]
fn links_out_of_a_folder_are_followed_by_the_program_and_not_by_a_server() {
    let outside = Folder::of_real(&["cmu_short.bvh"]);
    outside.succeeds("convert cmu_short.bvh pair.gltf");
    let root = Folder::of_real(&[]);
    root.write("take.gltf", &outside.read("pair.gltf"));
    std::os::unix::fs::symlink(outside.path("pair.bin"), root.path("pair.bin")).unwrap();
    root.succeeds("info take.gltf");
    let answer = &answers(&root, &[call("inspect", json!({"input": "take.gltf"}))])[0];
    assert_eq!(answer["result"]["isError"], true, "{answer}");
    assert!(answer.to_string().contains("leads out of"), "{answer}");
}

/// A search that follows links into themselves never ends, and one that follows links out tells what is there.
#[cfg(unix)]
#[test]
fn searches_end_and_stay_in_the_folder() {
    use std::os::unix::fs::symlink;
    let outside = Folder::with(&["secret/secret.bvh", "secret.bvh"]);
    let root = Folder::with(&["in/a.bvh"]);
    symlink(".", root.path("in/x")).unwrap();
    symlink(".", root.path("in/y")).unwrap();
    symlink("/", root.path("in/sys_root")).unwrap();
    symlink(outside.path("secret"), root.path("in/linked")).unwrap();
    symlink(outside.path("secret.bvh"), root.path("in/one.bvh")).unwrap();
    symlink(outside.path("none.bvh"), root.path("in/gone.bvh")).unwrap();
    let mut requests = Vec::new();
    for inputs in ["in", ".", "in/**/*.bvh", "**", "*/*", "in/**", "in/*/*/*.bvh"] {
        requests.push(call("check", json!({"inputs": [inputs]})));
        requests.push(call("survey", json!({"inputs": [inputs]})));
        requests.push(call(
            "convert",
            json!({"inputs": [inputs], "output": "out/", "dry-run": true}),
        ));
    }
    for (answer, (_, request)) in answers(&root, &requests).iter().zip(&requests) {
        let text = answer.to_string();
        for word in ["secret", "linked", "one.bvh", "gone.bvh", "sys_root"] {
            assert!(!text.contains(word), "{request}: {text}");
        }
        // The loops are told; the file is there once.
        let is_deep = request.to_string().contains("/*/*/");
        assert!(is_deep || text.contains("a.bvh"), "{request}: {text}");
    }
}

/// A texture has the name that a character gives it, and a sidecar that of its motion: neither replaces what the
/// session has not written, also where the session has written the file to which it belongs.
#[test]
fn a_session_replaces_nothing_beside_its_outputs() {
    let root = Folder::of_real(&["cmu_short.bvh"]);
    let hero = std::fs::read_to_string(at_root("fixtures/made/two_bones_textured.gltf")).unwrap();
    let mut hero: Value = serde_json::from_str(&hero).unwrap();
    hero["images"][0]["name"] = "skin".into();
    root.write("hero.gltf", hero.to_string().as_bytes());
    let mine = ["skin.png", "take.bvh.json", "pair.bin", "new/take.glb"];
    std::fs::create_dir(root.path("new")).unwrap();
    std::fs::create_dir(root.path("sub")).unwrap();
    mine.iter().for_each(|name| root.write(name, b"somebody's work"));
    let job = |input: &str, output: &str, write: Value| {
        let mut job = json!({"source": {"inputs": [input]}, "write": {"output": output, "force": true}});
        job["write"]
            .as_object_mut()
            .unwrap()
            .extend(write.as_object().unwrap().clone());
        call("run", json!({"job": job}))
    };
    let beside = || json!({"fbx": {"textures": "beside"}});
    let sidecar = || json!({"bvh": {"sidecar": true}});
    let requests = [
        (true, job("hero.gltf", "hero.fbx", json!({}))),
        (false, job("hero.gltf", "hero.fbx", beside())),
        (false, job("hero.gltf", "hero.usda", json!({}))),
        (
            false,
            call("convert", json!({"inputs": ["hero.gltf"], "output": "hero.usda"})),
        ),
        (true, job("cmu_short.bvh", "take.bvh", json!({}))),
        (false, job("cmu_short.bvh", "take.bvh", sidecar())),
        (false, job("cmu_short.bvh", "pair.gltf", json!({}))),
        (
            false,
            call("convert", json!({"inputs": ["cmu_short.bvh"], "output": "new/"})),
        ),
        // What it has written itself it may write again, with what stands beside.
        (true, job("hero.gltf", "sub/hero.fbx", beside())),
        (true, job("hero.gltf", "sub/hero.fbx", beside())),
        (true, job("cmu_short.bvh", "sub/take.bvh", sidecar())),
        (
            true,
            job(
                "cmu_short.bvh",
                "sub/take.bvh",
                json!({"bvh": {"sidecar": true, "digits": 2}}),
            ),
        ),
        (
            true,
            call("convert", json!({"inputs": ["cmu_short.bvh"], "output": "many/"})),
        ),
        (
            true,
            call(
                "convert",
                json!({"inputs": ["cmu_short.bvh"], "output": "many/", "max-error": "1mm"}),
            ),
        ),
    ];
    let (expected, requests): (Vec<bool>, Vec<_>) = requests.into_iter().unzip();
    for (index, answer) in answers(&root, &requests).iter().enumerate() {
        assert_eq!(answer["result"]["isError"], !expected[index], "{index}: {answer}");
        assert!(
            expected[index] || answer.to_string().contains("not written"),
            "{index}: {answer}"
        );
    }
    for name in mine {
        assert_eq!(root.read(name), b"somebody's work", "{name}");
    }
    for name in ["hero.usda", "pair.gltf"] {
        assert!(!root.path(name).exists(), "{name}");
    }
    assert!(root.read("sub/take.bvh").len() < root.read("take.bvh").len());
}
