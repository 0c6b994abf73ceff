//! One-step parity on the tests' GPU; see [`raystep_lab::parity`].

use std::sync::Arc;

use raystep_kernels::{Gpu, Limits, Options, Plan};
use raystep_lab::parity::compare as compare_each;
pub use raystep_lab::parity::{Breach, Parity};
use raystep_scenes::Scene;

use crate::block_on;

/// Runs a scene on the GPU and compares every pass with the twin.
#[must_use]
pub fn compare(gpu: &Arc<Gpu>, scene: &Scene, options: &Options) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), |_| {}, |_| false)
}

/// The same with so few loop iterations per dispatch that walks, searches and sums of light continue in the next one.
#[must_use]
pub fn compare_in_turns(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, turns: u32) -> Parity {
    run(gpu, scene, options, &Limits { turns, ..Limits::from(&**gpu) }, |_| {}, |_| false)
}

/// The same after `change` has modified the plan.
#[must_use]
pub fn compare_changed(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, |_| false)
}

/// The same, up to the first pass that differs. A deliberately broken plan shows that the comparison can fail.
#[must_use]
pub fn compare_broken(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    run(gpu, scene, options, &Limits::from(&**gpu), change, Parity::is_broken)
}

/// The same with few loop iterations per dispatch.
#[must_use]
pub fn compare_broken_in_turns(
    gpu: &Arc<Gpu>,
    scene: &Scene,
    options: &Options,
    turns: u32,
    change: impl FnOnce(&mut Plan),
) -> Parity {
    run(gpu, scene, options, &Limits { turns, ..Limits::from(&**gpu) }, change, Parity::is_broken)
}

fn run(
    gpu: &Arc<Gpu>,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
    change: impl FnOnce(&mut Plan),
    is_enough: impl Fn(&Parity) -> bool,
) -> Parity {
    block_on(Some(gpu), compare_each(gpu, scene, options, limits, change, is_enough)).expect("a comparison")
}

/// A kernel's WGSL with `from` replaced by `to`, ignoring white space, since each break is written on one line.
///
/// # Panics
/// If the WGSL does not contain `from`.
#[must_use]
pub fn change(source: &str, from: &str, to: &str) -> String {
    changed(source, from, to).unwrap_or_else(|| panic!("{from:?} is not in\n{source}"))
}

/// The same; `None` if the WGSL does not contain `from`.
#[must_use]
pub fn changed(source: &str, from: &str, to: &str) -> Option<String> {
    Some(replace_ignoring_layout(source, from, to)).filter(|changed| changed != source)
}

/// Replaces every occurrence of `from`, whatever white space is between its characters.
fn replace_ignoring_layout(source: &str, from: &str, to: &str) -> String {
    let wanted: Vec<char> = from.chars().filter(|c| !c.is_whitespace()).collect();
    let mut out = String::new();
    let mut rest = source;
    'outer: while !rest.is_empty() {
        let mut matched = wanted.iter();
        for (at, c) in rest.char_indices() {
            if c.is_whitespace() && at > 0 {
                continue;
            }
            match matched.next() {
                Some(&w) if w == c => {
                    if matched.as_slice().is_empty() {
                        out.push_str(to);
                        rest = &rest[at + c.len_utf8()..];
                        continue 'outer;
                    }
                }
                _ => break,
            }
        }
        let first = rest.chars().next().unwrap_or(' ');
        out.push(first);
        rest = &rest[first.len_utf8()..];
    }
    out
}
