//! The inspector without a window: links, data flow, sources, exports.

mod common;
mod dataflow;
mod exports;
mod interpret;
mod link;
mod source;
