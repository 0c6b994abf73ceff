//! What the inspector knows without a window: links, data flow, sources, exports.

#[path = "data/link.rs"]
mod link;
