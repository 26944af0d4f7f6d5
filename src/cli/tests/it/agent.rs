//! Tests `mocap mcp` by messages on standard input. `tools/mcp` tests it with the client of the protocol's authors.

mod answers;
mod instructions;
mod line;
mod listing;
#[cfg(unix)]
mod progress;
mod schema;

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::at_root;
use crate::program::{Folder, STATE_HOME};

/// A running server, which exchanges lines.
struct Server {
    child: Child,
    input: Option<ChildStdin>,
    answers: Receiver<Value>,
}

impl Server {
    fn start(folder: &Folder, options: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_mocap"))
            .args(["mcp", "--root"])
            .arg(folder.path(""))
            .args(options)
            .env("XDG_STATE_HOME", STATE_HOME)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, answers) = mpsc::channel();
        thread::spawn(move || {
            for line in output.lines() {
                let _ = sender.send(serde_json::from_str(&line.unwrap()).unwrap());
            }
        });
        Self {
            input: child.stdin.take(),
            child,
            answers,
        }
    }

    fn send(&mut self, line: &str) {
        writeln!(self.input.as_mut().unwrap(), "{line}").unwrap();
    }

    /// Sends a request of the current revision.
    fn request(&mut self, id: impl Into<Value>, method: &str, mut params: Value) {
        let meta = &mut params["_meta"];
        meta["io.modelcontextprotocol/protocolVersion"] = "2026-07-28".into();
        meta["io.modelcontextprotocol/clientCapabilities"] = json!({});
        let id = id.into();
        self.send(&json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}).to_string());
    }

    fn cancel(&mut self, id: impl Into<Value>) {
        let id: Value = id.into();
        let params = json!({"requestId": id, "reason": "not wanted"});
        self.send(&json!({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": params}).to_string());
    }

    /// The next message of the server.
    fn next(&self) -> Value {
        self.answers
            .recv_timeout(Duration::from_secs(60))
            .expect("the server is silent")
    }

    /// Closes the input. The server then ends by itself.
    fn end(mut self) {
        self.input = None;
        assert!(self.child.wait().unwrap().success());
        assert!(self.answers.recv().is_err(), "a message that nothing asked for");
    }
}

/// The answers of a server to requests. Each request is sent after the previous answer.
fn answers(folder: &Folder, requests: &[(&str, Value)]) -> Vec<Value> {
    let mut server = Server::start(folder, &[]);
    let answer = |(index, (method, params)): (usize, &(&str, Value))| {
        server.request(index, method, params.clone());
        let answer = server.next();
        assert_eq!(answer["id"], index, "{answer}");
        answer
    };
    let answers = requests.iter().enumerate().map(answer).collect();
    server.end();
    answers
}

/// The error of a failed call.
fn error(answer: &Value) -> Value {
    let result = &answer["result"];
    assert_eq!(result["isError"], true, "{answer}");
    assert!(result.get("structuredContent").is_none(), "{answer}");
    serde_json::from_str(result["content"][0]["text"].as_str().unwrap()).unwrap()
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
        let error = error(&answer)["error"].as_str().unwrap().to_owned();
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
    assert_eq!(error(&found[0])["help"], "did you mean Xposition?");
    let step = error(&found[1])["error"].to_string();
    assert!(step.contains("smooth"), "{step}");
    assert_eq!(found[2]["error"]["code"], -32601);
    assert_eq!(found[3]["result"]["structuredContent"]["frames"], 75);
}

/// On the command line, links out of the folder are allowed, because the user made them. A server opens nothing outside
/// its root.
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

/// A search must end despite link loops, and must not list the targets of links out of the root.
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
        // The loops are reported, and the file is listed once.
        let is_deep = request.to_string().contains("/*/*/");
        assert!(is_deep || text.contains("a.bvh"), "{request}: {text}");
    }
}

/// A character names its textures, and a sidecar has the name of its motion. Neither replaces a file that the session
/// has not written, even if the session has written the main file.
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
        // The session may replace its own outputs and their companion files.
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

/// A pipe without a writer: a call that reads the pipe never ends by itself.
#[cfg(unix)]
fn with_a_pipe() -> Folder {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let made = Command::new("mkfifo").arg(folder.path("pipe.bvh")).status();
    assert!(made.unwrap().success());
    folder
}

fn named(tool: &str, arguments: Value) -> Value {
    json!({"name": tool, "arguments": arguments})
}

#[cfg(unix)]
#[test]
fn a_call_that_hangs_blocks_nothing_and_is_cancelled_without_an_answer() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &[]);
    let hangs = named("inspect", json!({"input": "pipe.bvh"}));
    server.request("hangs", "tools/call", hangs.clone());
    server.request(1, "ping", json!({}));
    assert_eq!(server.next()["id"], 1);
    // Another call runs at the same time.
    server.request(2, "tools/call", named("inspect", json!({"input": "cmu_short.bvh"})));
    let answer = server.next();
    assert_eq!(
        (&answer["id"], &answer["result"]["structuredContent"]["frames"]),
        (&json!(2), &json!(75))
    );
    // The identifier of the call is in use until the call ends.
    server.request("hangs", "tools/call", hangs.clone());
    let answer = server.next();
    assert_eq!(
        (&answer["id"], &answer["error"]["code"]),
        (&json!("hangs"), &json!(-32600))
    );
    // Unknown identifiers, and an identifier of another type.
    for unknown in [json!(null), json!(1), json!(77), json!([]), json!({"a": 1})] {
        server.cancel(unknown);
    }
    server.cancel("hangs");
    let start = Instant::now();
    loop {
        server.request(
            "hangs",
            "tools/call",
            named("inspect", json!({"input": "cmu_short.bvh"})),
        );
        let answer = server.next();
        assert_eq!(answer["id"], "hangs");
        if answer.get("result").is_some() {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{answer}");
        thread::sleep(Duration::from_millis(20));
    }
    server.end();
}

#[cfg(unix)]
#[test]
fn a_call_has_a_time_limit() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &["--time-limit", "1"]);
    // More calls than run at once. The time limit of a waiting call begins when the call runs.
    for id in 0..6 {
        server.request(id, "tools/call", named("inspect", json!({"input": "pipe.bvh"})));
    }
    let mut ids = Vec::new();
    for _ in 0..6 {
        let answer = server.next();
        let error = error(&answer)["error"].as_str().unwrap().to_owned();
        assert!(
            error.contains("longer than 1 s") && error.contains("--time-limit"),
            "{error}"
        );
        ids.push(answer["id"].as_u64().unwrap());
    }
    ids.sort_unstable();
    assert_eq!(ids, [0, 1, 2, 3, 4, 5]);
    server.end();
}

#[cfg(unix)]
#[test]
fn calls_that_wait_are_cancelled_and_too_many_are_refused() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &[]);
    for id in 0..200 {
        server.request(id, "tools/call", named("inspect", json!({"input": "pipe.bvh"})));
    }
    server.request("ping", "ping", json!({}));
    let mut refused = 0;
    loop {
        let answer = server.next();
        if answer["id"] == "ping" {
            break;
        }
        assert_eq!(answer["error"]["code"], -32000, "{answer}");
        refused += 1;
    }
    assert!((40..=100).contains(&refused), "{refused}");
    for id in 0..200 {
        server.cancel(id);
    }
    server.request(
        "last",
        "tools/call",
        named("inspect", json!({"input": "cmu_short.bvh"})),
    );
    let answer = server.next();
    assert_eq!(
        (&answer["id"], &answer["result"]["isError"]),
        (&json!("last"), &json!(false))
    );
    server.end();
}

/// When a server ends, its calls end.
#[cfg(target_os = "linux")]
#[test]
fn the_processes_of_calls_end_with_the_server() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &[]);
    server.request(1, "tools/call", named("inspect", json!({"input": "pipe.bvh"})));
    // Linux lists children by the thread that started them.
    let processes = |parent: u32| {
        let threads = std::fs::read_dir(format!("/proc/{parent}/task"))
            .into_iter()
            .flatten()
            .flatten();
        let children = threads.map(|thread| std::fs::read_to_string(thread.path().join("children")));
        let children: String = children.map(Result::unwrap_or_default).collect();
        children.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    let start = Instant::now();
    let child = loop {
        if let Some(child) = processes(server.child.id()).first() {
            break child.clone();
        }
        assert!(start.elapsed() < Duration::from_secs(30), "no process");
    };
    server.child.kill().unwrap();
    server.child.wait().unwrap();
    let is_gone = || {
        let status = std::fs::read_to_string(format!("/proc/{child}/stat")).unwrap_or_default();
        status.is_empty() || status.contains(") Z ")
    };
    while !is_gone() {
        assert!(
            start.elapsed() < Duration::from_secs(30),
            "the process of the call is alive"
        );
        thread::sleep(Duration::from_millis(20));
    }
}

/// A cancelled call leaves only complete outputs, equal to the outputs of the command.
#[test]
fn a_cancelled_folder_has_whole_outputs_and_can_be_made_again() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let bytes = folder.read("cmu_short.bvh");
    for number in 0..300 {
        folder.write(&format!("in/{number}.bvh"), &bytes);
    }
    folder.succeeds("convert in -o expected --to gltf");
    let mut server = Server::start(&folder, &[]);
    let job = named("convert", json!({"inputs": ["in"], "output": "out/", "to": "gltf"}));
    let mut params = job.clone();
    params["_meta"] = json!({"progressToken": "folder"});
    server.request(1, "tools/call", params);
    let told = server.next();
    assert_eq!(told["method"], "notifications/progress", "{told}");
    assert_eq!(
        (&told["params"]["progressToken"], &told["params"]["total"]),
        (&json!("folder"), &json!(300))
    );
    assert!(told["params"]["progress"].as_f64().unwrap() < 300.0, "{told}");
    server.cancel(1);
    // Pending progress messages come first, then the answer, when the call has ended.
    let start = Instant::now();
    let answer = loop {
        server.request(1, "tools/call", named("inspect", json!({"input": "cmu_short.bvh"})));
        let answer = loop {
            let message = server.next();
            if message.get("method").is_none() {
                break message;
            }
        };
        if answer.get("result").is_some() {
            break answer;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{answer}");
        thread::sleep(Duration::from_millis(5));
    };
    assert_eq!(answer["result"]["isError"], false, "{answer}");
    let mut outputs = 0;
    for (path, bytes) in folder.contents() {
        let Ok(name) = path.strip_prefix(folder.path("out")) else {
            continue;
        };
        if name.as_os_str() != "mocap-manifest.jsonl" {
            assert!(
                bytes == std::fs::read(folder.path("expected").join(name)).unwrap(),
                "{}",
                path.display()
            );
            outputs += 1;
        }
    }
    assert!(outputs < 600, "the call was not ended: {outputs}");
    // The session may write to its own folder again. The numbers of progress only increase.
    let mut params = job;
    params["_meta"] = json!({"progressToken": 7});
    server.request(2, "tools/call", params);
    let mut last = 0.0;
    let answer = loop {
        let message = server.next();
        if message.get("method").is_none() {
            break message;
        }
        let progress = message["params"]["progress"].as_f64().unwrap();
        assert!(progress > last && message["params"]["progressToken"] == 7, "{message}");
        last = progress;
    };
    assert_eq!(
        (&answer["id"], &answer["result"]["isError"]),
        (&json!(2), &json!(false)),
        "{answer}"
    );
    assert_eq!(last, 300.0);
    server.end();
}

/// Jobs and graphs can name files anywhere. A server opens none of them outside its root.
#[test]
fn jobs_and_graphs_name_files_anywhere_but_to_a_server() {
    let outside = Folder::of_real(&["cmu_12_01_walk.bvh"]);
    let root = Folder::of_real(&["cmu_short.bvh"]);
    let walk = outside.path("cmu_12_01_walk.bvh").display().to_string();
    let job = |input: &str, output: &str| json!({"source": {"inputs": [input]}, "write": {"output": output}});
    let made = outside.path("made.glb").display().to_string();
    root.write("job.json", job(&walk, &made).to_string().as_bytes());
    root.succeeds("run job.json");
    assert!(outside.path("made.glb").is_file());
    root.succeeds(&format!("graph {walk} --threshold 5cm -o graph.json"));
    root.succeeds("graph walk graph.json --seconds 6 -o long.bvh");
    let before = (outside.contents(), root.contents());
    let requests = [
        call("run", json!({"job": job(&walk, "new.glb")})),
        call(
            "run",
            json!({"job": job("cmu_short.bvh", &outside.path("new.glb").display().to_string())}),
        ),
        call("run", json!({"job": job("../cmu_short.bvh", "new.glb")})),
        call(
            "walk",
            json!({"graph": "graph.json", "seconds": 6, "output": "new.bvh"}),
        ),
    ];
    for answer in answers(&root, &requests) {
        let error = error(&answer)["error"].as_str().unwrap().to_owned();
        assert!(
            error.contains("leads out of") || error.contains("outside of the folder"),
            "{error}"
        );
    }
    assert!((outside.contents(), root.contents()) == before);
}
