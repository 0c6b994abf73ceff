//! The buffers that the build reads, in one table.

use bytemuck::{bytes_of, cast_slice};

use crate::options::reasons::{Because, Reason, Run};
use crate::scene_data::buffer::{BufferInfo, storage, uniform};

fn always(_: &Run<'_>) -> Reason {
    (Because::Options, "every build reads it")
}

/// Every buffer.
pub static BUFFERS: [BufferInfo; 2] = [
    uniform(
        "build",
        "corner, growth, cell width, triangles, cells; traced units",
        |data| bytes_of(&data.build),
        always,
    ),
    storage(
        "vertices",
        "nine f32 a triangle: corners 0, 1, 2, traced units",
        |data| cast_slice(&data.vertices),
        always,
    ),
];
