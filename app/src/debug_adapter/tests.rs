use std::io::Cursor;

use serde_json::{Value, json};

use super::serve;

fn framed(message: &[u8]) -> Vec<u8> {
    let mut bytes = format!("Content-Length: {}\r\n\r\n", message.len()).into_bytes();
    bytes.extend_from_slice(message);
    bytes
}

/// What comes back for these bytes, and whether it was an error.
fn answers(input: &[u8]) -> (Vec<Value>, bool) {
    let mut output = Vec::new();
    let ended = serve(&mut Cursor::new(input), &mut output);
    let text = String::from_utf8(output).expect("UTF-8");
    let parts = text.split("Content-Length: ").skip(1);
    let bodies = parts.map(|part| part.split_once("\r\n\r\n").expect("a header").1);
    (bodies.map(|body| serde_json::from_str(body).expect("JSON")).collect(), ended.is_err())
}

#[test]
fn what_is_no_message_ends_it_or_is_passed_over() {
    for wrong in [&b"x"[..], b"\r\n\r\n", b"Content-Length: -1\r\n\r\n", b"Content-Length: 99\r\n\r\n{}"] {
        assert_eq!(answers(wrong), (Vec::new(), true), "{wrong:?}");
    }
    let endless = [b'a'; 100_000];
    assert!(answers(&endless).1);
    assert_eq!(answers(b"Content-Length: 99999999999\r\n\r\n"), (Vec::new(), true));
    let mut input = [&b"\xff\xfe"[..], b"[1, 2", b"null", b"{\"type\": \"event\"}", b"7"].map(framed).concat();
    assert_eq!(answers(&input), (Vec::new(), false));
    input.extend(framed(b"{\"type\": \"request\", \"seq\": 4, \"command\": \"initialize\", \"arguments\": 3}"));
    let (found, failed) = answers(&input);
    assert!(!failed && found[0]["request_seq"] == 4 && found[0]["body"]["supportsStepBack"] == true, "{found:?}");
}

#[test]
fn every_request_is_answered_before_a_launch_and_with_any_arguments() {
    let commands = [
        "launch",
        "configurationDone",
        "threads",
        "setBreakpoints",
        "stackTrace",
        "scopes",
        "variables",
        "evaluate",
        "source",
        "loadedSources",
        "exceptionInfo",
        "continue",
        "next",
        "stepIn",
        "stepOut",
        "stepBack",
        "reverseContinue",
        "restart",
        "raystep/element",
        "nonsense",
        "",
    ];
    let arguments = [json!(null), json!(-1), json!({ "frameId": -7, "program": 3, "breakpoints": 1, "element": [] })];
    let mut input = Vec::new();
    for command in commands {
        for arguments in &arguments {
            let message = json!({ "type": "request", "seq": 1, "command": command, "arguments": arguments });
            input.extend(framed(message.to_string().as_bytes()));
        }
    }
    let (found, failed) = answers(&input);
    assert!(!failed && found.len() == commands.len() * arguments.len(), "{found:?}");
    assert!(found.iter().all(|answer| answer["success"] == false && answer["message"].is_string()), "{found:?}");
}
