//! Arguments of requests, and why they fail.

use serde_json::Value;

use crate::error::Error;

/// Why a request failed, on one line for people.
#[derive(Debug)]
pub(super) struct Refused(pub(super) String);

pub(super) type Reply = Result<Value, Refused>;

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Self(error.message().to_owned())
    }
}

impl From<&str> for Refused {
    fn from(why: &str) -> Self {
        Self(why.to_owned())
    }
}

impl From<String> for Refused {
    fn from(why: String) -> Self {
        Self(why)
    }
}

/// A member that is a whole number.
pub(super) fn whole(arguments: &Value, name: &str) -> Option<usize> {
    arguments.get(name)?.as_u64().and_then(|number| usize::try_from(number).ok())
}

/// A member that is text.
pub(super) fn text<'a>(arguments: &'a Value, name: &str) -> Option<&'a str> {
    arguments.get(name)?.as_str()
}
