//! Requests, and what answers each.

use serde_json::{Value, json};

use super::reply::{Refused, Reply, text, whole};
use super::session::{Go, Session};
use super::target::Target;
use super::wire::Wire;
use crate::error::Error;

/// Answers requests.
pub(super) struct Adapter<'a> {
    wire: Wire<'a>,
    session: Option<Session>,
    /// What was launched.
    launched: Value,
    /// Lines and columns as the client counts them begin with 1.
    is_configured: bool,
}

/// What follows an answer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Then {
    Nothing,
    Initialized,
    Stopped,
    Terminated,
    Ends,
}

impl<'a> Adapter<'a> {
    pub(super) fn new(wire: Wire<'a>) -> Self {
        Self { wire, session: None, launched: Value::Null, is_configured: false }
    }

    /// Answers a message. Returns false after the last.
    pub(super) fn answer(&mut self, message: &Value) -> Result<bool, Error> {
        let failed = |error: std::io::Error| Error::failed(format!("cannot write: {}", crate::error::reason(&error)));
        if text(message, "type") != Some("request") {
            return Ok(true);
        }
        let none = json!({});
        let (command, arguments) = (text(message, "command").unwrap_or_default(), message.get("arguments"));
        let mut then = Then::Nothing;
        let reply = self.perform(command, arguments.unwrap_or(&none), &mut then);
        let sequence = message.get("seq").cloned().unwrap_or(json!(0));
        let mut response = json!({ "type": "response", "request_seq": sequence, "command": command });
        match reply {
            Ok(body) => {
                response["success"] = json!(true);
                response["body"] = body;
            }
            Err(Refused(why)) => {
                then = Then::Nothing;
                response["success"] = json!(false);
                response["message"] = json!(why);
                response["body"] =
                    json!({ "error": { "id": 1, "format": "{why}", "variables": { "why": why }, "showUser": true } });
            }
        }
        self.wire.send(response).map_err(failed)?;
        self.follow_up(then).map_err(failed)?;
        Ok(then != Then::Ends)
    }

    fn follow_up(&mut self, then: Then) -> std::io::Result<()> {
        match then {
            Then::Nothing => Ok(()),
            Then::Initialized => self.wire.event("initialized", json!({})),
            Then::Stopped => match &self.session {
                Some(session) => self.wire.event("stopped", session.stopped()),
                None => Ok(()),
            },
            Then::Terminated | Then::Ends => self.wire.event("terminated", json!({})),
        }
    }

    fn session(&mut self) -> Result<&mut Session, Refused> {
        self.session.as_mut().ok_or_else(|| "nothing is launched".into())
    }

    fn perform(&mut self, command: &str, arguments: &Value, then: &mut Then) -> Reply {
        match command {
            "initialize" => Ok(capabilities()),
            "launch" => self.launch(arguments, then),
            "configurationDone" => {
                self.is_configured = true;
                self.begin(then)
            }
            "disconnect" | "terminate" => {
                *then = Then::Ends;
                Ok(json!({}))
            }
            "setExceptionBreakpoints" => Ok(json!({})),
            "threads" => {
                let name = self.session()?.thread();
                Ok(json!({ "threads": [{ "id": 1, "name": name }] }))
            }
            "setBreakpoints" => {
                let is_configured = self.is_configured;
                let session = self.session()?;
                let set = session.breakpoints.set(&session.target, arguments);
                if is_configured {
                    session.follow()?;
                }
                Ok(json!({ "breakpoints": set }))
            }
            "stackTrace" => {
                let (first, count) = (whole(arguments, "startFrame"), whole(arguments, "levels"));
                self.session()?.stack(first.unwrap_or(0), count.unwrap_or(0))
            }
            "scopes" => self.session()?.scopes(whole(arguments, "frameId").unwrap_or(0)),
            "variables" => {
                let number = whole(arguments, "variablesReference").unwrap_or(0);
                let (first, count) = (whole(arguments, "start"), whole(arguments, "count"));
                self.session()?.variables(number, first.unwrap_or(0), count.unwrap_or(0))
            }
            "evaluate" => self.session()?.evaluate(arguments),
            "source" => self.session()?.text(arguments),
            "loadedSources" => Ok(self.session()?.sources()),
            "exceptionInfo" => {
                let why = self.session()?.failure().ok_or("nothing has failed")?;
                Ok(json!({ "exceptionId": "interpreter", "description": why, "breakMode": "always" }))
            }
            "continue" => self.go(Go::On, then),
            "next" => self.go(Go::Over, then),
            "stepIn" => self.go(Go::Into, then),
            "stepOut" => self.go(Go::Out, then),
            "stepBack" => self.go(Go::Back, then),
            "reverseContinue" => self.go(Go::ReverseOn, then),
            "pause" => {
                *then = Then::Stopped;
                Ok(json!({}))
            }
            "restart" => match arguments.get("arguments").filter(|again| **again != self.launched && again.is_object())
            {
                Some(again) => self.relaunch(&again.clone(), then),
                None => self.begin(then),
            },
            "raystep/element" => {
                let element = arguments.get("element").ok_or("raystep/element needs \"element\": [x, y]")?;
                self.session()?.target.choose(element)?;
                self.launched["element"] = element.clone();
                self.begin(then)
            }
            other => Err(Refused(format!("{other} is not supported"))),
        }
    }

    fn launch(&mut self, arguments: &Value, then: &mut Then) -> Reply {
        self.session = Some(Session::new(Target::launch(arguments)?));
        (self.launched, self.is_configured) = (arguments.clone(), false);
        *then = Then::Initialized;
        Ok(json!({}))
    }

    /// Launches with other arguments, and the breakpoints in files that stay.
    fn relaunch(&mut self, arguments: &Value, then: &mut Then) -> Reply {
        let target = Target::launch(arguments)?;
        let is_same =
            self.session.as_ref().is_some_and(|session| session.target.of.variant.source == target.of.variant.source);
        let breakpoints = self.session.take().filter(|_| is_same).map(|session| session.breakpoints);
        let mut session = Session::new(target);
        session.breakpoints = breakpoints.unwrap_or_default();
        (self.session, self.launched) = (Some(session), arguments.clone());
        self.begin(then)
    }

    fn begin(&mut self, then: &mut Then) -> Reply {
        let stops_at_once = self.launched.get("stopOnEntry").and_then(Value::as_bool).unwrap_or_default();
        self.session()?.begin(stops_at_once)?;
        *then = Then::Stopped;
        Ok(json!({}))
    }

    fn go(&mut self, go: Go, then: &mut Then) -> Reply {
        *then = if self.session()?.go(go) { Then::Stopped } else { Then::Terminated };
        Ok(json!({ "allThreadsContinued": true }))
    }
}

fn capabilities() -> Value {
    json!({
        "supportsConfigurationDoneRequest": true,
        "supportsConditionalBreakpoints": true,
        "supportsEvaluateForHovers": true,
        "supportsStepBack": true,
        "supportsRestartRequest": true,
        "supportsExceptionInfoRequest": true,
        "supportsLoadedSourcesRequest": true,
        "supportsTerminateRequest": true,
    })
}
