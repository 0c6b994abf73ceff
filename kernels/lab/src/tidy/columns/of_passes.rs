//! The columns of `passes.csv`, and of what is about single passes.

use super::{Column, count, number, text, truth};

/// All of them, but for those that other files have, too.
pub(super) const OF_PASSES: &[Column] = &[
    count(
        "repeat",
        "repetition of the run whose passes these are, from 0; a benchmark times the passes of one run per configuration, \
         which is not among those of runs.csv",
    ),
    truth("is_warmup", "whether the repetition was only a warm-up"),
    count("pass_index", "index of a pass in its run, from 0"),
    count("sample", "sample of every pixel that the pass belongs to, from 0"),
    count(
        "iteration",
        "iterations of the schedule's loop of traverse and intersect that have begun in this sample: 0 before the loop, \
         and always 0 in schedules without one: compact, fused, and all without an acceleration structure",
    ),
    text("kernel", "the kernel that ran"),
    text("mapping", "how kernels are mapped to the GPU: compute, or fragment and its choices"),
    text(
        "integrator",
        "the light that is computed, as in render --integrator; of a benchmark, local where only hits are measured",
    ),
    text("traversal", "how rays walk through a uniform grid: amanatides-woo or 3d-dda"),
    text(
        "loops",
        "turns of the schedule's loops that the pass is in, from 0, outermost loop first, separated by spaces",
    ),
    count(
        "draw",
        "part of a pass that is drawn, from 0: copies, depths, draws of the kernel; what belongs to the whole pass (rays, \
         counters, time to record) is in the row of its last part",
    ),
    text("targets", "streams that the part writes"),
    count("fragments_run", "fragments for which a draw ran its program; known if they were asked for"),
    count("bytes_copied", "bytes that the part copies"),
    count(
        "begin_ns",
        "begin of the pass, or of its part that is drawn, by the clock, since the run's first timed pass began; empty from \
         the pass on at which that clock was set back",
    ),
    count("duration_ns", "duration of the pass, or of its part that is drawn, by the clock"),
    count(
        "encode_ns",
        "time that the host took to record the commands of the pass, by its own clock; empty on the CPU, which records none",
    ),
    count(
        "rays_in",
        "rays in one of the kernel's states before the pass: those it worked on; where a grid is built, elements such as \
         triangles or cells",
    ),
    count(
        "rays_out",
        "those of them that the pass moved to a state of another kernel; empty for kernels whose elements have no states",
    ),
    count("threads_launched", "threads launched by the pass, or by its part, with or without a ray to work on"),
    count(
        "cells_visited",
        "cells or nodes visited: by a pass, known if counters were requested; or by the farthest ray of a walk",
    ),
    count("triangles_tested", "triangles tested by a pass; known if counters were requested"),
    count(
        "repeated_tests",
        "those of a pass's tests whose triangle the ray had already met in an earlier cell; known if counters were \
         requested, with one step per pass, without a BVH",
    ),
    number("clock_resolution_ns", "smallest step of the clock"),
    truth("valid", "whether the timer gave a duration; empty if nothing was timed"),
    count(
        "host_run_ns",
        "time of all passes of the run by the host's clock, including waits for the device, without what was done between \
         submissions",
    ),
    count("duration_runs", "how often the pass was run to time it; known if the clock is coarse"),
    count("duration_error_ns", "largest standard error of the duration by rounding; known if the clock is coarse"),
    count("duration_below_ns", "what the duration is certainly less than; known if the clock is coarse"),
];
