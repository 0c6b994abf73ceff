//! Which lines of a kernel's files the options leave out.

use raystep_kernels::compose::left_out;
use raystep_kernels::options::features::Features;

use super::{Mark, functions};

/// A mark for every line. `composed` is the source for the device, where there is one.
pub(super) fn marks(module: &str, text: &str, composed: Option<&str>, features: &Features) -> Vec<Mark> {
    let mut marks = vec![Mark::Plain; text.split('\n').count()];
    let options = features.list();
    let option = |name: &str| options.iter().find(|o| o.0 == name).map(|o| o.1);
    let Ok(ranges) = left_out(module, text, &option) else { return marks };
    let line = |byte: usize| text.bytes().take(byte).filter(|&b| b == b'\n').count();
    let ranges = ranges.into_iter().map(|bytes| line(bytes.start)..line(bytes.end.saturating_sub(1)) + 1);
    let dropped = composed.map_or_else(Vec::new, |composed| functions::dropped(text, composed));
    for lines in ranges.chain(dropped) {
        marks.iter_mut().take(lines.end).skip(lines.start).for_each(|mark| *mark = Mark::LeftOut);
    }
    let is_bare = |line: &str| line.is_empty() || line.starts_with("//");
    let lines = text.split('\n').map(str::trim);
    marks.iter().zip(lines).map(|(&mark, line)| if is_bare(line) { Mark::Plain } else { mark }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_branch_of_a_conditional_that_holds_is_kept() {
        let text = "@if(grid) const A = 1u;\n@else @if(bvh) const A = 2u;\n@else const A = 3u;\n\
                    fn setup() {\n    @if(grid) x();\n    @else @if(bvh) y();\n    @else z();\n}\n";
        for (grid, bvh, kept) in [(true, true, 0), (true, false, 0), (false, true, 1), (false, false, 2)] {
            let features = Features { grid, bvh, ..Features::default() };
            let marks = marks("setup", text, None, &features);
            let left_out: Vec<usize> = (0..marks.len()).filter(|&line| marks[line] == Mark::LeftOut).collect();
            let expected: Vec<usize> = [0, 1, 2, 4, 5, 6].into_iter().filter(|line| line % 4 != kept).collect();
            assert_eq!(left_out, expected, "{grid} {bvh}");
        }
    }

    #[test]
    fn a_function_that_nothing_calls_is_left_out() {
        let text = "fn setup() {\n    x();\n}\n\n// Two of them.\nfn x() {}\n\
                    fn y(\n    a: u32,\n) {\n    // No code.\n    z();\n}\n";
        let marks = marks("setup", text, Some("fn x() {}\nfn setup() {\n    x();\n}\n"), &Features::default());
        let left_out: Vec<usize> = (0..marks.len()).filter(|&line| marks[line] == Mark::LeftOut).collect();
        assert_eq!(left_out, [6, 7, 8, 10, 11]);
    }
}
