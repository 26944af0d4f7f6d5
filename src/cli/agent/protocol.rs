//! Messages of JSON-RPC 2.0, and the fields that revisions of the Model Context Protocol add to a result.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The current revision of the protocol. It has no handshake: every request states its revision.
const CURRENT: &str = "2026-07-28";

/// Revisions that begin with `initialize`, the newest first.
const WITH_HANDSHAKE: [&str; 4] = ["2025-11-25", "2025-06-18", "2025-03-26", "2024-11-05"];

const REVISION_KEY: &str = "io.modelcontextprotocol/protocolVersion";
const CAPABILITIES_KEY: &str = "io.modelcontextprotocol/clientCapabilities";
const SERVER_KEY: &str = "io.modelcontextprotocol/serverInfo";

/// The error of a request, with a code of JSON-RPC or of the protocol.
#[derive(Debug)]
pub(super) struct Fault {
    code: i32,
    message: String,
    data: Option<Value>,
}

impl Fault {
    fn new(code: i32, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            data: None,
        }
    }

    pub(super) fn invalid_request(message: impl Into<String>) -> Self {
        Self::new(-32600, message)
    }

    pub(super) fn unknown_method(method: &str) -> Self {
        let shown: String = method.chars().take(64).collect();
        Self::new(-32601, format!("there is no method {shown:?}"))
    }

    pub(super) fn busy(message: impl Into<String>) -> Self {
        Self::new(-32000, message)
    }

    /// The message of the error.
    pub(super) fn into_words(self) -> String {
        self.message
    }

    pub(super) fn invalid_params(message: impl Into<String>) -> Self {
        Self::new(-32602, message)
    }
}

/// The message in a line.
pub(super) enum Message {
    Request {
        id: Value,
        method: String,
        params: Value,
    },
    /// The request with this identifier is cancelled.
    Cancelled(Value),
    /// Another notification, or an answer to no request. The server answers neither.
    Silent,
}

/// Parses the message of a line. An error has the request's `id`, if known.
pub(super) fn parse(text: &[u8]) -> Result<Message, (Value, Fault)> {
    let message: Value = serde_json::from_slice(text).map_err(|error| {
        (
            Value::Null,
            Fault::new(-32700, format!("the line is not JSON: {error}")),
        )
    })?;
    let Value::Object(mut message) = message else {
        let words = "a message must be a JSON object; this revision of the protocol has no lists of messages";
        return Err((Value::Null, Fault::invalid_request(words)));
    };
    let id = message.remove("id");
    let answered = id.clone().unwrap_or(Value::Null);
    if message.get("jsonrpc").and_then(Value::as_str) != Some("2.0") {
        return Err((answered, Fault::invalid_request("\"jsonrpc\" must be \"2.0\"")));
    }
    let method = match message.remove("method") {
        Some(Value::String(method)) => method,
        None if message.contains_key("result") || message.contains_key("error") => return Ok(Message::Silent),
        _ => return Err((answered, Fault::invalid_request("\"method\" must be a string"))),
    };
    let Some(id) = id else {
        return Ok(match method.as_str() {
            "notifications/cancelled" => {
                let params = message.remove("params").unwrap_or_default();
                Message::Cancelled(params.get("requestId").cloned().unwrap_or_default())
            }
            _ => Message::Silent,
        });
    };
    if !id.is_string() && !id.is_i64() && !id.is_u64() {
        let words = "\"id\" must be a string or an integer";
        return Err((Value::Null, Fault::invalid_request(words)));
    }
    let params = message.remove("params").unwrap_or_else(|| json!({}));
    match params.is_object() {
        true => Ok(Message::Request { id, method, params }),
        false => Err((id, Fault::invalid_params("\"params\" must be an object"))),
    }
}

/// The progress token of a request, if the client asks for progress.
pub(super) fn progress_token(params: &Value) -> Result<Option<Value>, Fault> {
    match &params["_meta"]["progressToken"] {
        Value::Null => Ok(None),
        token if token.is_string() || token.is_i64() || token.is_u64() => Ok(Some(token.clone())),
        _ => Err(Fault::invalid_params(
            "\"progressToken\" must be a string or an integer",
        )),
    }
}

/// The answer to a failed request.
pub(super) fn failed(id: &Value, fault: &Fault) -> Value {
    let mut error = json!({"code": fault.code, "message": fault.message});
    if let Some(data) = &fault.data {
        error["data"] = data.clone();
    }
    json!({"jsonrpc": "2.0", "id": id, "error": error})
}

/// Whether a request belongs to the current revision, or to a revision with a handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Era {
    Current,
    Handshake,
}

impl Era {
    /// The era of a request, by the contents of its `_meta`.
    pub(super) fn of(params: &Value, is_initialized: bool) -> Result<Self, Fault> {
        let meta = &params["_meta"];
        let revision = match &meta[REVISION_KEY] {
            Value::Null if is_initialized => return Ok(Self::Handshake),
            Value::String(revision) => revision.as_str(),
            _ => {
                let words = format!("\"_meta\" must hold {REVISION_KEY:?}, or the client must send initialize first");
                return Err(Fault::invalid_params(words));
            }
        };
        if revision != CURRENT {
            let data = json!({"supported": [CURRENT], "requested": revision});
            let fault = Fault::new(-32022, "the revision of the protocol is not supported");
            return Err(Fault {
                data: Some(data),
                ..fault
            });
        }
        match meta[CAPABILITIES_KEY].is_object() {
            true => Ok(Self::Current),
            false => Err(Fault::invalid_params(format!(
                "\"_meta\" must hold {CAPABILITIES_KEY:?}"
            ))),
        }
    }

    /// Adds the fields that the revision requires to a result.
    pub(super) fn finish(self, mut result: Value, method: &str) -> Value {
        if self == Self::Current {
            result["resultType"] = "complete".into();
            if method != "tools/call" && method != "ping" {
                result["ttlMs"] = 0.into();
                result["cacheScope"] = "private".into();
            }
        }
        result
    }
}

fn server() -> Value {
    json!({"name": "mocap", "title": "mocap: motion capture", "version": env!("CARGO_PKG_VERSION")})
}

fn capabilities() -> Value {
    json!({"tools": {}, "resources": {}})
}

/// The result of `server/discover`.
pub(super) fn discovered(instructions: &str) -> Value {
    json!({
        "supportedVersions": [CURRENT],
        "capabilities": capabilities(),
        "instructions": instructions,
        "_meta": {SERVER_KEY: server()},
    })
}

/// The result of `initialize`: the revision that the client asks for, or the newest with a handshake.
pub(super) fn initialized(params: &Value, instructions: &str) -> Value {
    let asked = params["protocolVersion"].as_str();
    let known = WITH_HANDSHAKE.into_iter().find(|known| asked == Some(known));
    json!({
        "protocolVersion": known.unwrap_or(WITH_HANDSHAKE[0]),
        "capabilities": capabilities(),
        "serverInfo": server(),
        "instructions": instructions,
    })
}
