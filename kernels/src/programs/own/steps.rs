//! The schedule of `program.toml`.

use std::ops::Range;

use toml::Spanned;

use super::manifest::{Awaited, Number, Step as Written};
use super::reader::listed;
use crate::program::Program;
use crate::program::schedule::{Count, MOST_PASSES, Schedule, Step};
use crate::tables::elements::{Count as Counted, Elements};

/// The schedule of these steps, or what is wrong with one of them, and its place.
pub(super) fn schedule(
    program: &'static Program,
    steps: &[Spanned<Written>],
) -> Result<Schedule, (Range<usize>, String)> {
    let mut passes = 0;
    let steps = list(program, steps, &mut Vec::new(), 1, &mut passes)?;
    Ok(Schedule { steps })
}

/// `turns` are the most turns of the loops around the steps, outermost first, and `times` their product.
fn list(
    program: &'static Program,
    steps: &[Spanned<Written>],
    turns: &mut Vec<u64>,
    times: u64,
    passes: &mut u64,
) -> Result<Vec<Step>, (Range<usize>, String)> {
    let mut all = Vec::new();
    for step in steps {
        let wrong = |message: String| (step.span(), message);
        let kernel = |name: &str| {
            program.kernel(name).ok_or_else(|| {
                let names = listed("kernels", program.kernels.iter().map(|kernel| kernel.name));
                wrong(format!("no kernel is named {name}; {names}"))
            })
        };
        let written = step.get_ref();
        let body = written.steps.as_deref();
        let ways = [
            ("run", written.run.is_some()),
            ("repeat", written.repeat.is_some()),
            ("while_any", written.while_any.is_some()),
            ("until_idle", written.until_idle.is_some()),
        ];
        let given: Vec<&str> = ways.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| *name).collect();
        let &[way] = given.as_slice() else {
            return Err(wrong("a step has one of run, repeat, while_any and until_idle".into()));
        };
        let is_loop = matches!(way, "repeat" | "while_any");
        if is_loop != body.is_some() {
            return Err(wrong(match is_loop {
                true => format!("`{way}` needs the steps that it repeats: steps = […]"),
                false => format!("`{way}` runs one kernel and takes no `steps`"),
            }));
        }
        if written.parameter.is_some() && way != "run" {
            return Err(wrong("`parameter` is allowed only in a `run` step".into()));
        }
        if written.name.is_some() && way != "repeat" {
            return Err(wrong("`name` is allowed only in a `repeat` step".into()));
        }
        let inside = |turns: &mut Vec<u64>, most: u64, passes: &mut u64| {
            turns.push(most);
            let times = times.saturating_mul(most);
            let steps = list(program, body.unwrap_or_default(), turns, times, passes);
            turns.pop();
            steps
        };
        all.push(match written {
            Written { run: Some(name), parameter: None, .. } => Step::Run(kernel(name)?),
            Written { run: Some(name), parameter: Some(number), .. } => Step::RunBy(kernel(name)?, count(number)),
            Written { until_idle: Some(name), .. } => {
                let kernel = kernel(name)?;
                if kernel.takes().is_empty() {
                    return Err(wrong(format!("{name} takes no states, so it is never idle")));
                }
                Step::RunUntilIdle(kernel)
            }
            Written { repeat: Some(number), name, .. } => {
                let count = count(number);
                let most = most(count, turns);
                let name = Box::leak(name.clone().unwrap_or_else(|| "turn".into()).into_boxed_str());
                Step::Repeat(name, count, inside(turns, most, passes)?)
            }
            Written { while_any: Some(Awaited::Set(name)), .. } => {
                let set = program.elements(name).ok_or_else(|| {
                    wrong(format!("no set is named {name}: while_any has a set, or a list of kernels as [\"{name}\"]"))
                })?;
                let body = inside(turns, 1, passes)?;
                if !may_end(set, &body) {
                    return Err(wrong(format!(
                        "no kernel in these steps counts {name} again, so they are repeated without end: a kernel that \
                         runs after the one that stores the number needs renews = [\"{name}\"]"
                    )));
                }
                Step::RepeatWhileAny(set, body)
            }
            Written { while_any: Some(Awaited::Kernels(names)), .. } => {
                let kernels = names.iter().map(|name| kernel(name)).collect::<Result<Vec<_>, _>>()?;
                if kernels.iter().all(|kernel| kernel.takes().is_empty()) {
                    return Err(wrong(
                        "none of these kernels takes states, so no element is ever active in them".into(),
                    ));
                }
                Step::LoopWhileActive(kernels, inside(turns, 1, passes)?)
            }
            _ => return Err(wrong("not a step".into())),
        });
        if !is_loop {
            *passes = passes.saturating_add(times);
        }
        if *passes > MOST_PASSES {
            return Err(wrong(format!("with this step a run has more than {MOST_PASSES} passes")));
        }
    }
    Ok(all)
}

/// Whether a loop over a set that kernels count can end: in its body, the number is read again.
fn may_end(set: &Elements, body: &[Step]) -> bool {
    let is_counted = matches!(set.count, Counted::Found { .. });
    let kernels = Schedule { steps: body.to_vec() }.kernels();
    let is_renewed = kernels.iter().map(|kernel| kernel.instance()).any(|instance| {
        instance.renews.iter().any(|renewed| renewed.name == set.name)
            || instance.adopts.iter().any(|(to, _)| to.info().elements.name == set.name)
    });
    !is_counted || is_renewed
}

fn count(number: &Number) -> Count {
    match number {
        Number::Always(number) => Count::always(*number),
        Number::Counted { first, by } => Count { first: *first, by: Vec::leak(by.clone()) },
    }
}

/// A bound of a number in loops of so many turns, outermost first.
fn most(count: Count, turns: &[u64]) -> u64 {
    let add =
        |sum: u64, (&by, &most): (&u32, &u64)| sum.saturating_add(u64::from(by).saturating_mul(most.saturating_sub(1)));
    count.by.iter().zip(turns.iter().rev()).fold(u64::from(count.first), add).min(u64::from(u32::MAX))
}
