//! The columns of files about kernels, and about the paper.

use super::{Column, count, number, text};

/// All of them, but for those that other files have, too.
pub(super) const OF_KERNELS: &[Column] = &[
    count("elements", "rays that the kernel worked on, added over its passes"),
    number("float_operations", "operations on floats, per element"),
    number("integer_operations", "operations on integers, and conversions, per element"),
    number("comparisons", "comparisons, selections and logical operations, per element"),
    number("stream_bytes_read", "bytes loaded from streams, per element"),
    number("stream_bytes_written", "bytes stored to streams, per element"),
    number("buffer_bytes_read", "bytes loaded from buffers of the scene, per element"),
    number("uniform_bytes_read", "bytes loaded from uniforms, per element; they are not part of the ratios"),
    number("float_operations_per_byte", "operations on floats divided by the bytes of streams and buffers"),
    number("operations_per_byte", "all operations divided by the bytes of streams and buffers"),
    text("file", "the file of WGSL"),
    count("line", "the line of the file, from 1"),
    count("line_runs", "how often the line ran: the statement or condition of it that ran most often"),
    text("text", "the text of the line"),
    text("paper_kernel", "the kernel's name in the paper"),
    text("paper_streams", "its output textures in the paper"),
    text("streams", "the streams that it writes here"),
    text("difference", "what is written here only, or in the paper only, and why"),
    text("strategy", "the paper's name of the schedule; empty without a grid"),
    number("paper_s", "seconds to render in the paper"),
    number("paper_by_here", "the paper's time divided by the median time here"),
    text("paper", "the number in the paper"),
    text("here", "the number here"),
];
