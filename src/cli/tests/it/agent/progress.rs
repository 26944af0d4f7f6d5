//! Tests the progress notifications that `mocap mcp` sends during slow calls.

use serde_json::{Value, json};

use super::{Server, named, with_a_pipe};

/// The notifications until `enough` returns true.
fn heard(server: &Server, enough: impl Fn(&[Value]) -> bool) -> Vec<Value> {
    let mut heard = Vec::new();
    while !enough(&heard) {
        let message = server.next();
        assert_eq!(message["method"], "notifications/progress", "{message}");
        heard.push(message["params"].clone());
        assert!(heard.len() < 100, "{heard:?}");
    }
    heard
}

fn of(heard: &[Value], token: impl Into<Value>) -> Vec<&Value> {
    let token = token.into();
    heard.iter().filter(|params| params["progressToken"] == token).collect()
}

/// A call with one file has no files to count, and a waiting call has not begun. Both send notifications by time.
#[test]
fn every_call_of_more_than_a_second_is_told_about() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &[]);
    let hang = |token: Value| {
        let mut params = named("inspect", json!({"input": "pipe.bvh"}));
        params["_meta"] = json!({"progressToken": token});
        params
    };
    server.request("one", "tools/call", hang(json!("token")));
    let first = heard(&server, |heard| heard.len() == 3);
    let numbers: Vec<f64> = first
        .iter()
        .map(|params| params["progress"].as_f64().unwrap())
        .collect();
    assert!(numbers.is_sorted_by(|a, b| a < b), "{first:?}");
    assert!(
        first
            .iter()
            .all(|params| params["message"].as_str().unwrap().starts_with("running, ")),
        "{first:?}"
    );
    // Four calls run at once, so the last call waits.
    for token in 1..=4 {
        server.request(token, "tools/call", hang(json!(token)));
    }
    let all = heard(&server, |heard| (1..=4).all(|token| of(heard, token).len() >= 2));
    let is_waiting = |params: &&Value| params["message"].as_str().unwrap().starts_with("waiting, ");
    assert_eq!(
        (1..=4).filter(|token| of(&all, *token).iter().all(is_waiting)).count(),
        1,
        "{all:?}"
    );
    for token in 1..=4 {
        let numbers: Vec<f64> = of(&all, token)
            .iter()
            .map(|params| params["progress"].as_f64().unwrap())
            .collect();
        assert!(numbers.is_sorted_by(|a, b| a < b), "{all:?}");
    }
    server.cancel("one");
    (1..=4).for_each(|id| server.cancel(id));
}

/// A call without a token gets only its answer.
#[test]
fn a_call_that_asks_for_no_progress_hears_none() {
    let folder = with_a_pipe();
    let mut server = Server::start(&folder, &["--time-limit", "3"]);
    server.request(1, "tools/call", named("inspect", json!({"input": "pipe.bvh"})));
    assert_eq!(server.next()["id"], 1);
    server.end();
}
