//! Streams by name: what is saved, and links, have names; sessions have rows of a program's table.

use raystep_kernels::Stream;
use raystep_kernels::programs::stream;
use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// Reads a stream that was saved: `#[serde(deserialize_with = …)]`.
pub(crate) fn saved_stream<'de, D: Deserializer<'de>>(from: D) -> Result<Stream, D::Error> {
    let name = String::deserialize(from)?;
    stream(&name).ok_or_else(|| D::Error::custom(format!("there is no stream {name:?}")))
}

/// The same where there may be none.
pub(crate) fn maybe_saved_stream<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Stream>, D::Error> {
    let Some(name) = Option::<String>::deserialize(from)? else { return Ok(None) };
    stream(&name).map(Some).ok_or_else(|| D::Error::custom(format!("there is no stream {name:?}")))
}
