//! `raystep debug-adapter`, as an editor uses it.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use serde_json::{Value, json};

use crate::common::Place;
use crate::files::cornell_box;

/// An editor.
struct Client {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    sequence: u64,
    /// Events that came before an answer.
    events: Vec<Value>,
}

impl Client {
    fn new(place: &Place) -> Self {
        let mut command = place.command(&[OsStr::new("debug-adapter")]);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the binary starts");
        let input = process.stdin.take().expect("an input");
        let output = BufReader::new(process.stdout.take().expect("an output"));
        Self { process, input, output, sequence: 0, events: Vec::new() }
    }

    fn read(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert_ne!(self.output.read_line(&mut line).expect("a header"), 0, "it has ended");
            match line.trim() {
                "" => break,
                line => length = line.strip_prefix("Content-Length: ").expect("a length").parse().expect("a number"),
            }
        }
        let mut bytes = vec![0; length];
        self.output.read_exact(&mut bytes).expect("a message");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    fn ask(&mut self, command: &str, arguments: Value) -> Value {
        self.sequence += 1;
        let message = json!({ "seq": self.sequence, "type": "request", "command": command, "arguments": arguments });
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("written");
        loop {
            let answer = self.read();
            if answer["type"] == "response" {
                assert_eq!((&answer["request_seq"], &answer["command"]), (&json!(self.sequence), &json!(command)));
                return answer;
            }
            self.events.push(answer);
        }
    }

    fn ok(&mut self, command: &str, arguments: Value) -> Value {
        let answer = self.ask(command, arguments);
        assert_eq!(answer["success"], true, "{answer}");
        answer["body"].clone()
    }

    fn event(&mut self, name: &str) -> Value {
        let event = if self.events.is_empty() { self.read() } else { self.events.remove(0) };
        assert_eq!(event["event"], name, "{event}");
        event["body"].clone()
    }

    /// Goes somewhere, and returns the reason and the line.
    fn go(&mut self, how: &str) -> (String, u64) {
        self.ok(how, json!({ "threadId": 1 }));
        self.stopped()
    }

    fn stopped(&mut self) -> (String, u64) {
        let stopped = self.event("stopped");
        let stack = self.ok("stackTrace", json!({ "threadId": 1 }));
        let line = stack["stackFrames"][0]["line"].as_u64().expect("a line");
        (stopped["reason"].as_str().expect("a reason").to_owned(), line)
    }

    /// The variables of a scope of a frame, by name.
    fn scope(&mut self, frame: u64, name: &str) -> Vec<(String, String, u64)> {
        let scopes = self.ok("scopes", json!({ "frameId": frame }));
        let all = scopes["scopes"].as_array().expect("scopes").clone();
        let scope = all.iter().find(|scope| scope["name"] == name).unwrap_or_else(|| panic!("no {name} in {all:?}"));
        self.variables(scope["variablesReference"].as_u64().expect("a number"))
    }

    fn variables(&mut self, number: u64) -> Vec<(String, String, u64)> {
        let body = self.ok("variables", json!({ "variablesReference": number }));
        let text = |of: &Value, name: &str| of[name].as_str().expect("text").to_owned();
        let all = body["variables"].as_array().expect("variables");
        all.iter()
            .map(|one| (text(one, "name"), text(one, "value"), one["variablesReference"].as_u64().expect("a number")))
            .collect()
    }

    fn value(&mut self, expression: &str) -> String {
        let body = self.ok("evaluate", json!({ "expression": expression, "frameId": 1 }));
        body["result"].as_str().expect("a result").to_owned()
    }

    fn end(mut self) {
        self.ok("disconnect", json!({}));
        drop(self.input);
        assert!(self.process.wait().expect("it ends").success());
    }
}

/// The line, from 1, of a file that begins with a text.
fn line(source: &str, begins: &str) -> usize {
    source.lines().position(|line| line.trim().starts_with(begins)).unwrap_or_else(|| panic!("no {begins}")) + 1
}

const LIFE: &str = include_str!("../programs/life/generation.wgsl");
const SCAN: &str = include_str!("../programs/prefix-sum/scan.wgsl");

#[test]
fn an_element_stops_at_breakpoints_and_goes_forward_and_back() {
    let place = Place::new();
    place.ok(&["new", "mine", "--like", "life"]);
    let mut client = Client::new(&place);
    let can = client.ok("initialize", json!({ "adapterID": "raystep" }));
    assert!(can["supportsStepBack"] == true && can["supportsConditionalBreakpoints"] == true, "{can}");
    client.ok("launch", json!({ "program": "mine", "kernel": "generation", "element": [3, 2] }));
    client.event("initialized");
    let path = place.path("mine/generation.wgsl");
    let set = client.ok(
        "setBreakpoints",
        json!({
            "source": { "path": path },
            "breakpoints": [
                { "line": 11 },
                { "line": line(LIFE, "neighbours +="), "condition": "i == 7u" },
                { "line": line(LIFE, "neighbours +="), "condition": "i = 7u" },
                { "line": 4000 },
            ],
        }),
    );
    let set = set["breakpoints"].as_array().expect("breakpoints");
    assert!(set[0]["verified"] == true && set[0]["line"] == 12, "{set:?}");
    assert_eq!(set[1]["verified"], true, "{set:?}");
    assert!(
        set[2]["verified"] == false && set[2]["message"] == "column 3: = stores a value: == compares two",
        "{set:?}"
    );
    assert_eq!(set[3]["verified"], false, "{set:?}");
    client.ok("configurationDone", json!({}));
    assert_eq!(client.stopped(), ("breakpoint".into(), 12));
    assert!(
        client.ok("threads", json!({}))["threads"][0]["name"]
            .as_str()
            .is_some_and(|n| n.starts_with("element 3,2 of generation"))
    );
    assert_eq!(client.scope(1, "Locals").iter().map(|(name, ..)| &**name).collect::<Vec<_>>(), ["id", "size"]);
    assert_eq!(client.go("continue"), ("breakpoint".into(), line(LIFE, "neighbours +=") as u64));
    assert_eq!(
        (client.value("i"), client.value("there.x"), client.value("i * 2u + 1u")),
        ("7".into(), "3".into(), "15".into())
    );
    let locals = client.scope(1, "Locals");
    let (_, value, parts) = locals.iter().find(|(name, ..)| name == "there").expect("there").clone();
    assert_eq!((value.as_str(), client.variables(parts)[1].1.as_str()), ("(3, 3)", "3"));
    let before: u32 = client.value("neighbours").parse().expect("a number");
    // A step adds the cell; a step back takes it away again.
    let added: u32 = client.value("textureLoad(cell_before, there, 0, 0).x").parse().expect("a number");
    assert_eq!(client.go("next"), ("step".into(), line(LIFE, "let there") as u64));
    assert_eq!((client.value("i"), client.value("neighbours")), ("8".into(), (before + added).to_string()));
    assert_eq!(client.go("stepBack").1, line(LIFE, "neighbours +=") as u64);
    assert_eq!((client.value("i"), client.value("neighbours")), ("7".into(), before.to_string()));
    assert_eq!(client.go("reverseContinue"), ("breakpoint".into(), 12));
    assert_eq!(client.go("reverseContinue"), ("entry".into(), 7));
    client.go("continue");
    client.go("continue");
    // To the end of the pass: what it has stored is beside what was there before.
    assert_eq!(client.go("continue").0, "pause");
    assert!(client.scope(1, "Streams").iter().any(|(name, ..)| name == "cell.alive"));
    assert_eq!(client.go("stepBack"), ("step".into(), line(LIFE, "textureStore") as u64));
    client.go("continue");
    client.ok("continue", json!({ "threadId": 1 }));
    client.event("terminated");
    // Another element.
    client.ok("raystep/element", json!({ "element": [0, 0] }));
    assert_eq!(client.stopped().0, "breakpoint");
    assert!(
        client.value("id.y") == "0"
            && client.ask("raystep/element", json!({ "element": [256, 0] }))["success"] == false
    );
    client.end();
}

#[test]
fn a_thread_is_followed_through_barriers_and_stops_where_it_fails() {
    let place = Place::new();
    place.ok(&["new", "mine", "--like", "prefix-sum"]);
    let mut client = Client::new(&place);
    client.ok("initialize", json!({}));
    let launch = json!({ "program": "mine", "kernel": "sum_numbers", "element": 9, "stopOnEntry": true });
    client.ok("launch", launch.clone());
    client.event("initialized");
    let path = place.path("mine/scan.wgsl");
    let at = line(SCAN, "row[1u - now]");
    client.ok(
        "setBreakpoints",
        json!({ "source": { "path": path }, "breakpoints": [{ "line": at, "condition": "reach == 8u" }] }),
    );
    client.ok("configurationDone", json!({}));
    assert_eq!(client.stopped(), ("entry".into(), line(SCAN, "let i = element") as u64));
    // A function of ours, whose text the adapter has.
    client.ok("stepIn", json!({ "threadId": 1 }));
    client.event("stopped");
    let stack = client.ok("stackTrace", json!({ "threadId": 1 }));
    let frames = stack["stackFrames"].as_array().expect("frames");
    assert!(frames.len() == 2 && frames[0]["name"] == "element" && frames[1]["name"] == "scan", "{frames:?}");
    let reference = frames[0]["source"]["sourceReference"].clone();
    let text = client.ok("source", json!({ "source": frames[0]["source"], "sourceReference": reference }));
    let line_there = frames[0]["line"].as_u64().expect("a line") as usize;
    let content = text["content"].as_str().expect("text").to_owned();
    assert!(content.lines().nth(line_there - 1).is_some_and(|line| line.contains("return")), "{content}");
    assert_eq!(client.go("stepOut").1, line(SCAN, "let at = texel") as u64);
    assert_eq!(client.value("i"), "9");
    assert_eq!(client.go("continue"), ("breakpoint".into(), at as u64));
    // The sum of the numbers 2 to 9 of 0, 1, 2, 0, …
    assert_eq!((client.value("sum"), client.value("row[now][lane - reach]")), ("9".into(), "1".into()));
    let module = client.scope(1, "Module");
    assert!(module.iter().any(|(name, ..)| name == "row"), "{module:?}");
    assert!(client.scope(1, "Thread").iter().any(|(name, value, _)| name == "local_invocation_index" && value == "9"));
    // An index that is out of range.
    let source = SCAN.replacen("row[0][lane] = own;", "row[0][select(lane, 999u, lane == 9u)] = own;", 1);
    std::fs::write(&path, source).expect("written");
    let mut again = launch;
    again["stopOnEntry"] = json!(false);
    client.ok("restart", json!({ "arguments": again }));
    assert_eq!(client.stopped(), ("exception".into(), line(SCAN, "row[0][lane]") as u64));
    let why = client.ok("exceptionInfo", json!({ "threadId": 1 }));
    assert!(why["description"].as_str().is_some_and(|why| why.contains("is outside of")), "{why}");
    assert_eq!(client.go("stepBack").0, "step");
    client.end();
}

#[test]
fn a_ray_is_followed_through_a_kernel_of_ours() {
    let place = Place::new();
    let mut client = Client::new(&place);
    client.ok("initialize", json!({}));
    let wrong =
        client.ask("launch", json!({ "program": cornell_box(), "kernel": "intersekt", "args": ["--size", "16x12"] }));
    assert!(wrong["message"].as_str().is_some_and(|why| why.contains("did you mean intersect")), "{wrong}");
    // The first ray that comes to this line, in its pass.
    let found = place.ok(&["stop", &cornell_box(), "--at", "intersect:57", "--size", "16x12", "--quiet"]).stdout;
    let pass: u32 = found.split([' ', ',']).nth(1).and_then(|word| word.parse().ok()).expect("a pass");
    let pixel = found.lines().nth(2).expect("a pixel").trim().split(',').map(|n| n.parse::<u32>().expect("a number"));
    let launch = json!({
        "program": cornell_box(), "pass": pass, "element": pixel.collect::<Vec<_>>(), "args": ["--size", "16x12"],
    });
    client.ok("launch", launch);
    client.event("initialized");
    let set = json!({ "source": { "name": "intersect.wgsl" }, "breakpoints": [{ "line": 57 }] });
    assert_eq!(client.ok("setBreakpoints", set)["breakpoints"][0]["verified"], true);
    client.ok("configurationDone", json!({}));
    assert_eq!(client.stopped(), ("breakpoint".into(), 57));
    assert!(client.value("candidate.t").parse::<f32>().is_ok() && client.value("candidate.t > 0.0 || true") == "true");
    let streams = client.scope(1, "Streams");
    assert!(streams.iter().any(|(name, value, _)| name == "state.tag" && value.starts_with("ISECT")), "{streams:?}");
    assert_eq!(
        client.scope(2, "Locals").iter().map(|(name, ..)| &**name).collect::<Vec<_>>(),
        ["id", "group", "lane", "texel"]
    );
    client.end();
}
