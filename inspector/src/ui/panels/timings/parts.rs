//! Device time of the copies and draws that passes consist of, if kernels are fragment programs.

use raystep_kernels::executor::DrawTime;
use raystep_kernels::export::csv::DrawnPart;
use raystep_kernels::plan::{Bytes, Plan};
use raystep_kernels::{Kernel, Pass};

use super::duration;
use crate::ui::panels::chart::kernel_color;
use crate::ui::panels::table::{Head, Listed, ListedCell, Look};

/// The heads.
pub(super) const HEADS: [Head<'static>; 7] = [
    Head::text("kernel", "the kernel whose passes it is a part of"),
    Head::text(
        "part",
        "copies of streams, the draw of depths, or a draw of the kernel with the streams that it writes",
    ),
    Head::number("times", "number of passes with this part"),
    Head::number("sum", "total device time; compared in ns"),
    Head::number("mean", "mean duration; compared in ns"),
    Head::number("share", "percentage of the time of all parts"),
    Head::number("copied", "bytes copied; compared in bytes"),
];

/// The same part of all passes of a kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PartTimes {
    kernel: Kernel,
    name: String,
    times: u64,
    timed: u64,
    sum_ns: u64,
    bytes: u64,
}

/// The parts of all passes, in order of first use.
fn by_part(plan: &Plan, passes: &[Pass], draws: &[Vec<DrawTime>]) -> Vec<PartTimes> {
    let mut all: Vec<PartTimes> = Vec::new();
    for (pass, draws) in passes.iter().zip(draws) {
        for part in DrawnPart::of(plan, pass, draws) {
            let name = part.name();
            let at = all.iter().position(|p| p.kernel == pass.kernel && p.name == name).unwrap_or_else(|| {
                all.push(PartTimes { kernel: pass.kernel, name, times: 0, timed: 0, sum_ns: 0, bytes: 0 });
                all.len() - 1
            });
            let times = &mut all[at];
            times.times += 1;
            times.bytes += part.bytes_copied;
            if let Some(ns) = part.time.duration_ns {
                times.timed += 1;
                times.sum_ns = times.sum_ns.saturating_add(ns);
            }
        }
    }
    all
}

/// The parts as rows.
pub(super) fn listed(plan: &Plan, passes: &[Pass], draws: &[Vec<DrawTime>]) -> Listed {
    let parts = by_part(plan, passes, draws);
    let whole: u64 = parts.iter().map(|part| part.sum_ns).sum();
    let unknown = || ListedCell::text("unknown");
    let row = |part: &PartTimes| {
        let time = |ns: u64| match part.timed {
            0 => unknown(),
            _ => ListedCell::number(ns as f64, duration(ns)).about(format!("{ns} ns")),
        };
        let share = part.sum_ns as f64 / whole.max(1) as f64;
        let bar = Some((share as f32, kernel_color(part.kernel).gamma_multiply(0.3)));
        let percent = ListedCell::number(share * 100.0, format!("{:.1}%", share * 100.0));
        let swatch = Look { swatch: Some(kernel_color(part.kernel)), ..Look::default() };
        let copied = match part.bytes {
            0 => ListedCell::text("–"),
            bytes => ListedCell::number(bytes as f64, Bytes(bytes).to_string()).about(format!("{bytes} bytes")),
        };
        vec![
            ListedCell::text(part.kernel.name()).look(swatch),
            ListedCell::text(&part.name),
            ListedCell::number(part.times as f64, part.times.to_string()),
            time(part.sum_ns),
            time(part.sum_ns / part.timed.max(1)),
            if part.timed > 0 { percent.look(Look { bar, ..Look::default() }) } else { unknown() },
            copied,
        ]
    };
    Listed { rows: parts.iter().map(row).collect() }
}
