//! Which lines of a kernel's file the options leave out.

use raystep_kernels::compose::left_out;
use raystep_kernels::options::features::Features;

use super::Mark;

/// A mark for every line.
pub(super) fn marks(module: &str, text: &str, features: &Features) -> Vec<Mark> {
    let mut marks = vec![Mark::Plain; text.split('\n').count()];
    let options = features.list();
    let option = |name: &str| options.iter().find(|o| o.0 == name).map(|o| o.1);
    let Ok(ranges) = left_out(module, text, &option) else { return marks };
    let line = |byte: usize| text.bytes().take(byte).filter(|&b| b == b'\n').count();
    for range in ranges {
        for mark in marks.iter_mut().take(line(range.end.saturating_sub(1)) + 1).skip(line(range.start)) {
            *mark = Mark::LeftOut;
        }
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
            let marks = marks("setup", text, &features);
            let left_out: Vec<usize> = (0..marks.len()).filter(|&line| marks[line] == Mark::LeftOut).collect();
            let expected: Vec<usize> = [0, 1, 2, 4, 5, 6].into_iter().filter(|line| line % 4 != kept).collect();
            assert_eq!(left_out, expected, "{grid} {bvh}");
        }
    }
}
