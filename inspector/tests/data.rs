//! What the inspector knows without a window: links, data flow, sources, exports.

#[path = "data/common.rs"]
mod common;
#[path = "data/dataflow.rs"]
mod dataflow;
#[path = "data/exports.rs"]
mod exports;
#[path = "data/link.rs"]
mod link;
#[path = "data/source.rs"]
mod source;
